// SPDX-License-Identifier: BSD-3-Clause
// Plugins with one defect each; the build defines GRAFT_BAD_<DEFECT>.
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "core/types/plugin.hpp"

namespace {

/// Runs when the library is loaded: a test sees whether that happened.
struct Marker {
  Marker() {
    const char* path = std::getenv("GRAFT_TEST_MARKER");
    if (path == nullptr) return;
    if (std::FILE* file = std::fopen(path, "w")) std::fclose(file);
  }
};
const Marker marker;

[[maybe_unused]] constexpr graft_abi_stamp stampWithDefect() {
  graft_abi_stamp stamp = graft::makeStamp(GRAFT_BAD_NAME, "1", "BSD-3-Clause", GRAFT_BAD_REQUIRES);
#if defined(GRAFT_BAD_MAJOR)
  stamp.abi_major = 99;
#elif defined(GRAFT_BAD_MINOR)
  stamp.abi_minor = GRAFT_ABI_MINOR + 1;
#elif defined(GRAFT_BAD_OLDER)
  // No defect: before initial guesses came, the registrar had one entry less.
  stamp.abi_minor = 1;
  stamp.size_of_registrar -= sizeof(void*);
#elif defined(GRAFT_BAD_OLDER_SIZE)
  stamp.abi_minor = 1;
  stamp.size_of_registrar += sizeof(void*);
#elif defined(GRAFT_BAD_SIZE)
  stamp.size_of_edge_type += 8;
#elif defined(GRAFT_BAD_SANITIZER)
  stamp.sanitizers ^= 2;
#elif defined(GRAFT_BAD_ISA)
  stamp.isa = 1u << 30;
#elif defined(GRAFT_BAD_MAGIC)
  stamp.magic = 0;
#endif
  return stamp;
}

/// A kernel that may have a defect.
[[maybe_unused]] graft_kernel_type kernel(const char* name, bool good) {
  graft_kernel_type type = {};
  type.struct_size = sizeof type;
  type.name = name;
  type.doc = "does nothing";
  if (good) type.evaluate = [](std::int64_t, const double*, double, double*) {};
  return type;
}

}  // namespace

#if defined(GRAFT_BAD_UNDEFINED)
extern "C" int graft_test_nobody_has_this();
#endif

extern "C" {
#if !defined(GRAFT_BAD_NO_STAMP)
extern GRAFT_EXPORT const graft_abi_stamp graft_plugin_stamp;
__attribute__((used, section(GRAFT_STAMP_SECTION))) const graft_abi_stamp graft_plugin_stamp =
    stampWithDefect();
#endif

#if !defined(GRAFT_BAD_NO_ENTRY)
GRAFT_EXPORT int graft_plugin_register(const graft_registrar* registrar, graft_message* message) {
  static const graft_kernel_type good = kernel("Good_" GRAFT_BAD_NAME, true);
  registrar->add_kernel_type(registrar->host, &good);
#if defined(GRAFT_BAD_FAILS)
  graft::detail::setMessage(message, "no licence key");
  return GRAFT_FAILED;
#elif defined(GRAFT_BAD_THROWS)
  throw std::runtime_error("thrown through the boundary");
#elif defined(GRAFT_BAD_DUPLICATE)
  registrar->add_vertex_type(registrar->host, &graft::vertexType<graft::SE2>());
#elif defined(GRAFT_BAD_HALF)
  static const graft_kernel_type bad = kernel("Bad", false);
  registrar->add_kernel_type(registrar->host, &bad);
#elif defined(GRAFT_BAD_TAG)
  static const graft_kernel_type bad = kernel("two words", true);
  registrar->add_kernel_type(registrar->host, &bad);
#elif defined(GRAFT_BAD_UNDEFINED)
  return graft_test_nobody_has_this();
#endif
  (void)message;
  return GRAFT_OK;
}
#endif
}
