// SPDX-License-Identifier: BSD-3-Clause
#include "apps/common/last_words.hpp"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <mutex>
#include <new>

#include "core/base/error.hpp"
#include "core/types/plugin_call.hpp"
#include "core/types/stamp.hpp"

namespace graft {

namespace {

constexpr int kCode = static_cast<int>(ExitCode::kPlugin);

/// A line put together without memory of the heap.
class Line {
 public:
  Line& operator<<(const char* text) {
    const std::size_t length = std::min(std::strlen(text), sizeof text_ - 2 - size_);
    for (std::size_t i = 0; i < length; ++i) {
      const char c = text[i];
      text_[size_++] = static_cast<unsigned char>(c) < ' ' || c == 0x7f ? '?' : c;
    }
    return *this;
  }
  Line& operator<<(int number) {
    char digits[12];
    std::size_t at = sizeof digits;
    digits[--at] = '\0';
    do {
      digits[--at] = char('0' + number % 10);
      number /= 10;
    } while (number > 0);
    return *this << digits + at;
  }
  void write() {
    text_[size_++] = '\n';
    const ssize_t ignored = ::write(2, text_, size_);
    static_cast<void>(ignored);
  }

 private:
  char text_[1024];
  std::size_t size_ = 0;
};

/// "path: error: TYPE: function()".
Line& operator<<(Line& line, const PluginActivity& activity) {
  const char* library = libraryOf(activity.tag);
  if (*library != '\0') line << library << ": ";
  return line << "error: " << activity.tag << ": " << callbackName(activity.callback) << " ";
}

/// The end of each of these lines.
struct Outputs {};
Line& operator<<(Line& line, Outputs) {
  line << "; outputs that were not complete are as they were before";
  const char* input = WorkSubject::now();
  if (*input != '\0') line << "; input: " << input;
  return line;
}
constexpr Outputs kOutputs;

/// Where a handler stands, in case the stack is what overflowed.
alignas(16) std::array<char, 1 << 16> main_stack;

void crashed(int signal) {
  // A second crash, in here, ends as it would without us.
  ::signal(signal, SIG_DFL);
  const PluginActivity activity = PluginCall::ofThisThread();
  if (activity.tag == nullptr) {
    ::raise(signal);
    return;
  }
  Line line;
  line << activity << "crashed: signal " << signal << " (" << ::sigdescr_np(signal) << ")"
       << kOutputs;
  line.write();
  ::_exit(kCode);
}

/// Where no exception can be thrown any more for want of memory, or one leaves a function
/// that may not throw (before main() those of global objects, too), the end is that of any
/// other lack of memory.
std::terminate_handler usual_end = nullptr;
[[noreturn]] void ended() {
  bool memory = false;
  if (const std::exception_ptr error = std::current_exception()) {
    try {
      std::rethrow_exception(error);
    } catch (const std::bad_alloc&) {
      memory = true;
    } catch (...) {
    }
  } else {
    void* volatile room = std::malloc(1024);  // volatile: clang would leave the call out
    memory = room == nullptr;
    std::free(room);
  }
  if (memory) {
    Line line;
    line << "error: out of memory" << kOutputs;
    line.write();
    ::_exit(static_cast<int>(ExitCode::kResources));
  }
  if (usual_end != nullptr) usual_end();
  std::abort();
}

// Before every other constructor of the program.
__attribute__((constructor(101))) void installEnd() { usual_end = std::set_terminate(&ended); }

void exited() {
  const PluginActivity activity = PluginCall::ofThisThread();
  if (activity.tag == nullptr) return;
  Line line;
  line << activity << "ended the program" << kOutputs;
  line.write();
  ::_exit(kCode);
}

}  // namespace

void sayActivity(const char* what) {
  const PluginActivity activity = PluginCall::ofAnyThread();
  if (activity.tag == nullptr) return;
  Line line;
  line << activity << what << kOutputs;
  line.write();
}

void installLastWords() {
  std::atexit(&exited);
  std::at_quick_exit(&exited);
  // A sanitizer's own report says more.
  if (detail::sanitizerBits() != 0) return;
  stack_t stack = {};
  stack.ss_sp = main_stack.data();
  stack.ss_size = main_stack.size();
  ::sigaltstack(&stack, nullptr);
  struct sigaction action = {};
  action.sa_handler = &crashed;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_ONSTACK | SA_NODEFER;
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) {
    ::sigaction(signal, &action, nullptr);
  }
}

struct Watchdog::Shared {
  Shared(double limit_, double patience_) : limit(limit_), patience(patience_) {}

  using Clock = std::chrono::steady_clock;
  struct Seen {
    std::uint64_t number = 0;
    Clock::time_point since;
    bool inside = false;
  };

  static void* run(void* self) {
    static_cast<Shared*>(self)->watch();
    return nullptr;
  }

  void watch() {
    const Clock::time_point start = Clock::now();
    std::unique_lock<std::mutex> lock(mutex);
    while (!wake.wait_for(lock, std::chrono::milliseconds(50), [this] { return stop; })) {
      const Clock::time_point now = Clock::now();
      for (int place = 0; place < PluginCall::kPlaces; ++place) {
        const PluginActivity activity = PluginCall::at(place);
        Seen& before = seen[std::size_t(place)];
        const bool inside = activity.tag != nullptr;
        if (!inside || !before.inside || before.number != activity.number) {
          before = {activity.number, now, inside};
        }
        if (!inside || activity.callback == Callback::kSolver) continue;
        const double lasts = std::chrono::duration<double>(now - before.since).count();
        const double total = std::chrono::duration<double>(now - start).count();
        if (activity.isShort() && limit > 0 && total > limit &&
            lasts >= std::max(kPatience, limit)) {
          end(activity, lasts, "the time limit of %g s is over", limit);
        }
        if (patience > 0 && lasts >= patience) {
          end(activity, lasts, "the limit of --plugin-patience is %g s", patience);
        }
      }
    }
  }

  [[noreturn]] static void end(const PluginActivity& activity, double lasts, const char* why,
                               double seconds) {
    char text[128];
    const int size = std::snprintf(text, sizeof text, "has not returned for %.0f s, ", lasts);
    std::snprintf(text + size, sizeof text - std::size_t(size), why, seconds);
    Line line;
    line << activity << text << kOutputs;
    line.write();
    ::_exit(kCode);
  }

  double limit;
  double patience;
  std::array<Seen, PluginCall::kPlaces> seen;
  std::mutex mutex;
  std::condition_variable wake;
  bool stop = false;
  pthread_t thread = {};
};

Watchdog::Watchdog(double limit, double patience) {
  if (!(limit > 0) && !(patience > 0)) return;
  shared_ = std::make_unique<Shared>(limit, patience);
  // Not a std::thread: that takes megabytes of address space, and memory may be scarce.
  pthread_attr_t small;
  ::pthread_attr_init(&small);
  ::pthread_attr_setstacksize(&small, 1 << 17);
  if (::pthread_create(&shared_->thread, &small, &Shared::run, shared_.get()) != 0) {
    shared_.reset();
  }
  ::pthread_attr_destroy(&small);
}

Watchdog::~Watchdog() {
  if (!shared_) return;
  {
    const std::lock_guard<std::mutex> lock(shared_->mutex);
    shared_->stop = true;
  }
  shared_->wake.notify_all();
  ::pthread_join(shared_->thread, nullptr);
}

}  // namespace graft
