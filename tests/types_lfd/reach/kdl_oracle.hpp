// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_nr_jl.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>
#include <kdl/jntarray.hpp>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "core/geometry/se3.hpp"

namespace graft::lfd::testing {

/// KDL's inverse kinematics within limits (Newton-Raphson), from random starts.
class KdlOracle {
 public:
  KdlOracle(const std::string& urdf, const std::string& base, const std::string& tip, int restarts)
      : parts_(std::make_shared<Parts>(urdf, base, tip)), restarts_(restarts) {}

  bool operator()(const Pose& base_T_gripper) const {
    const auto& q = base_T_gripper.rotation;
    const auto& t = base_T_gripper.translation;
    const KDL::Frame target(KDL::Rotation::Quaternion(q.x(), q.y(), q.z(), q.w()),
                            KDL::Vector(t[0], t[1], t[2]));
    std::mt19937_64 random(1);
    const unsigned n = parts_->chain.getNrOfJoints();
    KDL::JntArray start(n);
    KDL::JntArray found(n);
    for (int i = 0; i <= restarts_; ++i) {
      for (unsigned j = 0; j < n; ++j) {
        const double u = i == 0 ? 0.5 : static_cast<double>(random() >> 11) * 0x1p-53;
        start(j) = parts_->lower(j) + u * (parts_->upper(j) - parts_->lower(j));
      }
      if (parts_->inverse.CartToJnt(start, target, found) >= 0) return true;
    }
    return false;
  }

 private:
  struct Parts {
    Parts(const std::string& urdf, const std::string& base, const std::string& tip)
        : chain(readChain(urdf, base, tip)),
          forward(chain),
          velocity(chain),
          inverse(chain, lower, upper, forward, velocity, 100, 1e-4) {}

    KDL::Chain readChain(const std::string& urdf, const std::string& base, const std::string& tip) {
      const auto model = urdf::parseURDFFile(urdf);
      std::vector<urdf::JointConstSharedPtr> path;
      for (auto link = model->getLink(tip); link->name != base; link = link->getParent()) {
        path.push_back(link->parent_joint);
      }
      std::reverse(path.begin(), path.end());
      KDL::Chain read;
      KDL::Frame fixed = KDL::Frame::Identity();  // what lies between two joints, once
      std::vector<double> low;
      std::vector<double> high;
      for (const auto& joint : path) {
        const auto& o = joint->parent_to_joint_origin_transform;
        const KDL::Frame frame =
            fixed * KDL::Frame(KDL::Rotation::Quaternion(o.rotation.x, o.rotation.y, o.rotation.z,
                                                         o.rotation.w),
                               KDL::Vector(o.position.x, o.position.y, o.position.z));
        if (joint->type == urdf::Joint::FIXED) {
          fixed = frame;
          continue;
        }
        fixed = KDL::Frame::Identity();
        const KDL::Vector axis = frame.M * KDL::Vector(joint->axis.x, joint->axis.y, joint->axis.z);
        const bool slides = joint->type == urdf::Joint::PRISMATIC;
        read.addSegment(
            KDL::Segment(KDL::Joint(joint->name, frame.p, axis,
                                    slides ? KDL::Joint::TransAxis : KDL::Joint::RotAxis),
                         frame));
        const bool bounded = joint->type != urdf::Joint::CONTINUOUS;
        low.push_back(bounded ? joint->limits->lower : -3.14159265358979323846);
        high.push_back(bounded ? joint->limits->upper : 3.14159265358979323846);
      }
      read.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), fixed));
      lower.resize(static_cast<unsigned>(low.size()));
      upper.resize(lower.rows());
      for (unsigned j = 0; j < lower.rows(); ++j) {
        lower(j) = low[j];
        upper(j) = high[j];
      }
      return read;
    }

    KDL::JntArray lower;
    KDL::JntArray upper;
    KDL::Chain chain;
    KDL::ChainFkSolverPos_recursive forward;
    KDL::ChainIkSolverVel_pinv velocity;
    KDL::ChainIkSolverPos_NR_JL inverse;
  };

  std::shared_ptr<Parts> parts_;
  int restarts_;
};

}  // namespace graft::lfd::testing
