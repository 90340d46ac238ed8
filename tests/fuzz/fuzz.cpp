// SPDX-License-Identifier: BSD-3-Clause
#include "tests/fuzz/fuzz.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace graft::fuzz {

File::File(std::string_view bytes) {
  static const int descriptor = memfd_create("fuzz", MFD_CLOEXEC);
  require(descriptor >= 0 && ftruncate(descriptor, 0) == 0, "no file in memory");
  path_ = "/proc/self/fd/" + std::to_string(descriptor);
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t written =
        pwrite(descriptor, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    require(written > 0, "the file in memory cannot be written");
    done += static_cast<std::size_t>(written);
  }
}

void fail(const std::string& why) {
  std::fprintf(stderr, "finding: %s\n", why.c_str());
  std::abort();
}

void requireBlamesInput(const Error& error) {
  const ExitCode code = error.code();
  require(code == ExitCode::kInput || code == ExitCode::kNoResult || code == ExitCode::kResources,
          "exit code " + std::to_string(static_cast<int>(code)) +
              " for bytes of a file: " + error.formatted());
  require(error.what()[0] != '\0', "an error without a text");
}

void count(bool taken) {
  static std::size_t all = 0;
  static std::size_t good = 0;
  if (all++ == 0) {
    std::atexit([] { std::fprintf(stderr, "taken %zu of %zu\n", good, all); });
  }
  good += taken ? 1 : 0;
}

}  // namespace graft::fuzz

// Declared by libFuzzer's contract.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  graft::fuzz::fuzzOne({reinterpret_cast<const char*>(data), size});
  return 0;
}
