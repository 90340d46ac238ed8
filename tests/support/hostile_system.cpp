// SPDX-License-Identifier: BSD-3-Clause
// Preloaded, a system that does what a system may do. GRAFT_TEST_IO_CALL (open, read, write,
// fsync, close, rename, unlink, or any of them) fails from the GRAFT_TEST_IO_NUMBER-th call
// on; with GRAFT_TEST_IO_MODE=once only that one. GRAFT_TEST_IO_DO: fail, short (one byte, or
// half of it), interrupt (EINTR), or kill (SIGKILL instead of the call). Standard streams are
// left alone. GRAFT_TEST_IO_LOG names a file that receives a line per call that changes the
// disk; a file "failed" in the working folder says that a call was chosen.
// GRAFT_TEST_CLOCK=N: every look at the calendar moves it by N seconds, to and fro.
#ifdef _FORTIFY_SOURCE
#undef _FORTIFY_SOURCE  // it makes inline functions of the calls that are defined here
#endif
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

const char* setting(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

template <class Function>
Function next(Function, const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

enum class Do { kNothing, kFail, kShort, kInterrupt };

/// What happens to this call.
Do chosen(const char* call) {
  static const char* const wanted = setting("GRAFT_TEST_IO_CALL");
  static const long number = std::atol(setting("GRAFT_TEST_IO_NUMBER"));
  static const bool once = std::strcmp(setting("GRAFT_TEST_IO_MODE"), "once") == 0;
  static const char what = *setting("GRAFT_TEST_IO_DO");
  static std::atomic<long> calls{0};
  if (std::strcmp(wanted, "any") != 0 && std::strcmp(wanted, call) != 0) return Do::kNothing;
  const long now = ++calls;
  if (number == 0 || (once ? now != number : now < number)) return Do::kNothing;
  if (now == number) {
    ::syscall(SYS_close, ::syscall(SYS_openat, AT_FDCWD, "failed", O_WRONLY | O_CREAT, 0600));
  }
  if (what == 'k') ::kill(::getpid(), SIGKILL);
  // Whoever waits for the end of interrupts must find one.
  if (what == 'i') return now % 2 == number % 2 ? Do::kInterrupt : Do::kNothing;
  return what == 's' ? Do::kShort : Do::kFail;
}

bool fails(const char* call, int why) {
  const Do what = chosen(call);
  if (what != Do::kFail) return false;
  errno = why;
  return true;
}

void note(const char* what, const char* first, const char* second = "") {
  static const char* const path = setting("GRAFT_TEST_IO_LOG");
  if (*path == '\0') return;
  char line[1024];
  const int size = std::snprintf(line, sizeof line, "%s %s %s\n", what, first, second);
  const long fd = ::syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_APPEND, 0600);
  ::syscall(SYS_write, fd, line, size);
  ::syscall(SYS_close, fd);
}

void note(const char* what, int fd) {
  char link[64];
  char path[512];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t size = ::readlink(link, path, sizeof path - 1);
  path[size > 0 ? size : 0] = '\0';
  note(what, path);
}

int openAs(const char* name, const char* path, int flags, unsigned mode) {
  static const auto real = next(static_cast<int (*)(const char*, int, ...)>(&::open), "open");
  if (fails("open", EIO)) return -1;
  if ((flags & O_CREAT) != 0) note(name, path);
  return real(path, flags, mode);
}

/// The calendar, s.
time_t jumping(time_t now) {
  static const long step = std::atol(setting("GRAFT_TEST_CLOCK"));
  static std::atomic<long> looks{0};
  return now + (looks++ % 2 == 0 ? step : -step);
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const unsigned mode = va_arg(rest, unsigned);
  va_end(rest);
  return openAs("create", path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const unsigned mode = va_arg(rest, unsigned);
  va_end(rest);
  return openAs("create", path, flags, mode);
}
int mkostemp(char* path, int flags) {
  static const auto real = next(&::mkostemp, "mkostemp");
  if (fails("open", ENOSPC)) return -1;
  const int fd = real(path, flags);
  note("create", path);
  return fd;
}
char* mkdtemp(char* path) {
  static const auto real = next(&::mkdtemp, "mkdtemp");
  if (fails("open", ENOSPC)) return nullptr;
  char* made = real(path);
  note("create", path);
  return made;
}
int mkdir(const char* path, mode_t mode) {
  static const auto real = next(&::mkdir, "mkdir");
  if (fails("open", ENOSPC)) return -1;
  note("create", path);
  return real(path, mode);
}
ssize_t read(int fd, void* to, std::size_t size) {
  static const auto real = next(&::read, "read");
  const Do what = fd > 2 ? chosen("read") : Do::kNothing;
  if (what == Do::kShort && size > 1) return real(fd, to, 1);
  if (what == Do::kNothing || what == Do::kShort) return real(fd, to, size);
  errno = what == Do::kInterrupt ? EINTR : EIO;
  return -1;
}
ssize_t pread(int fd, void* to, std::size_t size, off_t offset) {
  static const auto real = next(&::pread, "pread");
  const Do what = chosen("read");
  if (what == Do::kShort && size > 1) return real(fd, to, 1, offset);
  if (what == Do::kNothing || what == Do::kShort) return real(fd, to, size, offset);
  errno = what == Do::kInterrupt ? EINTR : EIO;
  return -1;
}
ssize_t write(int fd, const void* from, std::size_t size) {
  static const auto real = next(&::write, "write");
  const Do what = fd > 2 ? chosen("write") : Do::kNothing;
  if (what == Do::kFail || what == Do::kInterrupt) {
    errno = what == Do::kInterrupt ? EINTR : ENOSPC;
    return -1;
  }
  if (fd > 2) note("write", fd);
  return real(fd, from, what == Do::kShort ? (size + 1) / 2 : size);
}
int fsync(int fd) {
  static const auto real = next(&::fsync, "fsync");
  if (fails("fsync", EIO)) return -1;
  note("fsync", fd);
  return real(fd);
}
int close(int fd) {
  static const auto real = next(&::close, "close");
  if (fd <= 2) return real(fd);
  const bool bad = fails("close", EIO);
  const int status = real(fd);
  if (!bad) return status;
  errno = EIO;
  return -1;
}
int rename(const char* from, const char* to) {
  static const auto real =
      next(static_cast<int (*)(const char*, const char*)>(&::rename), "rename");
  if (fails("rename", ENOSPC)) return -1;
  note("rename", from, to);
  return real(from, to);
}
int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) {
  static const auto real = next(&::renameat2, "renameat2");
  if (fails("rename", ENOSPC)) return -1;
  note("exchange", from, to);
  return real(from_folder, from, to_folder, to, flags);
}
int unlink(const char* path) {
  static const auto real = next(&::unlink, "unlink");
  return fails("unlink", EIO) ? -1 : real(path);
}

int clock_gettime(clockid_t clock, timespec* time) noexcept {
  const long status = ::syscall(SYS_clock_gettime, clock, time);
  if (clock == CLOCK_REALTIME && status == 0) time->tv_sec = jumping(time->tv_sec);
  return int(status);
}
int gettimeofday(timeval* time, void*) noexcept {
  timespec now = {};
  ::clock_gettime(CLOCK_REALTIME, &now);
  time->tv_sec = now.tv_sec;
  time->tv_usec = now.tv_nsec / 1000;
  return 0;
}
time_t time(time_t* out) noexcept {
  timespec now = {};
  ::clock_gettime(CLOCK_REALTIME, &now);
  if (out != nullptr) *out = now.tv_sec;
  return now.tv_sec;
}
}
