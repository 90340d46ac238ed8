// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/build/weights.hpp"

namespace graft::lfd {

namespace {

struct NamedWeight {
  const char* name;
  const char* paper;  ///< the edge's number in the paper's order, or empty
  Sigma Weights::*member;
};

constexpr NamedWeight kNamed[] = {{"steady_motion", "", &Weights::steady_motion},
                                  {"steady_hand_free", "", &Weights::steady_hand_free},
                                  {"steady_hand_contact", "", &Weights::steady_hand_contact},
                                  {"steady_hand_held", "", &Weights::steady_hand_held},
                                  {"steady_object_free", "", &Weights::steady_object_free},
                                  {"steady_object_contact", "", &Weights::steady_object_contact},
                                  {"steady_object_held", "", &Weights::steady_object_held},
                                  {"smooth_floor", "E3", &Weights::smooth_floor},
                                  {"human_grasp", "E4", &Weights::human_grasp},
                                  {"robot_grasp", "E5", &Weights::robot_grasp},
                                  {"grasp_quality", "E6", &Weights::grasp_quality},
                                  {"hand_gripper", "E7", &Weights::hand_gripper},
                                  {"resemblance", "E8", &Weights::resemblance},
                                  {"reachability", "E9", &Weights::reachability},
                                  {"grasp_agreement", "E10", &Weights::grasp_agreement},
                                  {"base_prior", "", &Weights::base_prior}};

}  // namespace

Weights weightsFor(const Task& task, Diagnostics& diagnostics) {
  Weights weights;
  for (const WeightOverride& given : task.weights) {
    bool found = false;
    std::string names;
    for (const NamedWeight& known : kNamed) {
      names += (names.empty() ? "" : ", ") + std::string(known.name);
      if (given.edge != known.name && given.edge != known.paper) continue;
      weights.*known.member = {given.sigma_t, given.sigma_r};
      if (known.member == &Weights::steady_motion) {
        for (Sigma Weights::*steady :
             {&Weights::steady_hand_free, &Weights::steady_hand_contact, &Weights::steady_hand_held,
              &Weights::steady_object_free, &Weights::steady_object_contact,
              &Weights::steady_object_held}) {
          weights.*steady = weights.steady_motion;
        }
      }
      found = true;
    }
    if (!found) {
      diagnostics.error(given.where, "unknown edge " + quoted(given.edge) + ", known are " + names +
                                         " (or E3 to E10)");
    }
  }
  return weights;
}

std::map<std::string, Sigma> namedWeights(const Weights& weights) {
  std::map<std::string, Sigma> named;
  for (const NamedWeight& known : kNamed) named[known.name] = weights.*known.member;
  return named;
}

}  // namespace graft::lfd
