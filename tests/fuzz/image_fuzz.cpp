// SPDX-License-Identifier: BSD-3-Clause
// Pictures of maps, PGM and PNG.
#include "tests/fuzz/fuzz.hpp"
#include "types_lfd/map/grey_image.hpp"

namespace graft::fuzz {

void fuzzOne(std::string_view bytes) {
  const File file(bytes);
  lfd::GreyImage image;
  if (!accepts([&](Diagnostics& found) { image = lfd::readGreyImage(file.path(), found); })) {
    require(image.values.empty(), "a refused picture has pixels");
    return;
  }
  const std::size_t pixels =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  require(pixels > 0 && image.values.size() == pixels, "pixels do not fit the size");
  require(image.transparent.empty() || image.transparent.size() == pixels, "alpha does not fit");
  for (const float value : image.values) require(value >= 0 && value <= 1, "a pixel out of range");
}

}  // namespace graft::fuzz
