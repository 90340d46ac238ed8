// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/robot/srdf.hpp"

#include <cstring>

#include "core/base/text.hpp"
#include "types_lfd/xml/xml_reader.hpp"

namespace graft::lfd {

namespace {

Srdf read(const XmlFile& file, const UrdfModel& model, Diagnostics& diagnostics) {
  const tinyxml2::XMLElement& root = file.root();
  if (std::strcmp(root.Name(), "robot") != 0) {
    file.fail(root, "expected <robot>, found <" + std::string(root.Name()) + ">");
  }
  const std::string name = file.required(root, "name");
  if (name != model.name) {
    file.fail(root,
              "this describes the robot " + quoted(name) + ", the URDF " + quoted(model.name));
  }
  Srdf srdf;
  for (const auto* e = root.FirstChildElement("disable_collisions"); e != nullptr;
       e = e->NextSiblingElement("disable_collisions")) {
    std::string a = file.required(*e, "link1");
    std::string b = file.required(*e, "link2");
    for (const std::string& link : {a, b}) {
      if (model.findLink(link) < 0) {
        diagnostics.warning(file.at(*e), "the URDF has no link " + quoted(link));
      }
    }
    if (b < a) std::swap(a, b);
    srdf.disabled.emplace(std::move(a), std::move(b));
  }
  return srdf;
}

}  // namespace

Srdf readSrdf(const std::string& path, const UrdfModel& model, Diagnostics& diagnostics) {
  return read(XmlFile(path), model, diagnostics);
}

Srdf readSrdfText(const std::string& path, const std::string& content, const UrdfModel& model,
                  Diagnostics& diagnostics) {
  return read(XmlFile(path, content), model, diagnostics);
}

}  // namespace graft::lfd
