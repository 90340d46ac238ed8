// SPDX-License-Identifier: BSD-3-Clause
// Planted: a room may not include a later one.
#include "types_lfd/learn/learn.hpp"
