// SPDX-License-Identifier: BSD-3-Clause
// Planted: linear algebra knows no problem.
#include "core/solve/problem.hpp"
