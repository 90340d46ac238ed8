// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "types_lfd/build/prepare.hpp"

namespace graft::lfd {

/// Sets the weights of the motion prior of hand and object from the task's
/// tracks, where the task itself does not give them.
void findSteadiness(PreparedTask& prepared);

}  // namespace graft::lfd
