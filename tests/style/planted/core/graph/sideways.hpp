// SPDX-License-Identifier: BSD-3-Clause
// Planted: the structure of a graph needs no linear algebra.
#include "core/linear/ordering.hpp"
