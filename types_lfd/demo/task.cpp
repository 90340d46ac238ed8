// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/task.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "types_lfd/demo/footprint.hpp"
#include "types_lfd/xml/xml_reader.hpp"

namespace graft::lfd {

namespace {

using Element = tinyxml2::XMLElement;

/// Reads the elements of one file into a Task.
class TaskReader {
 public:
  TaskReader(const XmlFile& file, Task& task) : file_(file), task_(task) {}

  void readRoot() {
    const Element& root = file_.root();
    if (std::string(root.Name()) != "task") {
      file_.fail(root, std::string("expected <task>, got <") + root.Name() + ">");
    }
    file_.allowAttributes(root, {"name", "version"});
    task_.name = nonEmpty(root, "name");
    const std::string version = file_.required(root, "version");
    if (version != "1") {
      file_.fail(root, "version " + graft::quoted(version) + " is not known; this program reads 1");
    }
  }

  void readChild(const tinyxml2::XMLNode& node) {
    if (node.ToComment() != nullptr) return;
    const Element* element = node.ToElement();
    if (element == nullptr) file_.fail(node, "unexpected text in <task>");
    const std::string name = element->Name();
    if (name != "robot" && name != "grasps" && name != "map" && name != "tracker" &&
        name != "demonstration" && name != "weights") {
      file_.fail(*element, "unknown element <" + name + ">");
    }
    for (const auto* inner = element->FirstChild(); inner; inner = inner->NextSibling()) {
      if (inner->ToComment() == nullptr) file_.fail(*inner, "<" + name + "> has no content");
    }
    if (name == "robot") readRobot(*element);
    if (name == "grasps") readGrasps(*element);
    if (name == "map") readMap(*element);
    if (name == "tracker") readTracker(*element);
    if (name == "demonstration") readDemonstration(*element);
    if (name == "weights") readWeights(*element);
  }

  /// What is missing is noticed only after all elements were seen.
  void checkComplete(Diagnostics& diagnostics) const {
    const SourceLocation where = file_.at(file_.root());
    for (const char* name : {"robot", "grasps", "demonstration"}) {
      if (seen_.count(name) == 0) {
        diagnostics.error(where, std::string("<task> needs a <") + name + "> element");
      }
    }
  }

 private:
  void readRobot(const Element& element) {
    once(element);
    file_.allowAttributes(element, {"urdf", "base_link", "tip_link", "footprint", "tool", "srdf"});
    RobotSpec& robot = task_.robot;
    robot.urdf = path(element, "urdf");
    robot.base_link = nonEmpty(element, "base_link");
    robot.tip_link = nonEmpty(element, "tip_link");
    if (file_.has(element, "srdf")) robot.srdf = path(element, "srdf");
    if (file_.has(element, "tool")) robot.tip_T_gripper = pose(element, "tool");
    const std::vector<double> xy = file_.numbers(element, "footprint");
    if (xy.size() % 2 != 0) {
      file_.fail(element, "attribute 'footprint' of <robot>: expected x y pairs, got " +
                              std::to_string(xy.size()) + " numbers");
    }
    for (std::size_t i = 0; i < xy.size(); i += 2) {
      robot.footprint.emplace_back(xy[i], xy[i + 1]);
    }
    const std::string defect = footprintDefect(robot.footprint);
    if (!defect.empty()) {
      file_.fail(element, "attribute 'footprint' of <robot> is no simple polygon: " + defect);
    }
  }

  void readGrasps(const Element& element) {
    once(element);
    file_.allowAttributes(element, {"file", "min_quality"});
    task_.grasps = path(element, "file");
    if (!file_.has(element, "min_quality")) return;
    task_.min_quality = file_.number(element, "min_quality");
    if (task_.min_quality < 0 || task_.min_quality > 1) {
      file_.fail(element, "attribute 'min_quality' of <grasps> must be from 0 to 1, got " +
                              file_.required(element, "min_quality"));
    }
  }

  void readMap(const Element& element) {
    once(element);
    file_.allowAttributes(element, {"file"});
    task_.map = path(element, "file");
  }

  void readTracker(const Element& element) {
    file_.allowAttributes(element, {"entity", "sigma_t", "sigma_r"});
    const std::string entity = file_.required(element, "entity");
    if (entity != "hand" && entity != "object" && entity != "torso") {
      file_.fail(element,
                 "unknown entity " + graft::quoted(entity) + "; known: hand, object, torso");
    }
    if (task_.trackers.count(entity) != 0) {
      file_.fail(element, "a second <tracker> for " + graft::quoted(entity));
    }
    const TrackerAccuracy accuracy{positive(element, "sigma_t"), positive(element, "sigma_r")};
    task_.trackers[entity] = accuracy;
  }

  void readDemonstration(const Element& element) {
    seen_.insert("demonstration");
    file_.allowAttributes(
        element, {"name", "hand", "object", "torso", "grasp_time", "release_time", "hand_offset"});
    DemonstrationSpec spec;
    spec.where = file_.at(element);
    spec.name = nonEmpty(element, "name");
    const bool clean = std::all_of(spec.name.begin(), spec.name.end(), [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
             c == '_' || c == '-';
    });
    if (!clean) {
      file_.fail(element, "the name " + graft::quoted(spec.name) +
                              " may hold only letters, digits, '_' and '-'");
    }
    if (!names_.insert(spec.name).second) {
      file_.fail(element, "a second demonstration named " + graft::quoted(spec.name));
    }
    spec.hand = path(element, "hand");
    spec.object = path(element, "object");
    if (file_.has(element, "torso")) spec.torso = path(element, "torso");
    if (file_.has(element, "grasp_time")) spec.grasp_time = file_.number(element, "grasp_time");
    if (file_.has(element, "release_time")) {
      spec.release_time = file_.number(element, "release_time");
    }
    if (spec.grasp_time && spec.release_time && !(*spec.grasp_time < *spec.release_time)) {
      file_.fail(element, "grasp_time must be before release_time");
    }
    if (file_.has(element, "hand_offset")) spec.hand_offset = pose(element, "hand_offset");
    task_.demonstrations.push_back(std::move(spec));
  }

  void readWeights(const Element& element) {
    file_.allowAttributes(element, {"edge", "sigma_t", "sigma_r"});
    WeightOverride weight;
    weight.where = file_.at(element);
    weight.edge = nonEmpty(element, "edge");
    for (const WeightOverride& other : task_.weights) {
      if (other.edge == weight.edge) {
        file_.fail(element, "a second <weights> for edge " + graft::quoted(weight.edge));
      }
    }
    weight.sigma_t = positive(element, "sigma_t");
    weight.sigma_r = positive(element, "sigma_r");
    task_.weights.push_back(std::move(weight));
  }

  void once(const Element& element) {
    if (!seen_.insert(element.Name()).second) {
      file_.fail(element, std::string("a second <") + element.Name() + "> element");
    }
  }

  std::string nonEmpty(const Element& element, const char* name) const {
    std::string value = file_.required(element, name);
    if (value.empty()) {
      file_.fail(element,
                 std::string("attribute '") + name + "' of <" + element.Name() + "> is empty");
    }
    return value;
  }

  /// A path relative to the task's folder; absolute ones stay as they are.
  std::string path(const Element& element, const char* name) const {
    return (std::filesystem::path(task_.directory) / nonEmpty(element, name))
        .lexically_normal()
        .string();
  }

  double positive(const Element& element, const char* name) const {
    const double value = file_.number(element, name);
    if (!(value > 0)) {
      file_.fail(element, std::string("attribute '") + name + "' of <" + element.Name() +
                              "> must be positive, got " + file_.required(element, name));
    }
    return value;
  }

  Pose pose(const Element& element, const char* name) const {
    std::vector<double> v = file_.numbers(element, name, 7);
    const double length = std::sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
    if (!(length > 0.99 && length < 1.01)) {
      file_.fail(element, std::string("attribute '") + name + "' of <" + element.Name() +
                              ">: the quaternion is not unit (order is qx qy qz qw)");
    }
    normalizeQuaternion(v.data() + 3);
    return Pose::fromArray(v.data());
  }

  const XmlFile& file_;
  Task& task_;
  std::set<std::string> seen_;
  std::set<std::string> names_;
};

}  // namespace

Task readTask(const std::string& path, Diagnostics& diagnostics) {
  Task task;
  task.path = path;
  task.directory = std::filesystem::path(path).parent_path().string();
  if (task.directory.empty()) task.directory = ".";
  const XmlFile file(path);
  TaskReader reader(file, task);
  reader.readRoot();
  for (const auto* node = file.root().FirstChild(); node; node = node->NextSibling()) {
    try {
      reader.readChild(*node);
    } catch (const Error& error) {
      diagnostics.error(error.where(), error.what());
    }
  }
  reader.checkComplete(diagnostics);
  return task;
}

}  // namespace graft::lfd
