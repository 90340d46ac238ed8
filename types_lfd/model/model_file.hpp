// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "types_lfd/model/motion_model.hpp"

namespace graft::lfd {

/// Text of model.json: per segment its frames, orientation chart, duration,
/// first and last mean state, and the mixture (priors, means K x 10, covariances
/// K x 10 x 10) over the dimensions it names. Numbers in shortest round-trip form:
/// what readModel reads of it is the same model bit for bit.
std::string formatModel(const MotionModel& model);

/// Reads such a file. Nothing is guessed: every field is needed, and an unknown
/// or repeated field, a wrong size, priors that do not sum to one, a covariance
/// that is not symmetric positive semidefinite is Error(kInput) with the path and
/// the field (and line and column where the text is not JSON).
MotionModel readModel(const std::string& path);
MotionModel parseModel(const std::string& text, const std::string& path);

}  // namespace graft::lfd
