// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <unordered_map>

#include "types_lfd/robot/urdf.hpp"

namespace graft::lfd {

namespace {

using IndexOf = std::unordered_map<std::string, std::size_t>;

class TreeCheck {
 public:
  TreeCheck(const UrdfModel& model, Diagnostics& diagnostics)
      : model_(model), diagnostics_(diagnostics) {}

  void run() {
    for (std::size_t i = 0; i < model_.links.size(); ++i) {
      addOnce(links_, model_.links[i].name, i, model_.links[i].line, "link");
    }
    for (std::size_t i = 0; i < model_.joints.size(); ++i) {
      addOnce(joints_, model_.joints[i].name, i, model_.joints[i].line, "joint");
    }
    checkEnds();
    checkMimics();
    if (model_.links.empty()) {
      diagnostics_.error({model_.path, 0, 0}, "the robot has no links");
    } else if (!failed_) {
      checkRoots();
    }
  }

 private:
  void error(int line, const std::string& text) {
    failed_ = true;
    diagnostics_.error({model_.path, line, 0}, text);
  }

  void addOnce(IndexOf& index, const std::string& name, std::size_t i, int line,
               const std::string& kind) {
    if (!index.emplace(name, i).second) error(line, "a second " + kind + " named " + quoted(name));
  }

  void checkEnds() {
    for (std::size_t i = 0; i < model_.joints.size(); ++i) {
      const UrdfJoint& joint = model_.joints[i];
      for (const std::string& link : {joint.parent, joint.child}) {
        if (links_.count(link) == 0) {
          error(joint.line,
                "joint " + quoted(joint.name) + " names the unknown link " + quoted(link));
        }
      }
      if (joint.parent == joint.child) {
        error(joint.line,
              "joint " + quoted(joint.name) + " joins link " + quoted(joint.child) + " to itself");
        continue;
      }
      const auto [other, added] = above_.emplace(joint.child, i);
      if (!added) {
        error(joint.line, "link " + quoted(joint.child) + " has two parents, by the joints " +
                              quoted(model_.joints[other->second].name) + " and " +
                              quoted(joint.name));
      }
    }
  }

  void checkMimics() {
    for (const UrdfJoint& joint : model_.joints) {
      // Following the chain of mimics ends within as many steps as there are
      // joints, or it is a circle.
      const UrdfJoint* at = &joint;
      for (std::size_t steps = 0; at->mimic; ++steps) {
        const auto next = joints_.find(at->mimic->joint);
        if (next == joints_.end()) {
          if (at == &joint) {
            error(joint.line, "joint " + quoted(joint.name) + " mimics the unknown joint " +
                                  quoted(at->mimic->joint));
          }
          break;
        }
        if (steps > 0 && at == &joint) {
          error(joint.line, "joint " + quoted(joint.name) + " mimics itself" +
                                (steps > 1 ? " by way of others" : ""));
          break;
        }
        if (steps > model_.joints.size()) break;
        at = &model_.joints[next->second];
      }
    }
  }

  /// With at most one parent each, links form one tree if exactly one of them
  /// is a root and every other reaches it.
  void checkRoots() {
    const UrdfLink* root = nullptr;
    for (const UrdfLink& link : model_.links) {
      if (above_.count(link.name) > 0) continue;
      if (root != nullptr) {
        error(link.line, "two root links, " + quoted(root->name) + " and " + quoted(link.name) +
                             ": every link but one needs a joint above it");
        return;
      }
      root = &link;
    }
    // 0 = not seen, 1 = on the way up from the current link, 2 = reaches the root.
    std::vector<char> state(model_.links.size(), 0);
    std::vector<std::size_t> way;
    for (std::size_t i = 0; i < model_.links.size(); ++i) {
      way.clear();
      std::size_t at = i;
      while (state[at] == 0) {
        state[at] = 1;
        way.push_back(at);
        const auto up = above_.find(model_.links[at].name);
        if (up == above_.end()) break;
        at = links_.at(model_.joints[up->second].parent);
        if (state[at] == 1) {
          reportLoop(at);
          return;
        }
      }
      for (const std::size_t link : way) state[link] = 2;
    }
  }

  void reportLoop(std::size_t link) {
    constexpr int kShown = 8;
    const std::string& start = model_.links[link].name;
    std::string names = quoted(start);
    std::string at = start;
    int line = 0;
    for (int shown = 0;; ++shown) {
      const UrdfJoint& joint = model_.joints[above_.at(at)];
      if (line == 0) line = joint.line;
      at = joint.parent;
      if (shown < kShown || at == start) names += " <- " + quoted(at);
      if (shown == kShown) names += " <- ...";
      if (at == start) break;
    }
    error(line, "the joints form a loop: " + names);
  }

  const UrdfModel& model_;
  Diagnostics& diagnostics_;
  IndexOf links_;
  IndexOf joints_;
  IndexOf above_;  // child link -> joint
  bool failed_ = false;
};

}  // namespace

void checkUrdfTree(const UrdfModel& model, Diagnostics& diagnostics) {
  TreeCheck(model, diagnostics).run();
}

}  // namespace graft::lfd
