// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/base/error.hpp"
#include "types_lfd/model/motion_model.hpp"

namespace graft::lfd {

/// A mixture as the authors of the paper published theirs: over
/// [t; gripper x y z qx qy qz qw; base x y z qx qy qz qw], quaternions as plain
/// numbers, in a model frame whose origin is the grasp.
struct MixtureFile {
  GaussianMixture mixture;  ///< dimension 15, priors normalised
  Pose model_T_object;      ///< "pose"
  Vec<double, 3> grasp;     ///< "grasp": m, from the object to the grasp
  std::string object_name;
};

/// Reads such a text file ("Priors", "Mu", "Sigma1".., "Related_Object"; numbers
/// separated by blanks). Their covariances are rounded to four decimals: they are
/// made symmetric and negative eigenvalues set to zero, and priors that do not
/// sum to one are scaled, all with a counted warning. Anything else that is wrong
/// is Error(kInput) with line and column.
MixtureFile readMixtureFile(const std::string& path, Diagnostics& diagnostics);
MixtureFile parseMixtureFile(const std::string& text, const std::string& path,
                             Diagnostics& diagnostics);

/// The same motion in this project's coordinates. Signs of consecutive
/// quaternions are aligned; covariances go through the Jacobian of the chart. A
/// component fitted to quaternions of both signs (its variance along the
/// quaternion itself shows it) tells nothing of how orientation varies with time:
/// it keeps its mean orientation only, with a note. Height and tilt of the base
/// are dropped. t is scaled so that the last mean is 1; `duration` (s) is what that
/// takes. Throws Error(kInput) where the means of t do not rise from 0 on.
SegmentModel toSegmentModel(const MixtureFile& file, const std::string& name, double duration,
                            Diagnostics& diagnostics);

}  // namespace graft::lfd
