// SPDX-License-Identifier: BSD-3-Clause
// Planted: plugins do not include the engine.
#include "core/graph/graph.hpp"
