// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/types/abi.h"
#include "core/types/vertex.hpp"

namespace graft {

/// Makes a class a resource that edges can share (see graft_resource_type).
/// Specialise it with kTag, kDoc, kFields and
///   static std::unique_ptr<const R> load(const std::string& directory,
///                                        const std::vector<std::string>& tokens);
/// which throws on failure. Relative file names are relative to `directory`.
template <class R>
struct ResourceTag;

/// The descriptor of a resource type.
template <class R>
const graft_resource_type& resourceType() {
  static const graft_resource_type type = {
      sizeof(graft_resource_type),
      ResourceTag<R>::kTag,
      ResourceTag<R>::kDoc,
      ResourceTag<R>::kFields,
      [](const char* directory, std::int32_t count, const char* const* tokens,
         graft_message* message) {
        const void* loaded = nullptr;
        detail::guarded(message, [&] {
          const std::vector<std::string> list(tokens, tokens + count);
          std::unique_ptr<const R> resource = ResourceTag<R>::load(directory, list);
          loaded = resource.release();
          return GRAFT_OK;
        });
        return loaded;
      },
      [](const void* resource) { delete static_cast<const R*>(resource); }};
  return type;
}

}  // namespace graft
