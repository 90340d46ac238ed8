// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/types/abi.h"

namespace graft {

/// Kinds of things that plugins provide.
enum class Kind { kVertex, kEdge, kResource, kKernel, kSolver, kLoader, kGuess };
/// All of them, in this order.
constexpr Kind kAllKinds[] = {Kind::kVertex, Kind::kEdge,   Kind::kResource, Kind::kKernel,
                              Kind::kSolver, Kind::kLoader, Kind::kGuess};
const char* kindName(Kind kind);

/// One thing that a plugin provides: its kind and tag (or name).
struct Provided {
  Kind kind;
  std::string name;
  bool operator<(const Provided& o) const { return kind != o.kind ? kind < o.kind : name < o.name; }
  bool operator==(const Provided& o) const { return kind == o.kind && name == o.name; }
};

/// A plugin as the registry knows it.
struct PluginRecord {
  std::string name;
  std::string file;
  std::string version;
  std::string license;
  std::vector<Provided> provides;
};

/// Names -> descriptors. Nothing registers itself: a plugin's entry function is
/// run against a staging area, what it offers is checked, and all of it is
/// committed, or nothing. A name that is taken is an error that names both
/// files. Not thread-safe; descriptors live as long as the process.
class Registry {
 public:
  /// Asked once for a name that is not known; returns true if it registered
  /// something that provides it (e.g. by loading a plugin).
  using Resolver = std::function<bool(const Provided& wanted)>;

  /// Runs `entry` and commits what it registers. Throws Error(kPlugin) with
  /// the file, and leaves the registry as it was, if the function fails or any
  /// descriptor is invalid or taken.
  const PluginRecord& registerPlugin(const std::string& name, const std::string& file,
                                     const std::string& version, const std::string& license,
                                     graft_register_function entry);

  void setResolver(Resolver resolver) { resolver_ = std::move(resolver); }
  /// Text appended to "unknown ..." errors, e.g. which plugin has the name.
  using Advisor = std::function<std::string(const Provided& wanted)>;
  void setAdvisor(Advisor advisor) { advisor_ = std::move(advisor); }

  /// The descriptor, or null if nothing provides it (after asking the resolver).
  const graft_vertex_type* vertex(const std::string& tag);
  const graft_edge_type* edge(const std::string& tag);
  const graft_resource_type* resource(const std::string& tag);
  const graft_kernel_type* kernel(const std::string& name);
  const graft_solver_type* solver(const std::string& name);
  const graft_loader_type* loader(const std::string& name);
  const graft_guess_type* guess(const std::string& name);

  bool has(const Provided& wanted) const { return entries_.count(wanted) > 0; }
  /// What is registered now, sorted by kind and name.
  std::vector<Provided> provided() const;
  const std::vector<PluginRecord>& plugins() const { return plugins_; }
  /// The plugin that provides a registered name; null if none.
  const PluginRecord* providerOf(const Provided& wanted) const;

  /// Advice for a name that is not known: the nearest known names by edit
  /// distance and what the advisor says. Starts with a blank, may be empty.
  std::string advice(const Provided& wanted) const;

 private:
  struct Entry {
    const void* descriptor;
    std::size_t plugin;
  };
  const void* find(Kind kind, const std::string& name);

  std::map<Provided, Entry> entries_;
  std::vector<PluginRecord> plugins_;
  Resolver resolver_;
  Advisor advisor_;
};

/// The vertex tag that slot `k` of an edge type needs.
inline const char* slotType(const graft_edge_type& type, int k) {
  const bool further = type.arity == GRAFT_DYNAMIC && k >= type.dynamic_slots;
  return type.slot_types[further ? type.dynamic_slots - 1 : k];
}

/// Dimensions of an edge type over `arity` vertices; false with a text where it has none,
/// or its shape() says what cannot be.
bool edgeShape(const graft_edge_type& type, int arity, int& error_dim, int& measurement_dim,
               graft_message& message);

/// Levenshtein distance, for "did you mean".
std::size_t editDistance(const std::string& a, const std::string& b);

}  // namespace graft
