// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/map/grey_image.hpp"

#include <png.h>

#include <cstdint>
#include <string_view>

#include "core/base/file.hpp"
#include "core/base/text.hpp"

namespace graft::lfd {

namespace {

bool isSpace(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

/// Walks over the text of a PGM: numbers between blanks, '#' comments, lines.
class PgmText {
 public:
  explicit PgmText(std::string_view text) : text_(text) {}

  std::string_view token() {
    skip();
    const std::size_t begin = position_;
    token_line_ = line_;
    while (position_ < text_.size() && !isSpace(text_[position_]) && text_[position_] != '#') {
      ++position_;
    }
    return text_.substr(begin, position_ - begin);
  }
  /// What follows the one blank that ends a P5 header.
  std::string_view rest() const {
    return position_ < text_.size() ? text_.substr(position_ + 1) : std::string_view();
  }
  std::int64_t tokenLine() const { return token_line_; }

 private:
  void skip() {
    bool comment = false;
    for (; position_ < text_.size(); ++position_) {
      const char c = text_[position_];
      if (c == '\n') ++line_;
      if (c == '\n' || c == '\r') comment = false;
      if (c == '#') comment = true;
      if (!comment && !isSpace(c)) return;
    }
  }

  std::string_view text_;
  std::size_t position_ = 0;
  std::int64_t line_ = 1;
  std::int64_t token_line_ = 1;
};

/// True if a picture of this size may be held; reports if not.
bool checkSize(const SourceLocation& where, std::int64_t width, std::int64_t height,
               Diagnostics& diagnostics) {
  const std::string size = std::to_string(width) + " x " + std::to_string(height);
  if (width < 1 || height < 1) {
    diagnostics.error(where, "the image has no pixels (" + size + ")");
    return false;
  }
  if (width > kMaxImageSide || height > kMaxImageSide || width * height > kMaxImagePixels) {
    diagnostics.error(where, "the image is too large (" + size + "; at most " +
                                 std::to_string(kMaxImageSide) + " a side and " +
                                 std::to_string(kMaxImagePixels) + " pixels)");
    return false;
  }
  return true;
}

/// One positive number of the header, or -1 with a message.
std::int64_t headerNumber(PgmText& text, const std::string& path, const char* what,
                          Diagnostics& diagnostics) {
  const std::string_view token = text.token();
  std::int64_t value = 0;
  if (parseInteger(token, value) != NumberStatus::kOk || value < 0) {
    diagnostics.error({path, text.tokenLine(), 0},
                      token.empty() ? std::string("truncated: the header lacks the ") + what
                                    : std::string("the ") + what + " of the image is " +
                                          quoted(token) + ", expected a whole number");
    return -1;
  }
  return value;
}

bool readBinaryPixels(std::string_view data, const std::string& path, std::int64_t max_value,
                      GreyImage& image, Diagnostics& diagnostics) {
  const std::size_t bytes = max_value > 255 ? 2 : 1;
  const std::size_t needed = image.values.size() * bytes;
  if (data.size() < needed) {
    diagnostics.error({path, 0, 0}, "truncated: the header says " + std::to_string(needed) +
                                        " bytes of pixels, the file has " +
                                        std::to_string(data.size()));
    return false;
  }
  for (std::size_t i = needed; i < data.size(); ++i) {
    if (isSpace(data[i])) continue;
    diagnostics.error({path, 0, 0}, std::to_string(data.size() - needed) +
                                        " bytes follow the pixels: the size in the header is "
                                        "wrong, or there is more than one image");
    return false;
  }
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    std::int64_t value = static_cast<unsigned char>(data[i * bytes]);
    if (bytes == 2) value = 256 * value + static_cast<unsigned char>(data[2 * i + 1]);
    if (value > max_value) {
      diagnostics.error({path, 0, 0}, "pixel " + std::to_string(i) + " is " +
                                          std::to_string(value) + ", above the maxval " +
                                          std::to_string(max_value));
      return false;
    }
    image.values[i] = static_cast<float>(static_cast<double>(value) / max_value);
  }
  return true;
}

bool readTextPixels(PgmText& text, const std::string& path, std::int64_t max_value,
                    GreyImage& image, Diagnostics& diagnostics) {
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    const std::string_view token = text.token();
    std::int64_t value = 0;
    if (token.empty()) {
      diagnostics.error({path, text.tokenLine(), 0},
                        "truncated: the header says " + std::to_string(image.values.size()) +
                            " pixels, the file has " + std::to_string(i));
      return false;
    }
    if (parseInteger(token, value) != NumberStatus::kOk || value < 0 || value > max_value) {
      diagnostics.error(
          {path, text.tokenLine(), 0},
          quoted(token) + " is no pixel value from 0 to " + std::to_string(max_value));
      return false;
    }
    image.values[i] = static_cast<float>(static_cast<double>(value) / max_value);
  }
  const std::string_view extra = text.token();
  if (!extra.empty()) {
    diagnostics.error({path, text.tokenLine(), 0},
                      "unexpected " + quoted(extra) + " after the last pixel");
    return false;
  }
  return true;
}

GreyImage readPgm(std::string_view content, const std::string& path, Diagnostics& diagnostics) {
  PgmText text(content);
  const bool binary = text.token() == "P5";
  GreyImage image;
  const std::int64_t width = headerNumber(text, path, "width", diagnostics);
  if (width < 0) return {};
  const std::int64_t height = headerNumber(text, path, "height", diagnostics);
  if (height < 0) return {};
  const SourceLocation size_line{path, text.tokenLine(), 0};
  if (!checkSize(size_line, width, height, diagnostics)) return {};
  const std::int64_t max_value = headerNumber(text, path, "maxval", diagnostics);
  if (max_value < 0) return {};
  if (max_value < 1 || max_value > 65535) {
    diagnostics.error({path, text.tokenLine(), 0},
                      "the maxval is " + std::to_string(max_value) + ", expected 1 to 65535");
    return {};
  }
  // Refuse what cannot be complete before memory is taken for it.
  const auto pixels = static_cast<std::size_t>(width * height);
  if (!binary && content.size() < 2 * pixels - 1) {
    diagnostics.error({path, 0, 0}, "truncated: the header says " + std::to_string(pixels) +
                                        " pixels, the file has " + std::to_string(content.size()) +
                                        " bytes");
    return {};
  }
  if (binary && text.rest().size() < pixels) {
    diagnostics.error({path, 0, 0}, "truncated: the header says " + std::to_string(pixels) +
                                        " bytes of pixels, the file has " +
                                        std::to_string(text.rest().size()));
    return {};
  }
  image.width = static_cast<int>(width);
  image.height = static_cast<int>(height);
  image.values.resize(pixels);
  const bool complete = binary ? readBinaryPixels(text.rest(), path, max_value, image, diagnostics)
                               : readTextPixels(text, path, max_value, image, diagnostics);
  return complete ? image : GreyImage();
}

/// Frees what libpng keeps for an image, on every way out.
struct PngGuard {
  png_image image = {};
  ~PngGuard() { png_image_free(&image); }
};

GreyImage readPng(const std::string& content, const std::string& path, Diagnostics& diagnostics) {
  PngGuard png;
  png.image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&png.image, content.data(), content.size()) == 0) {
    diagnostics.error({path, 0, 0}, std::string("the PNG cannot be read: ") + png.image.message);
    return {};
  }
  const bool has_alpha = (png.image.format & PNG_FORMAT_FLAG_ALPHA) != 0;
  if (!checkSize({path, 0, 0}, png.image.width, png.image.height, diagnostics)) return {};
  png.image.format = PNG_FORMAT_RGBA;
  std::vector<unsigned char> pixels(PNG_IMAGE_SIZE(png.image));
  if (png_image_finish_read(&png.image, nullptr, pixels.data(), 0, nullptr) == 0) {
    diagnostics.error({path, 0, 0}, std::string("the PNG cannot be read: ") + png.image.message);
    return {};
  }
  GreyImage image;
  image.width = static_cast<int>(png.image.width);
  image.height = static_cast<int>(png.image.height);
  const std::size_t count = pixels.size() / 4;
  image.values.resize(count);
  if (has_alpha) image.transparent.assign(count, false);
  for (std::size_t i = 0; i < count; ++i) {
    const unsigned char* p = pixels.data() + 4 * i;
    image.values[i] = static_cast<float>((p[0] + p[1] + p[2]) / (3 * 255.0));
    if (has_alpha && p[3] != 255) image.transparent[i] = true;
  }
  return image;
}

}  // namespace

GreyImage readGreyImage(const std::string& path, Diagnostics& diagnostics) {
  const std::string content = readFile(path);
  const std::string_view magic = std::string_view(content).substr(0, 2);
  if (magic == "P2" || magic == "P5") return readPgm(content, path, diagnostics);
  if (std::string_view(content).substr(0, 4) == "\x89PNG") {
    return readPng(content, path, diagnostics);
  }
  diagnostics.error({path, 1, 0}, content.empty() ? std::string("the image is empty")
                                                  : "an image that begins with " + quoted(magic) +
                                                        " is neither PGM (P2, P5) nor PNG");
  return {};
}

}  // namespace graft::lfd
