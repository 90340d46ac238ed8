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
//     i32 x0 y0 z0, i32 nx ny nz, i32 nodes in roll, i32 nodes per angular cell,
//     i32 0, then three texts (u32 length, bytes): robot, base link, tip link; then, packed, one
//     byte per node, the distance + 127, and one per cell, the quality. Packed: u64 bytes that
//     follow; of these, as often as needed: u16 number of zeros, u16 number of
//     other bytes, those.

namespace graft::lfd {

namespace {

constexpr char kMagic[] = "GRAFTIRM";
constexpr std::uint32_t kByteOrder = 0x01020304;
constexpr std::uint32_t kVersion = 2;
constexpr std::size_t kFixedPart = 32;
constexpr std::size_t kChecksumAt = 24;
constexpr std::size_t kSizeAt = 16;
constexpr std::uint32_t kLongestName = 4096;
constexpr std::size_t kLargestMap = 2147483648;

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
  void copy(std::uint8_t* to, std::size_t size, const char* what) {
    std::memcpy(to, take(size, what), size);
  }
  std::size_t left() const { return content_.size() - position_; }
  [[noreturn]] void fail(const std::string& text) const {
    throw Error(ExitCode::kInput, {path_, 0, 0}, "reachability map: " + text);
  }

 private:
  const char* take(std::size_t size, const char* what) {
    if (size > left()) fail(std::string("the file ends inside ") + what);
    const char* begin = content_.data() + position_;
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
    in.fail("version " + std::to_string(version) + ", this build reads 2: build the map anew");
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

/// Nodes of the grid, without trusting any number to be small; at most `most`.
bool countNodes(const ReachGrid& grid, std::size_t most) {
  std::size_t nodes = static_cast<std::size_t>(grid.ringCount());
  for (const int n : {grid.psiCount(), grid.rolls, grid.nx, grid.ny, grid.nz}) {
    if (__builtin_mul_overflow(nodes, static_cast<std::size_t>(n), &nodes)) return false;
  }
  return nodes <= most;
}

constexpr std::size_t kLongestRun = 65535;
// Fewer zeros than this are cheaper as they are.
constexpr std::size_t kShortestRun = 6;

std::size_t zerosAt(const std::uint8_t* data, std::size_t i, std::size_t end) {
  const std::size_t first = i;
  while (i < end && data[i] == 0) ++i;
  return i - first;
}

void pack(const std::uint8_t* data, std::size_t size, Writer& w) {
  const std::size_t length_at = w.out().size();
  w.put(std::uint64_t{0});
  for (std::size_t i = 0; i < size;) {
    const std::size_t zeros = std::min(kLongestRun, zerosAt(data, i, size));
    i += zeros;
    const std::size_t first = i;
    const std::size_t last = std::min(size, first + kLongestRun);
    while (i < last) {
      const std::size_t run = zerosAt(data, i, std::min(last, i + kShortestRun));
      if (run == kShortestRun) break;
      i += std::max<std::size_t>(1, run);
    }
    i = std::min(i, last);
    w.put(static_cast<std::uint16_t>(zeros));
    w.put(static_cast<std::uint16_t>(i - first));
    w.out().append(reinterpret_cast<const char*>(data + first), i - first);
  }
  const std::uint64_t length = w.out().size() - length_at - 8;
  std::memcpy(w.out().data() + length_at, &length, 8);
}

/// `what` has to give `size` bytes, all of which are written.
void unpack(Reader& in, const char* what, std::uint8_t* data, std::size_t size) {
  const auto length = in.get<std::uint64_t>(what);
  if (length > in.left()) in.fail(std::string("the file ends inside ") + what);
  const std::size_t end = in.left() - length;
  std::size_t at = 0;
  while (in.left() > end) {
    const std::size_t zeros = in.get<std::uint16_t>(what);
    const std::size_t others = in.get<std::uint16_t>(what);
    if (zeros + others > size - at) in.fail(std::string(what) + " do not fit the grid");
    std::fill_n(data + at, zeros, std::uint8_t{0});
    in.copy(data + at + zeros, others, what);
    at += zeros + others;
  }
  if (at != size || in.left() != end) in.fail(std::string(what) + " do not fit the grid");
}

}  // namespace

void ReachMap::save(const std::string& path) const {
  Writer w;
  w.out().reserve(distances_.size() / 2 + cells_.size());
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
  for (const int n : {grid_.turn, grid_.x0, grid_.y0, grid_.z0, grid_.nx, grid_.ny, grid_.nz,
                      grid_.rolls, grid_.fine, 0}) {
    w.put(static_cast<std::int32_t>(n));
  }
  for (const std::string& name : {robot_, base_link_, tip_link_}) {
    w.text(name.substr(0, kLongestName));
  }
  // Background is -127 in a map, 0 in the file.
  std::vector<std::uint8_t> bytes(distances_.size());
  std::transform(distances_.begin(), distances_.end(), bytes.begin(),
                 [](std::int8_t d) { return static_cast<std::uint8_t>(d + 127); });
  pack(bytes.data(), bytes.size(), w);
  pack(cells_.data(), cells_.size(), w);
  std::string& out = w.out();
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
  grid.turn = integer(in, "the number of angular cells", 4, ReachGrid::kMostTurn);
  if (grid.turn % 4 != 0) in.fail("the number of angular cells is not a multiple of 4");
  grid.x0 = integer(in, "the first cell in x", -kMostCells, kMostCells);
  grid.y0 = integer(in, "the first cell in y", -kMostCells, kMostCells);
  grid.z0 = integer(in, "the first cell in z", -kMostCells, kMostCells);
  grid.nx = integer(in, "the number of nodes in x", 2, ReachGrid::kMostNodes);
  grid.ny = integer(in, "the number of nodes in y", 2, ReachGrid::kMostNodes);
  grid.nz = integer(in, "the number of nodes in z", 1, kMostCells);
  grid.rolls = integer(in, "the number of nodes in roll", 1, grid.turn);
  if (grid.rolls != 1 && grid.rolls != grid.turn) {
    in.fail("the number of nodes in roll is neither 1 nor that of angular cells");
  }
  grid.fine = integer(in, "the number of nodes per cell", 1, 2);
  integer(in, "the reserved field", 0, 0);
  map.robot_ = in.text("the robot's name");
  map.base_link_ = in.text("the base link's name");
  map.tip_link_ = in.text("the tip link's name");
  if (!countNodes(grid, std::min(kLargestMap, in.left() * kLongestRun))) {
    in.fail("its grid of " + std::to_string(grid.nx) + " x " + std::to_string(grid.ny) + " x " +
            std::to_string(grid.nz) + " nodes does not fit the " + std::to_string(in.left()) +
            " bytes left");
  }
  std::vector<std::uint8_t> bytes(grid.nodeCount());
  unpack(in, "the distances", bytes.data(), bytes.size());
  map.distances_.resize(bytes.size());
  std::transform(bytes.begin(), bytes.end(), map.distances_.begin(), [](std::uint8_t b) {
    return static_cast<std::int8_t>(std::min<int>(b, 254) - 127);
  });
  map.cells_.resize(grid.cellCount());
  unpack(in, "the qualities", map.cells_.data(), map.cells_.size());
  if (in.left() != 0) in.fail("there are " + std::to_string(in.left()) + " bytes too many");
  map.finish();
  if (map.reachable_cells_ != reachable) {
    in.fail("the header counts " + std::to_string(reachable) + " reachable nodes, the body has " +
            std::to_string(map.reachable_cells_));
  }
  return map;
}

}  // namespace graft::lfd
