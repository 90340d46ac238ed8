// SPDX-License-Identifier: BSD-3-Clause
// Planted: the generic program knows no robotics.
#include "types_lfd/map/footprint.hpp"
