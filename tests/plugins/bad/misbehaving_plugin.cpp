// SPDX-License-Identifier: BSD-3-Clause
// A plugin that does what the environment variable GRAFT_TEST_MISBEHAVIOUR names:
// while it is loaded, or with "register_" before the name, while it registers.
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cfenv>
#include <clocale>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>
#include <thread>

#include "core/types/stamp.hpp"

namespace {

void misbehave(const char* how) {
  const auto is = [how](const char* name) { return std::strcmp(how, name) == 0; };
  if (is("throws")) throw std::runtime_error("thrown while loading");
  if (is("aborts")) std::abort();
  if (is("crashes")) ::raise(SIGSEGV);
  if (is("exits")) std::_Exit(0);
  while (is("loops")) ::usleep(1000);
  // Address space only: nothing of it is touched.
  while (is("eats")) static_cast<void>(::operator new (std::size_t{1} << 28));
  if (is("closes_stderr")) ::close(2);
  if (is("closes_all")) {
    for (int fd = 0; fd < 256; ++fd) ::close(fd);
  }
  if (is("locale")) std::setlocale(LC_ALL, "C.UTF-8");
  if (is("rounding")) std::fesetround(FE_UPWARD);
  if (is("handler")) ::signal(SIGTERM, SIG_IGN);
  if (is("folder") && ::chdir("/") != 0) std::abort();
  if (is("mask")) ::umask(0);
  if (is("thread")) std::thread([] { ::pause(); }).detach();
  if (is("says")) {
    std::fputs("goodbye, cruel world\n", stderr);
    std::abort();
  }
}

const char* chosen() {
  const char* how = std::getenv("GRAFT_TEST_MISBEHAVIOUR");
  return how != nullptr ? how : "";
}

struct Constructed {
  Constructed() { misbehave(chosen()); }
};
// Its constructor runs while the library is loaded.
const Constructed constructed;

const graft_kernel_type kKernel = {sizeof kKernel, "Misbehaving", "s itself",
                                   [](std::int64_t count, const double* s, double, double* rho) {
                                     for (std::int64_t i = 0; i < count; ++i) {
                                       rho[3 * i] = s[i];
                                       rho[3 * i + 1] = 1;
                                       rho[3 * i + 2] = 0;
                                     }
                                   }};

}  // namespace

#define GRAFT_TEST_EXPORT __attribute__((visibility("default")))

extern "C" {
extern GRAFT_TEST_EXPORT const graft_abi_stamp graft_plugin_stamp;
__attribute__((used, section(GRAFT_STAMP_SECTION))) const graft_abi_stamp graft_plugin_stamp =
    graft::makeStamp("misbehaving", "1", "BSD-3-Clause", "");

GRAFT_TEST_EXPORT int graft_plugin_register(const graft_registrar* registrar, graft_message*) {
  const char* how = chosen();
  if (std::strncmp(how, "register_", 9) == 0) misbehave(how + 9);
  registrar->add_kernel_type(registrar->host, &kKernel);
  return GRAFT_OK;
}
}
