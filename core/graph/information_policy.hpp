// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace graft {

/// What happens to an information matrix that is not positive semidefinite.
enum class InformationPolicy {
  kError,   ///< rejected, naming the edge and its smallest eigenvalue
  kProject  ///< negative eigenvalues become 0; counted in a note
};

}  // namespace graft
