// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/robot/self_collision.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "core/base/text.hpp"
#include "types_lfd/robot/chain.hpp"

namespace graft::lfd {

namespace {

/// Where a joint off the chain stands: 0, or its limit nearest to 0.
double restOf(const UrdfModel& model, const UrdfJoint& joint) {
  if (joint.mimic) {
    for (const UrdfJoint& master : model.joints) {
      if (master.name != joint.mimic->joint || master.mimic) continue;
      return joint.mimic->multiplier * restOf(model, master) + joint.mimic->offset;
    }
  }
  const bool bounded =
      joint.type == UrdfJoint::Type::kRevolute || joint.type == UrdfJoint::Type::kPrismatic;
  return bounded ? std::clamp(0.0, joint.lower, joint.upper) : 0;
}

Pose motion(const UrdfJoint& joint, double q) {
  switch (joint.type) {
    case UrdfJoint::Type::kPrismatic:
      return Pose(Eigen::Vector3d(q * joint.axis), Eigen::Quaterniond::Identity());
    case UrdfJoint::Type::kRevolute:
    case UrdfJoint::Type::kContinuous:
      return Pose(Eigen::Vector3d::Zero(), Eigen::Quaterniond(Eigen::AngleAxisd(q, joint.axis)));
    default:
      return Pose();
  }
}

/// Every link with all joints of the chain at 0: its pose under the root, and its body.
class RestingLinks {
 public:
  RestingLinks(const UrdfModel& model, const Chain& chain) : model_(model) {
    for (int i = 0; i < chain.dof(); ++i) body_of_joint_[chain.names()[std::size_t(i)]] = i + 1;
  }

  struct Place {
    Pose root_T_link;
    int body = 0;
  };
  Place of(const std::string& link) const {
    const int up = model_.jointAbove(link);
    if (up < 0) return {};
    const UrdfJoint& joint = model_.joints[std::size_t(up)];
    Place place = of(joint.parent);
    const auto moving = body_of_joint_.find(joint.name);
    const bool on_chain = moving != body_of_joint_.end();
    const double q = on_chain ? 0 : restOf(model_, joint);
    place.root_T_link = place.root_T_link * joint.parent_T_joint * motion(joint, q);
    if (on_chain) place.body = moving->second;
    return place;
  }

 private:
  const UrdfModel& model_;
  std::map<std::string, int> body_of_joint_;
};

PlacedSolid place(const UrdfSolid& solid, const Pose& frame_T_link) {
  const Pose pose = frame_T_link * solid.link_T_solid;
  PlacedSolid placed;
  placed.type = solid.type;
  placed.rotation = pose.rotation.normalized().toRotationMatrix();
  placed.center = pose.translation;
  placed.half = solid.size;
  if (solid.type == UrdfSolid::Type::kBox) placed.half *= 0.5;
  if (solid.type == UrdfSolid::Type::kCylinder) placed.half[1] *= 0.5;
  return placed;
}

void mix(std::uint64_t& hash, double value) {
  std::uint64_t bits;
  const double plain = value == 0 ? 0 : value;
  std::memcpy(&bits, &plain, sizeof bits);
  hash = (hash ^ bits) * 0x9e3779b97f4a7c15ULL;
  hash ^= hash >> 32;
}

}  // namespace

SelfCollision::SelfCollision(const UrdfModel& model, const Srdf& srdf, const Chain& chain,
                             Diagnostics& diagnostics) {
  const RestingLinks resting(model, chain);
  const Pose base_T_root = resting.of(chain.baseLink()).root_T_link.inverse();
  BodyFrames frames;
  chain.bodies(Eigen::VectorXd::Zero(chain.dof()).eval().data(), frames);
  std::size_t shapeless = 0;
  for (const UrdfLink& link : model.links) {
    const RestingLinks::Place at = resting.of(link.name);
    const auto body = std::size_t(at.body);
    const Pose base_T_body(frames.translation[body],
                           Eigen::Quaterniond(frames.rotation[body]).normalized());
    const Pose body_T_link = base_T_body.inverse() * base_T_root * at.root_T_link;
    for (const UrdfSolid& solid : link.collision) {
      const PlacedSolid placed = place(solid, body_T_link);
      solids_.push_back({placed, placed.bound(), at.body, int(links_.size())});
    }
    if (link.collision.empty() && link.meshes > 0) ++shapeless;
    links_.push_back(link.name);
  }
  addPairs(model, srdf);
  dropTouching(chain, model, diagnostics);
  if (shapeless > 0) {
    diagnostics.note({model.path, 0, 0},
                     std::to_string(shapeless) + " links have only meshes to collide with, which " +
                         "are not opened; they take no part in the test for self-collision");
  }
  computeHash();
}

void SelfCollision::addPairs(const UrdfModel& model, const Srdf& srdf) {
  const auto connected = [&](const std::string& a, const std::string& b) {
    return std::any_of(model.joints.begin(), model.joints.end(), [&](const UrdfJoint& j) {
      return (j.parent == a && j.child == b) || (j.parent == b && j.child == a);
    });
  };
  std::map<std::pair<int, int>, bool> wanted;
  for (std::size_t b = 0; b < solids_.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      if (solids_[a].body == solids_[b].body) continue;
      const std::pair<int, int> links(solids_[a].link, solids_[b].link);
      auto known = wanted.find(links);
      if (known == wanted.end()) {
        const std::string& first = links_[std::size_t(links.first)];
        const std::string& second = links_[std::size_t(links.second)];
        known = wanted.emplace(links, !srdf.isDisabled(first, second) && !connected(first, second))
                    .first;
      }
      if (known->second) pairs_.push_back({int(a), int(b)});
    }
  }
}

void SelfCollision::dropTouching(const Chain& chain, const UrdfModel& model,
                                 Diagnostics& diagnostics) {
  constexpr int kConfigurations = 200;
  std::vector<char> apart(pairs_.size(), 0);
  std::mt19937_64 random(1);
  BodyFrames frames;
  for (int k = 0; k < kConfigurations; ++k) {
    chain.bodies(sampleJoints(chain, random).data(), frames);
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      if (apart[p] == 0 && !overlap(pairs_[p], frames)) apart[p] = 1;
    }
  }
  std::vector<Pair> kept;
  std::set<std::pair<int, int>> dropped;
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    if (apart[p] != 0) {
      kept.push_back(pairs_[p]);
    } else {
      dropped.emplace(solids_[std::size_t(pairs_[p].a)].link,
                      solids_[std::size_t(pairs_[p].b)].link);
    }
  }
  if (!dropped.empty()) {
    diagnostics.note(
        {model.path, 0, 0},
        std::to_string(dropped.size()) +
            " pairs of links overlap whatever the joints do and are not tested for " +
            "self-collision, the first: " + quoted(links_[std::size_t(dropped.begin()->first)]) +
            " and " + quoted(links_[std::size_t(dropped.begin()->second)]));
  }
  pairs_ = std::move(kept);
}

void SelfCollision::computeHash() {
  if (pairs_.empty()) return;
  for (const Pair& pair : pairs_) {
    for (const int i : {pair.a, pair.b}) {
      const Solid& solid = solids_[std::size_t(i)];
      mix(hash_, double(solid.body));
      mix(hash_, double(int(solid.placed.type)));
      for (int k = 0; k < 9; ++k) mix(hash_, solid.placed.rotation.data()[k]);
      for (int k = 0; k < 3; ++k) mix(hash_, solid.placed.center[k]);
      for (int k = 0; k < 3; ++k) mix(hash_, solid.placed.half[k]);
    }
  }
}

PlacedSolid SelfCollision::inBase(const Solid& solid, const BodyFrames& frames) const {
  const auto body = std::size_t(solid.body);
  PlacedSolid placed = solid.placed;
  placed.center = frames.rotation[body] * placed.center + frames.translation[body];
  placed.rotation = frames.rotation[body] * solid.placed.rotation;
  return placed;
}

bool SelfCollision::overlap(const Pair& pair, const BodyFrames& frames) const {
  const Solid& a = solids_[std::size_t(pair.a)];
  const Solid& b = solids_[std::size_t(pair.b)];
  const Eigen::Vector3d between = frames.rotation[std::size_t(a.body)] * a.placed.center +
                                  frames.translation[std::size_t(a.body)] -
                                  (frames.rotation[std::size_t(b.body)] * b.placed.center +
                                   frames.translation[std::size_t(b.body)]);
  const double near = a.bound + b.bound;
  if (between.squaredNorm() > near * near) return false;
  return solidsOverlap(inBase(a, frames), inBase(b, frames));
}

bool SelfCollision::collides(const BodyFrames& frames) const {
  return std::any_of(pairs_.begin(), pairs_.end(),
                     [&](const Pair& pair) { return overlap(pair, frames); });
}

SelfCollision::Subset SelfCollision::pairsMovedBy(const std::vector<int>& with,
                                                  const std::vector<int>& without) const {
  Subset subset;
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    const int x = solids_[std::size_t(pairs_[p].a)].body;
    const int y = solids_[std::size_t(pairs_[p].b)].body;
    // Joint j stands between bodies j and j + 1.
    const auto moves = [&](int joint) {
      return joint >= 0 && std::min(x, y) <= joint && joint < std::max(x, y);
    };
    const bool some = with.empty() || std::any_of(with.begin(), with.end(), moves);
    if (some && std::none_of(without.begin(), without.end(), moves)) {
      subset.pairs_.push_back(int(p));
    }
  }
  return subset;
}

bool SelfCollision::collides(const BodyFrames& frames, const Subset& subset) const {
  return std::any_of(subset.pairs_.begin(), subset.pairs_.end(),
                     [&](int p) { return overlap(pairs_[std::size_t(p)], frames); });
}

void SelfCollision::keepNear(const BodyFrames& frames, const Subset& subset, double rise,
                             const Eigen::Vector2d* axis, Subset& near) const {
  near.pairs_.clear();
  const auto center = [&](const Solid& solid) -> Eigen::Vector3d {
    const auto body = std::size_t(solid.body);
    return frames.rotation[body] * solid.placed.center + frames.translation[body];
  };
  for (const int p : subset.pairs_) {
    const Solid* low = &solids_[std::size_t(pairs_[std::size_t(p)].a)];
    const Solid* high = &solids_[std::size_t(pairs_[std::size_t(p)].b)];
    if (low->body > high->body) std::swap(low, high);
    const Eigen::Vector3d from = center(*low);
    const Eigen::Vector3d to = center(*high);
    double aside = (to - from).head<2>().norm();
    if (axis != nullptr) {
      aside = (to.head<2>() - *axis).norm() - (from.head<2>() - *axis).norm();
    }
    // The point of the way up that is nearest.
    const double drop = from[2] - to[2];
    const double above = drop - std::clamp(drop, std::min(0.0, rise), std::max(0.0, rise));
    const double reach = low->bound + high->bound;
    if (aside * aside + above * above <= reach * reach) near.pairs_.push_back(p);
  }
}

double SelfCollision::distance(const BodyFrames& frames) const {
  double least = std::numeric_limits<double>::infinity();
  for (const Pair& pair : pairs_) {
    least = std::min(least, solidDistance(inBase(solids_[std::size_t(pair.a)], frames),
                                          inBase(solids_[std::size_t(pair.b)], frames)));
  }
  return least;
}

}  // namespace graft::lfd
