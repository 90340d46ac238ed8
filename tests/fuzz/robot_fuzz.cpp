// SPDX-License-Identifier: BSD-3-Clause
// URDF, and what is made of it: the chain from the first root to every link, its
// kinematics with joints in the middle of their ranges, and its self-collision test.
#include "tests/fuzz/fuzz.hpp"
#include "types_lfd/robot/chain.hpp"
#include "types_lfd/robot/self_collision.hpp"

namespace graft::fuzz {

namespace {

void checkChain(const lfd::UrdfModel& model, const std::string& base, const std::string& tip) {
  const lfd::Chain chain(model, base, tip);
  const Eigen::VectorXd middle = 0.5 * chain.lower() + 0.5 * chain.upper();
  const Pose base_T_gripper = chain.forward(middle);
  require(base_T_gripper.rotation.coeffs().array().isNaN().count() == 0, "not a number");
  for (int i = 0; i < chain.dof(); ++i) {
    require(chain.lower()[i] <= chain.upper()[i], "limits the wrong way round");
  }
}

}  // namespace

void fuzzOne(std::string_view bytes) {
  lfd::UrdfModel model;
  const bool taken = accepts([&](Diagnostics& found) {
    model = lfd::readUrdfText("robot.urdf", std::string(bytes), found);
  });
  if (!taken) return;
  require(!model.links.empty(), "a robot without links");
  for (std::size_t i = 1; i < model.links.size() && i < 8; ++i) {
    accepts([&](Diagnostics&) { checkChain(model, model.links[0].name, model.links[i].name); });
  }
}

}  // namespace graft::fuzz
