// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace graft::conformance {

/// Where a buffer lies.
enum class Placement {
  kAligned,      ///< at a multiple of 64 bytes, between guard zones
  kOdd,          ///< 8 bytes behind one
  kAtPageEnd,    ///< before a page that nobody may touch
  kAtPageBegin,  ///< behind one
};

/// Numbers that a callback under test reads or writes. Every number is a mark at
/// first, and so are the guard zones on both sides.
class Buffer {
 public:
  Buffer(std::size_t size, Placement placement);
  Buffer(const std::vector<double>& numbers, Placement placement);
  ~Buffer();
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  double* data() { return data_; }
  const double* data() const { return data_; }
  std::size_t size() const { return size_; }
  std::vector<double> numbers() const { return std::vector<double>(data_, data_ + size_); }

  /// Index of the first number that still is a mark, or size().
  std::size_t firstUnwritten() const;
  /// Numbers changed before the begin and behind the end, as far as the guard
  /// zones go (page placements have none).
  std::size_t changedBefore() const;
  std::size_t changedBehind() const;

 private:
  void* memory_ = nullptr;
  std::size_t bytes_ = 0;
  bool mapped_ = false;
  double* data_ = nullptr;
  std::size_t size_ = 0;
};

/// What `write` writes into a guarded buffer of `size` numbers, so that a callback
/// that writes beside it harms nothing here.
template <class Write>
std::vector<double> guardedNumbers(std::size_t size, Write&& write) {
  Buffer buffer(size, Placement::kAligned);
  write(buffer.data());
  return buffer.numbers();
}

/// True where both hold the same bits.
bool sameBits(const double* a, const double* b, std::size_t count);

}  // namespace graft::conformance
