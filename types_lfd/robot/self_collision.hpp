// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "types_lfd/robot/solid_distance.hpp"
#include "types_lfd/robot/srdf.hpp"

namespace graft::lfd {

class Chain;

/// Where the bodies between a chain's joints stand in the base frame: body 0 is
/// the base with all that does not move against it, body i + 1 all that joint i
/// carries up to the next. The z axis is that of the joint.
struct BodyFrames {
  std::vector<Eigen::Matrix3d> rotation;
  std::vector<Eigen::Vector3d> translation;
};

/// Whether an arm hits its robot or itself: the boxes, cylinders and spheres of
/// the URDF's <collision> elements, all pairs of links that can move against
/// each other. Left out are pairs that the SRDF disables, links that a joint
/// connects (their solids meet there), and pairs that overlap whatever the joints
/// do (in 200 random configurations). Meshes have no
/// shape here. Joints off the chain stand at 0, or their limit nearest to it.
class SelfCollision {
 public:
  /// What was left out is noted in `diagnostics`, at the model's path.
  SelfCollision(const UrdfModel& model, const Srdf& srdf, const Chain& chain,
                Diagnostics& diagnostics);

  /// There is nothing to test.
  bool empty() const { return pairs_.empty(); }
  std::size_t pairCount() const { return pairs_.size(); }

  bool collides(const BodyFrames& frames) const;

  /// Some of the pairs.
  class Subset {
   public:
    bool empty() const { return pairs_.empty(); }

   private:
    friend class SelfCollision;
    std::vector<int> pairs_;
  };
  /// Pairs whose relative pose changes with a joint of `with` (if any is given)
  /// and with none of `without`; indices of the chain's joints, negative = none.
  Subset pairsMovedBy(const std::vector<int>& with, const std::vector<int>& without) const;
  bool collides(const BodyFrames& frames, const Subset& subset) const;
  /// Those of a subset that may overlap while the later body of each pair moves by up
  /// to `rise` (m) along z of the base frame and, with an `axis`, turns by any angle
  /// about the upright line there (x, y; m); the others do not.
  void keepNear(const BodyFrames& frames, const Subset& subset, double rise,
                const Eigen::Vector2d* axis, Subset& near) const;

  /// Smallest distance of any pair (m), infinity if there is none.
  double distance(const BodyFrames& frames) const;

  /// Changes with all that decides collides().
  std::uint64_t hash() const { return hash_; }

 private:
  struct Solid {
    PlacedSolid placed;  ///< in its body's frame
    double bound = 0;
    int body = 0;
    int link = 0;
  };
  struct Pair {
    int a;
    int b;
  };

  PlacedSolid inBase(const Solid& solid, const BodyFrames& frames) const;
  bool overlap(const Pair& pair, const BodyFrames& frames) const;
  void addPairs(const UrdfModel& model, const Srdf& srdf);
  void dropTouching(const Chain& chain, const UrdfModel& model, Diagnostics& diagnostics);
  void computeHash();

  std::vector<Solid> solids_;
  std::vector<Pair> pairs_;
  std::vector<std::string> links_;
  std::uint64_t hash_ = 0;
};

}  // namespace graft::lfd
