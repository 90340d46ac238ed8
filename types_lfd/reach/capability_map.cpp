// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/reach/capability_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/base/error.hpp"
#include "core/base/file.hpp"
#include "core/base/text.hpp"

namespace graft::lfd {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegree = kPi / 180;
constexpr int kDepth = 16;         // of OctoMap trees
constexpr int kCenterKey = 32768;  // key of the first cell above 0

/// Depth and position of an octree cell as one number.
std::uint64_t cellKey(int depth, const std::uint32_t key[3]) {
  std::uint64_t packed = static_cast<std::uint64_t>(depth);
  for (int k = 0; k < 3; ++k) packed = packed << 16 | (key[k] >> (kDepth - depth));
  return packed;
}

}  // namespace

Eigen::Vector3d Capability::axis() const {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

bool Capability::covers(const Eigen::Vector3d& direction) const {
  if (shape == Shape::kEmpty) return false;
  if (shape == Shape::kSphere) return true;
  const double angle = std::acos(std::clamp(axis().dot(direction.normalized()), -1.0, 1.0));
  if (shape == Shape::kCone) return angle <= half_angle;
  if (shape == Shape::kCylinder1) return std::min(angle, kPi - angle) <= half_angle;
  return std::abs(0.5 * kPi - angle) <= half_angle;
}

double Capability::share() const {
  switch (shape) {
    case Shape::kEmpty:
      return 0;
    case Shape::kSphere:
      return 1;
    case Shape::kCone:
      return 0.5 * (1 - std::cos(half_angle));
    case Shape::kCylinder1:
      return 1 - std::cos(std::min(half_angle, 0.5 * kPi));
    case Shape::kCylinder2:
      return std::sin(std::min(half_angle, 0.5 * kPi));
  }
  return 0;
}

/// Reads the text header, then the tree in depth-first order (a byte for the
/// shape, four doubles, a byte that tells which children follow), then three
/// named texts.
class CapabilityReader {
 public:
  CapabilityReader(const std::string& path, const std::string& content)
      : path_(path), content_(content) {}

  CapabilityMap read() {
    readHeader();
    std::uint32_t key[3] = {0, 0, 0};
    if (size_ > 0) readNode(0, key);
    if (nodes_ != size_) {
      fail("the header counts " + std::to_string(size_) + " nodes, the tree has " +
           std::to_string(nodes_));
    }
    readTrailer();
    return std::move(map_);
  }

 private:
  [[noreturn]] void fail(const std::string& text, std::int64_t line = 0) const {
    throw Error(ExitCode::kInput, {path_, line, 0}, "capability map: " + text);
  }

  void readHeader() {
    std::int64_t number = 0;
    bool id_seen = false;
    bool size_seen = false;
    for (;;) {
      const std::size_t end = content_.find('\n', position_);
      // A header is a few short lines; without this a binary file is one line.
      if (end == std::string::npos || end - position_ > 1000 || number > 100) {
        fail("the header ends before a line 'data'", number + 1);
      }
      LineTokens tokens(std::string_view(content_).substr(position_, end - position_));
      position_ = end + 1;
      ++number;
      const std::string_view name = tokens.next();
      const std::string_view value = tokens.next();
      if (number == 1 && content_.compare(0, 21, "# Octomap OcTree file") != 0) {
        fail("the first line is not '# Octomap OcTree file'", number);
      }
      if (name.empty()) continue;
      if (name == "data") break;
      if (name == "id") {
        id_seen = value == "CapabilityOcTree";
        if (!id_seen) fail("id " + quoted(value) + ", expected CapabilityOcTree", number);
      } else if (name == "size") {
        std::int64_t size = 0;
        const NumberStatus status = parseInteger(value, size);
        if (status != NumberStatus::kOk) fail("size: " + describe(status, value), number);
        if (size < 0) fail("size is negative", number);
        size_ = static_cast<std::uint64_t>(size);
        size_seen = true;
      } else if (name == "res") {
        const NumberStatus status = parseDouble(value, map_.resolution_);
        if (status != NumberStatus::kOk) fail("res: " + describe(status, value), number);
        if (!(map_.resolution_ > 1e-4 && map_.resolution_ < 10)) {
          fail("the resolution " + quoted(value) + " is not 0.0001 to 10 m", number);
        }
      } else {
        fail("unknown header entry " + quoted(name), number);
      }
    }
    if (!id_seen) fail("the header has no id", number);
    if (!size_seen) fail("the header has no size", number);
    if (map_.resolution_ == 0) fail("the header has no res", number);
  }

  template <class T>
  T take() {
    if (content_.size() - position_ < sizeof(T)) {
      fail("truncated: the tree ends after node " + std::to_string(nodes_) + " of " +
           std::to_string(size_));
    }
    T value;
    std::memcpy(&value, content_.data() + position_, sizeof value);
    position_ += sizeof value;
    return value;
  }

  /// Recursion is bounded by the tree's depth, which is checked.
  void readNode(int depth, const std::uint32_t key[3]) {
    const auto shape = take<std::uint8_t>();
    double numbers[4];
    for (double& number : numbers) number = take<double>();
    const auto children = take<std::uint8_t>();
    const std::string where = "node " + std::to_string(nodes_);
    ++nodes_;
    if (shape > 4) fail(where + " has the unknown shape " + std::to_string(shape));
    for (const double number : numbers) {
      if (!(std::abs(number) <= 1e4)) fail(where + " has an angle or error that is no number");
    }
    if (children != 0 && depth == kDepth) fail(where + " is deeper than an octree goes");
    if (children == 0) {
      if (shape != 0) addLeaf(depth, key, shape, numbers);
      return;
    }
    const int bit = kDepth - 1 - depth;
    for (unsigned child = 0; child < 8; ++child) {
      if ((children >> child & 1U) == 0) continue;
      std::uint32_t below[3];
      for (unsigned k = 0; k < 3; ++k) below[k] = key[k] | (child >> k & 1U) << bit;
      readNode(depth + 1, below);
    }
  }

  void addLeaf(int depth, const std::uint32_t key[3], std::uint8_t shape, const double* numbers) {
    Capability c;
    c.shape = static_cast<Capability::Shape>(shape);
    c.phi = numbers[0] * kDegree;
    c.theta = numbers[1] * kDegree;
    c.half_angle = numbers[2] * kDegree;
    c.shape_fit_error = numbers[3];
    const double cells = std::exp2(kDepth - depth);
    c.edge = cells * map_.resolution_;
    for (int k = 0; k < 3; ++k) {
      c.center[k] = (static_cast<double>(key[k]) - kCenterKey + 0.5 * cells) * map_.resolution_;
    }
    map_.index_.emplace(cellKey(depth, key), map_.capabilities_.size());
    map_.capabilities_.push_back(c);
  }

  void readTrailer() {
    LineReader lines(std::string_view(content_).substr(position_));
    std::string_view line;
    while (lines.next(line)) {
      LineTokens tokens(line);
      const std::string_view name = tokens.next();
      if (name.empty()) continue;
      std::string* target = name == "group_name"  ? &map_.group_
                            : name == "base_name" ? &map_.base_
                            : name == "tip_name"  ? &map_.tip_
                                                  : nullptr;
      if (target == nullptr) fail("unknown entry " + quoted(name) + " after the tree");
      *target = std::string(tokens.next());
    }
    if (map_.group_.empty() || map_.base_.empty() || map_.tip_.empty()) {
      fail("truncated: group_name, base_name or tip_name is missing after the tree");
    }
  }

  const std::string& path_;
  const std::string& content_;
  std::size_t position_ = 0;
  std::uint64_t size_ = 0;
  std::uint64_t nodes_ = 0;
  CapabilityMap map_;
};

CapabilityMap CapabilityMap::load(const std::string& path) {
  const std::string content = readFile(path, std::size_t{1} << 32);
  return CapabilityReader(path, content).read();
}

const Capability* CapabilityMap::find(const Eigen::Vector3d& position) const {
  std::uint32_t key[3];
  for (int k = 0; k < 3; ++k) {
    const double cell = std::floor(position[k] / resolution_) + kCenterKey;
    if (!(cell >= 0 && cell < 2 * kCenterKey)) return nullptr;
    key[k] = static_cast<std::uint32_t>(cell);
  }
  for (int depth = kDepth; depth >= 0; --depth) {
    const auto found = index_.find(cellKey(depth, key));
    if (found != index_.end()) return &capabilities_[found->second];
  }
  return nullptr;
}

}  // namespace graft::lfd
