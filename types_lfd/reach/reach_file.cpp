// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/file.hpp"
#include "core/base/text.hpp"
#include "types_lfd/reach/reach_map.hpp"

// Layout, little endian:
//   0 magic "GRAFTIRM"   8 u32 byte order mark   12 u32 version
//  16 u64 bytes of the whole file   24 u64 checksum of all bytes from 32 on
//  32 u64 chain hash, u64 seed, u64 samples, u64 reachable cells,
//     f64 coverage, f64 best manipulability, f64 resolution, i32 cells per turn,
//     i32 x0 y0 z0, i32 nx ny nz, i32 0, then three texts (u32 length, bytes):
//     robot, base link, tip link; then one quality byte per cell.

namespace graft::lfd {

namespace {

constexpr char kMagic[] = "GRAFTIRM";
constexpr std::uint32_t kByteOrder = 0x01020304;
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kFixedPart = 32;
constexpr std::size_t kChecksumAt = 24;
constexpr std::size_t kSizeAt = 16;
constexpr std::uint32_t kLongestName = 4096;

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "map files are written as memory holds them");

/// FNV-1a over words of 8 bytes: every step is invertible, so that a change in
/// one place always shows.
std::uint64_t checksum(const char* data, std::size_t size) {
  std::uint64_t h = 0xcbf29ce484222325ULL;
  std::size_t i = 0;
  for (; i + 8 <= size; i += 8) {
    std::uint64_t word;
    std::memcpy(&word, data + i, 8);
    h = (h ^ word) * 0x100000001b3ULL;
    h ^= h >> 29;
  }
  for (; i < size; ++i) h = (h ^ static_cast<unsigned char>(data[i])) * 0x100000001b3ULL;
  return h ^ size;
}

class Writer {
 public:
  template <class T>
  void put(const T& value) {
    out_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void text(const std::string& value) {
    put(static_cast<std::uint32_t>(value.size()));
    out_ += value;
  }
  std::string& out() { return out_; }

 private:
  std::string out_;
};

class Reader {
 public:
  Reader(const std::string& path, const std::string& content) : path_(path), content_(content) {}

  template <class T>
  T get(const char* what) {
    T value;
    std::memcpy(&value, take(sizeof value, what), sizeof value);
    return value;
  }
  std::string text(const char* what) {
    const auto size = get<std::uint32_t>(what);
    if (size > kLongestName) fail(std::string(what) + " is longer than 4096 bytes");
    return std::string(take(size, what), size);
  }
  std::size_t left() const { return content_.size() - position_; }
  const char* rest() const { return content_.data() + position_; }
  [[noreturn]] void fail(const std::string& text) const {
    throw Error(ExitCode::kInput, {path_, 0, 0}, "reachability map: " + text);
  }

 private:
  const char* take(std::size_t size, const char* what) {
    if (size > left()) fail(std::string("the file ends inside ") + what);
    const char* begin = rest();
    position_ += size;
    return begin;
  }

  const std::string& path_;
  const std::string& content_;
  std::size_t position_ = 0;
};

void checkEnvelope(Reader& in, const std::string& content) {
  if (content.size() < kFixedPart) {
    const std::size_t seen = std::min<std::size_t>(content.size(), 8);
    if (seen > 0 && content.compare(0, seen, kMagic, seen) == 0) {
      in.fail("truncated: the header has " + std::to_string(kFixedPart) + " bytes, the file has " +
              std::to_string(content.size()));
    }
    in.fail("not a graft reachability map (no GRAFTIRM at its beginning)");
  }
  char magic[8];
  for (char& c : magic) c = in.get<char>("the magic");
  if (std::memcmp(magic, kMagic, 8) != 0) {
    in.fail("not a graft reachability map (no GRAFTIRM at its beginning)");
  }
  if (in.get<std::uint32_t>("the byte order") != kByteOrder) {
    in.fail("wrong byte order mark: written on a big-endian machine, or damaged");
  }
  const auto version = in.get<std::uint32_t>("the version");
  if (version != kVersion) {
    in.fail("version " + std::to_string(version) + ", this build reads 1");
  }
  const auto size = in.get<std::uint64_t>("the size");
  if (size > content.size()) {
    in.fail("truncated: the header says " + std::to_string(size) + " bytes, the file has " +
            std::to_string(content.size()));
  }
  if (size < content.size()) {
    in.fail("the header says " + std::to_string(size) + " bytes, the file has " +
            std::to_string(content.size()) + ": bytes were added");
  }
  const auto expected = in.get<std::uint64_t>("the checksum");
  if (expected != checksum(content.data() + kFixedPart, content.size() - kFixedPart)) {
    in.fail("the checksum does not match: the file is damaged");
  }
}

double finite(Reader& in, const char* what, double low, double high) {
  const auto value = in.get<double>(what);
  if (!(value >= low && value <= high)) {
    in.fail(std::string(what) + " is " + formatDouble(value) + ", expected " + formatDouble(low) +
            " to " + formatDouble(high));
  }
  return value;
}

int integer(Reader& in, const char* what, int low, int high) {
  const auto value = in.get<std::int32_t>(what);
  if (value < low || value > high) {
    in.fail(std::string(what) + " is " + std::to_string(value) + ", expected " +
            std::to_string(low) + " to " + std::to_string(high));
  }
  return value;
}

/// Cells of the grid, without trusting any number to be small.
bool countCells(const ReachGrid& grid, std::size_t& cells) {
  cells = static_cast<std::size_t>(grid.tiltCount());
  for (const int n : {grid.turn, grid.nx, grid.ny, grid.nz}) {
    if (__builtin_mul_overflow(cells, static_cast<std::size_t>(n), &cells)) return false;
  }
  return true;
}

}  // namespace

void ReachMap::save(const std::string& path) const {
  Writer w;
  w.out().reserve(cells_.size() + 4096);
  w.out().append(kMagic, 8);
  w.put(kByteOrder);
  w.put(kVersion);
  w.put(std::uint64_t{0});
  w.put(std::uint64_t{0});
  w.put(chain_hash_);
  w.put(seed_);
  w.put(samples_);
  w.put(reachable_cells_);
  w.put(coverage_);
  w.put(best_manipulability_);
  w.put(grid_.resolution);
  for (const int n : {grid_.turn, grid_.x0, grid_.y0, grid_.z0, grid_.nx, grid_.ny, grid_.nz, 0}) {
    w.put(static_cast<std::int32_t>(n));
  }
  for (const std::string& name : {robot_, base_link_, tip_link_}) {
    w.text(name.substr(0, kLongestName));
  }
  std::string& out = w.out();
  out.append(reinterpret_cast<const char*>(cells_.data()), cells_.size());
  const std::uint64_t size = out.size();
  std::memcpy(out.data() + kSizeAt, &size, 8);
  const std::uint64_t sum = checksum(out.data() + kFixedPart, out.size() - kFixedPart);
  std::memcpy(out.data() + kChecksumAt, &sum, 8);
  writeFileAtomically(path, out);
}

ReachMap ReachMap::load(const std::string& path) {
  const std::string content = readFile(path, std::size_t{1} << 32);
  Reader in(path, content);
  checkEnvelope(in, content);
  constexpr double kHuge = 1e300;
  constexpr int kMostCells = 1 << 20;
  ReachMap map;
  map.chain_hash_ = in.get<std::uint64_t>("the chain hash");
  map.seed_ = in.get<std::uint64_t>("the seed");
  map.samples_ = in.get<std::uint64_t>("the samples");
  const auto reachable = in.get<std::uint64_t>("the cell count");
  map.coverage_ = finite(in, "the coverage", 0, 1);
  map.best_manipulability_ = finite(in, "the best manipulability", 0, kHuge);
  ReachGrid& grid = map.grid_;
  grid.resolution = finite(in, "the resolution", 1e-4, 10);
  grid.turn = integer(in, "the number of angular cells", 4, 720);
  if (grid.turn % 4 != 0) in.fail("the number of angular cells is not a multiple of 4");
  grid.x0 = integer(in, "the first cell in x", -kMostCells, kMostCells);
  grid.y0 = integer(in, "the first cell in y", -kMostCells, kMostCells);
  grid.z0 = integer(in, "the first cell in z", -kMostCells, kMostCells);
  grid.nx = integer(in, "the number of cells in x", 1, kMostCells);
  grid.ny = integer(in, "the number of cells in y", 1, kMostCells);
  grid.nz = integer(in, "the number of cells in z", 1, kMostCells);
  integer(in, "the reserved field", 0, 0);
  map.robot_ = in.text("the robot's name");
  map.base_link_ = in.text("the base link's name");
  map.tip_link_ = in.text("the tip link's name");
  std::size_t cells = 0;
  if (!countCells(grid, cells) || cells != in.left()) {
    in.fail("its grid of " + std::to_string(grid.nx) + " x " + std::to_string(grid.ny) + " x " +
            std::to_string(grid.nz) + " cells does not fit the " + std::to_string(in.left()) +
            " bytes of cells");
  }
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(in.rest());
  map.cells_.assign(bytes, bytes + cells);
  map.finish();
  if (map.reachable_cells_ != reachable) {
    in.fail("the header counts " + std::to_string(reachable) + " reachable cells, the body has " +
            std::to_string(map.reachable_cells_));
  }
  return map;
}

}  // namespace graft::lfd
