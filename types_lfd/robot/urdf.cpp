// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/robot/urdf.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/text.hpp"
#include "types_lfd/xml/xml_reader.hpp"

namespace graft::lfd {

namespace {

using tinyxml2::XMLElement;

// A limit beyond this is a typing error or "no limit" in disguise.
constexpr double kLargestLimit = 1e4;
constexpr double kLargestLength = 1e4;

Eigen::Vector3d vector3(const XmlFile& file, const XMLElement& element, const char* name) {
  const std::vector<double> v = file.numbers(element, name, 3);
  return {v[0], v[1], v[2]};
}

double optionalNumber(const XmlFile& file, const XMLElement& element, const char* name,
                      double otherwise) {
  return file.has(element, name) ? file.number(element, name) : otherwise;
}

/// URDF's fixed-axis roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Quaterniond fromRpy(const Eigen::Vector3d& rpy) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(rpy[2], Eigen::Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(rpy[1], Eigen::Vector3d::UnitY()) *
                            Eigen::AngleAxisd(rpy[0], Eigen::Vector3d::UnitX()));
}

Pose readOrigin(const XmlFile& file, const XMLElement& owner) {
  Pose pose;
  const XMLElement* origin = owner.FirstChildElement("origin");
  if (origin == nullptr) return pose;
  if (file.has(*origin, "xyz")) pose.translation = vector3(file, *origin, "xyz");
  if (pose.translation.cwiseAbs().maxCoeff() > kLargestLength) {
    file.fail(*origin, "attribute 'xyz' of <origin>: longer than 10 km");
  }
  if (file.has(*origin, "rpy")) pose.rotation = fromRpy(vector3(file, *origin, "rpy"));
  return pose;
}

std::string readName(const XmlFile& file, const XMLElement& element, const char* attribute) {
  std::string name = file.required(element, attribute);
  const bool bad =
      std::any_of(name.begin(), name.end(), [](unsigned char c) { return c <= 0x20 || c == 0x7f; });
  if (name.empty() || bad) {
    file.fail(element, std::string("attribute '") + attribute + "' of <" + element.Name() +
                           ">: " + quoted(name) + " is not a name (empty, or with blanks)");
  }
  return name;
}

UrdfJoint::Type jointType(const XmlFile& file, const XMLElement& element) {
  const std::string type = file.required(element, "type");
  if (type == "fixed") return UrdfJoint::Type::kFixed;
  if (type == "revolute") return UrdfJoint::Type::kRevolute;
  if (type == "continuous") return UrdfJoint::Type::kContinuous;
  if (type == "prismatic") return UrdfJoint::Type::kPrismatic;
  if (type == "planar" || type == "floating") return UrdfJoint::Type::kOther;
  file.fail(element, "unknown joint type " + quoted(type));
}

void readAxis(const XmlFile& file, const XMLElement& element, UrdfJoint& joint,
              Diagnostics& diagnostics) {
  const XMLElement* axis = element.FirstChildElement("axis");
  if (axis == nullptr) return;
  joint.axis = vector3(file, *axis, "xyz");
  const double length = joint.axis.norm();
  if (!(length > 1e-9) || !std::isfinite(length)) {
    file.fail(*axis, "the axis of joint " + quoted(joint.name) + " has no direction");
  }
  if (std::abs(length - 1) > 1e-3) {
    diagnostics.warning(file.at(*axis), "the axis of joint " + quoted(joint.name) + " has length " +
                                            formatDouble(length) + "; scaled to 1");
  }
  joint.axis /= length;
}

void readLimit(const XmlFile& file, const XMLElement& element, UrdfJoint& joint,
               Diagnostics& diagnostics) {
  const bool bounded =
      joint.type == UrdfJoint::Type::kRevolute || joint.type == UrdfJoint::Type::kPrismatic;
  const XMLElement* limit = element.FirstChildElement("limit");
  if (limit == nullptr) {
    if (bounded) {
      file.fail(element, "joint " + quoted(joint.name) +
                             " needs a <limit> (type revolute or "
                             "prismatic)");
    }
    return;
  }
  joint.velocity =
      bounded ? file.number(*limit, "velocity") : optionalNumber(file, *limit, "velocity", 0);
  if (joint.velocity < 0) {
    file.fail(*limit, "joint " + quoted(joint.name) + " has a negative velocity limit");
  }
  if (joint.velocity == 0) {
    diagnostics.warning(file.at(*limit), "joint " + quoted(joint.name) +
                                             " has velocity limit 0; taken as not stated");
  }
  if (!bounded) return;
  joint.lower = optionalNumber(file, *limit, "lower", 0);
  joint.upper = optionalNumber(file, *limit, "upper", 0);
  if (joint.lower > joint.upper) {
    file.fail(*limit, "joint " + quoted(joint.name) + " has lower " + formatDouble(joint.lower) +
                          " above upper " + formatDouble(joint.upper));
  }
  if (std::max(std::abs(joint.lower), std::abs(joint.upper)) > kLargestLimit) {
    file.fail(*limit, "joint " + quoted(joint.name) + " has a limit beyond 10000");
  }
}

UrdfJoint readJoint(const XmlFile& file, const XMLElement& element, Diagnostics& diagnostics) {
  UrdfJoint joint;
  joint.line = element.GetLineNum();
  joint.name = readName(file, element, "name");
  joint.type = jointType(file, element);
  for (const char* side : {"parent", "child"}) {
    const XMLElement* link = element.FirstChildElement(side);
    if (link == nullptr) {
      file.fail(element, "joint " + quoted(joint.name) + " has no <" + side + ">");
    }
    (side[0] == 'p' ? joint.parent : joint.child) = readName(file, *link, "link");
  }
  joint.parent_T_joint = readOrigin(file, element);
  // Writers put a zero axis on fixed joints, where it means nothing.
  if (!joint.moves()) return joint;
  if (joint.type != UrdfJoint::Type::kOther) {
    readAxis(file, element, joint, diagnostics);
    readLimit(file, element, joint, diagnostics);
  }
  if (const XMLElement* mimic = element.FirstChildElement("mimic")) {
    joint.mimic =
        UrdfMimic{readName(file, *mimic, "joint"), optionalNumber(file, *mimic, "multiplier", 1),
                  optionalNumber(file, *mimic, "offset", 0)};
  }
  return joint;
}

std::optional<UrdfSolid> readSolid(const XmlFile& file, const XMLElement& collision) {
  const XMLElement* geometry = collision.FirstChildElement("geometry");
  if (geometry == nullptr) return std::nullopt;
  UrdfSolid solid;
  if (const XMLElement* box = geometry->FirstChildElement("box")) {
    solid.type = UrdfSolid::Type::kBox;
    solid.size = vector3(file, *box, "size");
  } else if (const XMLElement* cylinder = geometry->FirstChildElement("cylinder")) {
    solid.type = UrdfSolid::Type::kCylinder;
    solid.size = {file.number(*cylinder, "radius"), file.number(*cylinder, "length"), 0};
  } else if (const XMLElement* sphere = geometry->FirstChildElement("sphere")) {
    solid.type = UrdfSolid::Type::kSphere;
    solid.size = {file.number(*sphere, "radius"), 0, 0};
  } else {
    return std::nullopt;
  }
  if (solid.size.minCoeff() < 0 || solid.size.maxCoeff() > kLargestLength) {
    file.fail(*geometry, "a collision solid with a size below 0 or above 10 km");
  }
  solid.link_T_solid = readOrigin(file, collision);
  return solid;
}

UrdfLink readLink(const XmlFile& file, const XMLElement& element) {
  UrdfLink link;
  link.line = element.GetLineNum();
  link.name = readName(file, element, "name");
  for (const auto* c = element.FirstChildElement("collision"); c != nullptr;
       c = c->NextSiblingElement("collision")) {
    if (const auto solid = readSolid(file, *c)) {
      link.collision.push_back(*solid);
    } else if (const auto* geometry = c->FirstChildElement("geometry")) {
      if (geometry->FirstChildElement("mesh") != nullptr) ++link.meshes;
    }
  }
  return link;
}

/// xacro leaves its marks as elements "xacro:..." and as "${...}" or "$(...)"
/// in the attributes of joints and links.
class XacroFinder : public tinyxml2::XMLVisitor {
 public:
  explicit XacroFinder(const XmlFile& file) : file_(file) {}
  bool VisitEnter(const XMLElement& element, const tinyxml2::XMLAttribute* first) override {
    if (std::strcmp(element.Name(), "gazebo") == 0) return false;
    bool found = std::strncmp(element.Name(), "xacro:", 6) == 0;
    for (const auto* a = first; a != nullptr && !found; a = a->Next()) {
      found = std::strstr(a->Value(), "${") != nullptr || std::strstr(a->Value(), "$(") != nullptr;
    }
    if (found) file_.fail(element, "this is an unexpanded xacro file; run xacro first");
    return true;
  }

 private:
  const XmlFile& file_;
};

UrdfModel readModel(const XmlFile& file, Diagnostics& diagnostics) {
  const XMLElement& root = file.root();
  if (std::strcmp(root.Name(), "robot") != 0) {
    file.fail(root, "expected <robot>, found <" + std::string(root.Name()) + ">");
  }
  XacroFinder xacro(file);
  root.Accept(&xacro);
  UrdfModel model;
  model.path = file.path();
  model.name = file.required(root, "name");
  const std::size_t errors_before = diagnostics.errorCount();
  std::size_t ignored = 0;
  const XMLElement* first_ignored = nullptr;
  for (const auto* e = root.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    const std::string kind = e->Name();
    try {
      if (kind == "joint") {
        model.joints.push_back(readJoint(file, *e, diagnostics));
      } else if (kind == "link") {
        model.links.push_back(readLink(file, *e));
      } else if (kind != "material" && kind != "transmission" && kind != "gazebo" &&
                 kind != "sensor") {
        if (ignored++ == 0) first_ignored = e;
      }
    } catch (const Error& error) {
      diagnostics.error(error.where(), error.what());
    }
  }
  if (ignored > 0) {
    diagnostics.note(file.at(*first_ignored),
                     std::to_string(ignored) + " elements that are no part of URDF are ignored, " +
                         "the first is <" + first_ignored->Name() + ">");
  }
  // A joint or link that was not understood would only cause false alarms.
  if (diagnostics.errorCount() == errors_before) checkUrdfTree(model, diagnostics);
  return model;
}

}  // namespace

int UrdfModel::findLink(const std::string& link) const {
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (links[i].name == link) return static_cast<int>(i);
  }
  return -1;
}

int UrdfModel::jointAbove(const std::string& link) const {
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints[i].child == link) return static_cast<int>(i);
  }
  return -1;
}

UrdfModel readUrdf(const std::string& path, Diagnostics& diagnostics) {
  return readModel(XmlFile(path), diagnostics);
}

UrdfModel readUrdfText(const std::string& path, const std::string& content,
                       Diagnostics& diagnostics) {
  return readModel(XmlFile(path, content), diagnostics);
}

}  // namespace graft::lfd
