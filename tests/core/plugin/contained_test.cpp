// SPDX-License-Identifier: BSD-3-Clause
#include "core/plugin/contained.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "core/base/error.hpp"

namespace graft {
namespace {

ContainedLimits quick() {
  ContainedLimits limits;
  limits.step_seconds = 0.3;
  return limits;
}

TEST(Contained, HandsOverWhatTheBodySays) {
  int here = 1;
  const std::string large(100000, 'x');
  const ContainedResult result = runContained(ContainedLimits(), [&](ContainedChannel& channel) {
    here = 2;
    channel.step("first");
    channel.message("a\nb");
    channel.message(large);
    channel.step("second");
    std::puts("not for the parent's standard output");
  });
  EXPECT_TRUE(result.finished);
  EXPECT_EQ(result.failure, "");
  EXPECT_EQ(result.last_step, "second");
  EXPECT_EQ(result.messages, (std::vector<std::string>{"a\nb", large}));
  EXPECT_EQ(here, 1) << "the body ran in this process";
}

struct EndCase {
  void (*body)(ContainedChannel&);
  const char* failure;
};

TEST(Contained, EveryOtherEndIsNamed) {
  const EndCase cases[] = {
      {[](ContainedChannel&) { ::raise(SIGKILL); }, "signal 9 (Killed)"},
      {[](ContainedChannel&) { std::abort(); }, "signal 6 (Aborted)"},
      {[](ContainedChannel&) { std::_Exit(0); }, "it ended the process (exit status 0)"},
      {[](ContainedChannel&) { std::_Exit(3); }, "it ended the process (exit status 3)"},
      {[](ContainedChannel&) {
         for (;;) ::pause();
       },
       "no answer within 0.3 s"},
      {[](ContainedChannel&) {
         for (int fd = 0; fd < 256; ++fd) ::close(fd);
         for (;;) ::pause();
       },
       "no answer within 0.3 s"},
      {[](ContainedChannel&) { throw std::runtime_error("oh"); }, "it threw an exception: oh"},
      {[](ContainedChannel&) { throw Error(ExitCode::kPlugin, "no"); }, "no"},
      {[](ContainedChannel&) { throw 1; }, "it threw an exception"},
  };
  for (const EndCase& one : cases) {
    const ContainedResult result = runContained(quick(), [&](ContainedChannel& channel) {
      channel.step("here");
      one.body(channel);
    });
    EXPECT_FALSE(result.finished);
    EXPECT_EQ(result.failure, one.failure);
    EXPECT_EQ(result.last_step, "here");
  }
}

TEST(Contained, AStepRestartsTheClock) {
  const ContainedResult result = runContained(quick(), [](ContainedChannel& channel) {
    for (int i = 0; i < 8; ++i) {
      ::usleep(100000);
      channel.step("one more");
    }
  });
  EXPECT_TRUE(result.finished) << result.failure;
}

TEST(Contained, AGrandchildDoesNotHoldTheParentUp) {
  const ContainedResult result = runContained(quick(), [](ContainedChannel&) {
    if (::fork() == 0) {
      ::sleep(30);
      std::_Exit(0);
    }
  });
  EXPECT_TRUE(result.finished) << result.failure;
}

TEST(Contained, ItsLastWordsAreKept) {
  const ContainedResult result = runContained(quick(), [](ContainedChannel&) {
    std::fputs("first line\nsecond line\n", stderr);
    std::abort();
  });
  EXPECT_EQ(result.said, "first line");
}

TEST(Contained, AnInterruptEndsIt) {
  const std::atomic<int> flag{SIGINT};
  ContainedLimits limits;
  limits.interrupt = &flag;
  try {
    runContained(limits, [](ContainedChannel&) {
      for (;;) ::pause();
    });
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kInterrupted);
  }
}

}  // namespace
}  // namespace graft
