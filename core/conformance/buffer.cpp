// SPDX-License-Identifier: BSD-3-Clause
#include "core/conformance/buffer.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>

namespace graft::conformance {

namespace {

constexpr std::size_t kGuard = 64;  // numbers on each side
constexpr std::size_t kAlignment = 64;
// A NaN with a payload that no arithmetic produces.
constexpr std::uint64_t kMark = 0x7ff8a5c3d1e2f096u;

bool isMark(const double* number) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, number, sizeof bits);
  return bits == kMark;
}

void fillWithMarks(double* numbers, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) std::memcpy(numbers + i, &kMark, sizeof kMark);
}

}  // namespace

Buffer::Buffer(std::size_t size, Placement placement) : size_(size) {
  const std::size_t used = size * sizeof(double);
  if (placement == Placement::kAligned || placement == Placement::kOdd) {
    const std::size_t numbers = size + 2 * kGuard + 1;
    bytes_ = (numbers * sizeof(double) + kAlignment - 1) / kAlignment * kAlignment;
    memory_ = std::aligned_alloc(kAlignment, bytes_);
    if (memory_ == nullptr) throw std::bad_alloc();
    fillWithMarks(static_cast<double*>(memory_), bytes_ / sizeof(double));
    data_ = static_cast<double*>(memory_) + kGuard + (placement == Placement::kOdd ? 1 : 0);
    return;
  }
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::size_t inside = std::max<std::size_t>(1, (used + page - 1) / page) * page;
  bytes_ = inside + 2 * page;
  memory_ = ::mmap(nullptr, bytes_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory_ == MAP_FAILED) throw std::bad_alloc();
  mapped_ = true;
  char* begin = static_cast<char*>(memory_) + page;
  if (::mprotect(begin, inside, PROT_READ | PROT_WRITE) != 0) throw std::bad_alloc();
  data_ =
      reinterpret_cast<double*>(placement == Placement::kAtPageEnd ? begin + inside - used : begin);
  fillWithMarks(data_, size_);
}

Buffer::Buffer(const std::vector<double>& numbers, Placement placement)
    : Buffer(numbers.size(), placement) {
  std::copy(numbers.begin(), numbers.end(), data_);
}

Buffer::~Buffer() {
  if (mapped_)
    ::munmap(memory_, bytes_);
  else
    std::free(memory_);
}

std::size_t Buffer::firstUnwritten() const {
  std::size_t i = 0;
  while (i < size_ && !isMark(data_ + i)) ++i;
  return i;
}

std::size_t Buffer::changedBefore() const {
  if (mapped_) return 0;
  std::size_t changed = 0;
  for (std::size_t i = 1; i <= kGuard; ++i) changed += isMark(data_ - i) ? 0 : 1;
  return changed;
}

std::size_t Buffer::changedBehind() const {
  if (mapped_) return 0;
  std::size_t changed = 0;
  for (std::size_t i = 0; i < kGuard; ++i) changed += isMark(data_ + size_ + i) ? 0 : 1;
  return changed;
}

bool sameBits(const double* a, const double* b, std::size_t count) {
  return count == 0 || std::memcmp(a, b, count * sizeof(double)) == 0;
}

}  // namespace graft::conformance
