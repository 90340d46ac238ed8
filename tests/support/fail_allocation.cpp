// SPDX-License-Identifier: BSD-3-Clause
// Preloaded, makes the k-th allocation of a program fail (GRAFT_TEST_FAIL_ALLOCATION=k),
// or with GRAFT_TEST_FAIL_MODE=from that and all later ones. A file "failed" in the
// working folder says that it came to that.
#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
}

namespace {

std::atomic<long> allocations{0};

long numberFrom(const char* text) {
  long number = 0;
  for (; text != nullptr && *text >= '0' && *text <= '9'; ++text)
    number = 10 * number + *text - '0';
  return number;
}

bool fails() {
  static const long chosen = numberFrom(std::getenv("GRAFT_TEST_FAIL_ALLOCATION"));
  static const char* const mode = std::getenv("GRAFT_TEST_FAIL_MODE");
  if (chosen == 0) return false;
  const long number = ++allocations;
  const bool from = mode != nullptr && *mode == 'f';
  if (from ? number < chosen : number != chosen) return false;
  if (number == chosen) ::close(::open("failed", O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
  errno = ENOMEM;
  return true;
}

}  // namespace

extern "C" {
void* malloc(std::size_t size) { return fails() ? nullptr : __libc_malloc(size); }
void* calloc(std::size_t count, std::size_t size) {
  return fails() ? nullptr : __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) { return fails() ? nullptr : __libc_realloc(old, size); }
}
