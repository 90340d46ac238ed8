// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/types/abi.h"

namespace graft {

namespace detail {

template <int N>
constexpr void copyText(char (&to)[N], const char* from) {
  int i = 0;
  for (; i < N - 1 && from[i] != '\0'; ++i) to[i] = from[i];
  for (; i < N; ++i) to[i] = '\0';
}

constexpr std::uint32_t sanitizerBits() {
  std::uint32_t bits = 0;
#if defined(__SANITIZE_ADDRESS__)
  bits |= 1u;
#endif
#if defined(__SANITIZE_THREAD__)
  bits |= 2u;
#endif
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
  bits |= 1u;
#endif
#if __has_feature(thread_sanitizer)
  bits |= 2u;
#endif
#endif
  return bits;
}

constexpr std::uint32_t isaBits() {
  std::uint32_t bits = 0;
#if defined(__AVX__)
  bits |= 1u;
#endif
#if defined(__AVX2__)
  bits |= 2u;
#endif
#if defined(__FMA__)
  bits |= 4u;
#endif
#if defined(__AVX512F__)
  bits |= 8u;
#endif
  return bits;
}

}  // namespace detail

/// The stamp of code compiled here; constant, so that it can be read from the
/// file without running anything.
constexpr graft_abi_stamp makeStamp(const char* name, const char* version, const char* license,
                                    const char* requires_plugins) {
  graft_abi_stamp stamp = {};
  stamp.magic = GRAFT_ABI_MAGIC;
  stamp.stamp_size = sizeof(graft_abi_stamp);
  stamp.abi_major = GRAFT_ABI_MAJOR;
  stamp.abi_minor = GRAFT_ABI_MINOR;
  stamp.size_of_real = sizeof(double);
  stamp.size_of_pointer = sizeof(void*);
  stamp.size_of_vertex_type = sizeof(graft_vertex_type);
  stamp.size_of_edge_type = sizeof(graft_edge_type);
  stamp.size_of_registrar = sizeof(graft_registrar);
  stamp.sanitizers = detail::sanitizerBits();
  stamp.isa = detail::isaBits();
  detail::copyText(stamp.name, name);
  detail::copyText(stamp.version, version);
  detail::copyText(stamp.license, license);
  detail::copyText(stamp.requires_plugins, requires_plugins);
  return stamp;
}

}  // namespace graft
