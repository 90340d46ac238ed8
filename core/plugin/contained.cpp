// SPDX-License-Identifier: BSD-3-Clause
#include "core/plugin/contained.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <utility>

#include "core/base/error.hpp"
#include "core/types/stamp.hpp"

namespace graft {

namespace {

using Clock = std::chrono::steady_clock;

/// A file descriptor that is closed at the end.
struct Descriptor {
  explicit Descriptor(int fd_) : fd(fd_) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  void close() {
    if (fd >= 0) ::close(fd);
    fd = -1;
  }
  int fd;
};

std::size_t addressSpaceInUse() {
  unsigned long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * std::size_t(::sysconf(_SC_PAGESIZE));
}

void limit(int what, std::size_t value) {
  rlimit bounds = {};
  if (::getrlimit(static_cast<__rlimit_resource>(what), &bounds) != 0) return;
  if (bounds.rlim_max == RLIM_INFINITY || bounds.rlim_max > value) bounds.rlim_max = value;
  bounds.rlim_cur = bounds.rlim_max;
  ::setrlimit(static_cast<__rlimit_resource>(what), &bounds);
}

std::string firstLine(int fd) {
  char bytes[2048];
  const ssize_t got = ::pread(fd, bytes, sizeof bytes, 0);
  std::string text(bytes, got > 0 ? std::size_t(got) : 0);
  text.erase(0, text.find_first_not_of("\r\n \t="));
  text.resize(std::min(text.find_first_of("\r\n"), text.size()));
  if (text.size() > 200) text.resize(200);
  return text;
}

std::string describeEnd(int status) {
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return "signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ")";
  }
  return "it ended the process (exit status " + std::to_string(WEXITSTATUS(status)) + ")";
}

/// Records as they come through the pipe: kind, length, bytes.
class Records {
 public:
  explicit Records(ContainedResult& result) : result_(result) {}

  void append(const char* bytes, std::size_t size) {
    buffer_.append(bytes, size);
    std::uint32_t length = 0;
    constexpr std::size_t kHead = 1 + sizeof length;
    while (buffer_.size() >= kHead) {
      std::memcpy(&length, buffer_.data() + 1, sizeof length);
      if (buffer_.size() < kHead + length) return;
      take(buffer_[0], buffer_.substr(kHead, length));
      buffer_.erase(0, kHead + length);
    }
  }
  /// True once since the last call if a step was begun.
  bool progressed() { return std::exchange(progressed_, false); }

 private:
  void take(char kind, std::string text) {
    progressed_ = true;
    if (kind == 's')
      result_.last_step = std::move(text);
    else if (kind == 'm')
      result_.messages.push_back(std::move(text));
    else if (kind == 'd')
      result_.finished = true;
    else if (kind == 'e') {
      result_.threw = true;
      result_.failure = std::move(text);
    }
  }
  ContainedResult& result_;
  std::string buffer_;
  bool progressed_ = false;
};

}  // namespace

void ContainedChannel::send(char kind, const std::string& text) {
  const auto length = static_cast<std::uint32_t>(text.size());
  std::string record(1, kind);
  record.append(reinterpret_cast<const char*>(&length), sizeof length);
  record += text;
  for (std::size_t done = 0; done < record.size();) {
    const ssize_t put = ::write(fd_, record.data() + done, record.size() - done);
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) ::_exit(static_cast<int>(ExitCode::kInternal));
    done += static_cast<std::size_t>(put);
  }
}

/// What happens between fork() and the end of the child.
class ContainedChild {
 public:
  [[noreturn]] static void run(const ContainedLimits& limits, int channel_fd, int streams_fd,
                               const std::function<void(ContainedChannel&)>& body) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    // The parent tells how the child ended: its own handlers stay out of it.
    for (const int signal :
         {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) {
      ::signal(signal, SIG_DFL);
    }
#ifdef __GLIBCXX__
    std::set_terminate(&__gnu_cxx::__verbose_terminate_handler);
#else
    std::set_terminate(&std::abort);
#endif
    const int null = ::open("/dev/null", O_RDONLY);
    if (null >= 0) ::dup2(null, 0);
    if (null > 2) ::close(null);
    ::dup2(streams_fd, 1);
    ::dup2(streams_fd, 2);
    limit(RLIMIT_CORE, 0);
    if (limits.memory > 0 && detail::sanitizerBits() == 0) {
      limit(RLIMIT_AS, addressSpaceInUse() + limits.memory);
    }
    ContainedChannel channel(channel_fd);
    try {
      body(channel);
      channel.send('d', "");
    } catch (const Error& e) {
      channel.send('e', e.what());
    } catch (const std::bad_alloc&) {
      channel.send('e', "out of memory");
    } catch (const std::exception& e) {
      channel.send('e', std::string("it threw an exception: ") + e.what());
    } catch (...) {
      channel.send('e', "it threw an exception");
    }
    // Not exit(): what the parent registered for its own end is not the child's.
    ::_exit(0);
  }
};

ContainedResult runContained(const ContainedLimits& limits,
                             const std::function<void(ContainedChannel&)>& body) {
  ContainedResult result;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) {
    throw Error(ExitCode::kResources, std::string("cannot make a pipe: ") + std::strerror(errno));
  }
  Descriptor reading(ends[0]);
  Descriptor writing(ends[1]);
  const Descriptor streams(::memfd_create("graft-child", MFD_CLOEXEC));
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child < 0) {
    throw Error(ExitCode::kResources,
                std::string("cannot make a process: ") + std::strerror(errno));
  }
  if (child == 0) ContainedChild::run(limits, writing.fd, streams.fd, body);
  writing.close();

  Records records(result);
  const auto step = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(limits.step_seconds));
  Clock::time_point deadline = Clock::now() + step;
  bool late = false;
  bool interrupted = false;
  bool open = true;
  bool gone = false;
  int status = 0;
  while (open && !late && !interrupted) {
    // Slices, for a grandchild may hold the pipe open after the child's end.
    pollfd wanted = {reading.fd, POLLIN, 0};
    const int ready = ::poll(&wanted, 1, 50);
    if (ready > 0) {
      char bytes[4096];
      const ssize_t got = ::read(reading.fd, bytes, sizeof bytes);
      if (got > 0)
        records.append(bytes, static_cast<std::size_t>(got));
      else if (got == 0 || errno != EINTR)
        open = false;
    } else if (gone) {
      open = false;
    }
    gone = gone || ::waitpid(child, &status, WNOHANG) == child;
    if (records.progressed()) deadline = Clock::now() + step;
    late = !gone && Clock::now() >= deadline;
    interrupted = limits.interrupt != nullptr && *limits.interrupt != 0;
  }
  // A child may have closed the pipe and live on.
  while (!gone && !late && !interrupted) {
    gone = ::waitpid(child, &status, WNOHANG) == child;
    late = !gone && Clock::now() >= deadline;
    if (!gone) ::usleep(500);
  }
  ::kill(-child, SIGKILL);
  if (!gone) {
    ::kill(child, SIGKILL);
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  }
  if (interrupted) throw Error(ExitCode::kInterrupted, "interrupted");
  if (result.finished || result.threw) return result;
  if (late) {
    char text[64];
    std::snprintf(text, sizeof text, "no answer within %g s", limits.step_seconds);
    result.failure = text;
  } else {
    result.failure = describeEnd(status);
  }
  result.said = firstLine(streams.fd);
  return result;
}

}  // namespace graft
