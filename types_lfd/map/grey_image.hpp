// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/base/error.hpp"

namespace graft::lfd {

/// A grey picture in memory. Row 0 is the top, as in the file.
struct GreyImage {
  int width = 0;
  int height = 0;
  std::vector<float> values;      ///< width * height, row by row; 0 = black, 1 = white
  std::vector<bool> transparent;  ///< empty, or one entry per pixel: not fully opaque
};

/// Largest picture that is read: pixels along a side, and in all.
constexpr int kMaxImageSide = 20000;
constexpr long kMaxImagePixels = 100'000'000;

/// Reads a PGM (P2 or P5, maxval 1..65535) or a PNG; colours count by the mean
/// of red, green and blue, as ROS map_server does. The kind is told by content,
/// not by name. Defects go to `diagnostics` (the line for text PGM and for the
/// header); the result is then empty. Throws what readFile throws.
GreyImage readGreyImage(const std::string& path, Diagnostics& diagnostics);

}  // namespace graft::lfd
