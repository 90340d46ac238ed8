// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <charconv>
#include <cmath>
#include <memory>
#include <stdexcept>
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

/// The finite numbers that a resource's tokens are, as many as `fields` names
/// (separated by blanks). Throws std::invalid_argument with what is wrong.
inline std::vector<double> resourceNumbers(const std::vector<std::string>& tokens,
                                           const std::string& fields) {
  std::size_t count = 1;
  for (const char c : fields) count += c == ' ' ? 1 : 0;
  if (tokens.size() != count) {
    throw std::invalid_argument("expected " + std::to_string(count) + " numbers (" + fields +
                                "), got " + std::to_string(tokens.size()));
  }
  std::vector<double> numbers;
  for (const std::string& token : tokens) {
    double number = 0;
    const char* end = token.data() + token.size();
    const auto [stop, error] = std::from_chars(token.data(), end, number);
    if (error != std::errc() || stop != end || !std::isfinite(number)) {
      throw std::invalid_argument("'" + token + "' is not a finite number");
    }
    numbers.push_back(number);
  }
  return numbers;
}

/// The pose that seven numbers of a resource are; throws std::invalid_argument
/// where the quaternion's length is not near one.
inline Pose resourcePose(double* numbers) {
  const double length =
      std::hypot(std::hypot(numbers[3], numbers[4]), std::hypot(numbers[5], numbers[6]));
  if (!(length > 0.5 && length < 2.0)) {
    throw std::invalid_argument("the length of the quaternion is not near 1");
  }
  Pose::normalize(numbers);
  return Pose::fromArray(numbers);
}

}  // namespace graft
