// SPDX-License-Identifier: BSD-3-Clause
// Planted: base may not include what builds on it.
#include "core/solve/optimizer.hpp"
