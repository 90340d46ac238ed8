// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// All that a plugin includes. A complete plugin:
//
//   #include "core/types/plugin.hpp"
//   struct MyEdge : graft::Edge<MyEdge, 6, graft::SE3, graft::SE3> { ... };
//   GRAFT_PLUGIN(mine, registry) { registry.add<MyEdge>(); }
//
// and in CMake: graft_add_plugin(mine SOURCES plugin.cpp).

#include "core/types/batch.hpp"
#include "core/types/dynamic_edge.hpp"
#include "core/types/edge.hpp"
#include "core/types/one_to_many_edge.hpp"
#include "core/types/resource.hpp"
#include "core/types/stamp.hpp"
#include "core/types/vertex.hpp"

namespace graft {

/// What a plugin registers with; lives only during registration.
class PluginRegistry {
 public:
  explicit PluginRegistry(const graft_registrar* registrar) : registrar_(registrar) {}

  /// An edge type (derived of Edge, DynamicEdge or OneToManyEdge).
  template <class E>
  void add() {
    registrar_->add_edge_type(registrar_->host, &E::descriptor());
  }
  /// A vertex type, from its value template.
  template <template <class> class V>
  void addVertex() {
    registrar_->add_vertex_type(registrar_->host, &vertexType<V>());
  }
  /// A resource type, described by ResourceTag<R>.
  template <class R>
  void addResource() {
    registrar_->add_resource_type(registrar_->host, &resourceType<R>());
  }
  void addKernel(const graft_kernel_type& type) {
    registrar_->add_kernel_type(registrar_->host, &type);
  }
  void addSolver(const graft_solver_type& type) {
    registrar_->add_solver_type(registrar_->host, &type);
  }
  void addLoader(const graft_loader_type& type) {
    registrar_->add_loader_type(registrar_->host, &type);
  }
  void addGuess(const graft_guess_type& type) {
    registrar_->add_guess_type(registrar_->host, &type);
  }

 private:
  const graft_registrar* registrar_;
};

}  // namespace graft

// Set per plugin by graft_add_plugin().
#ifndef GRAFT_PLUGIN_VERSION
#define GRAFT_PLUGIN_VERSION "0"
#endif
#ifndef GRAFT_PLUGIN_LICENSE
#define GRAFT_PLUGIN_LICENSE "unspecified"
#endif
#ifndef GRAFT_PLUGIN_REQUIRES
#define GRAFT_PLUGIN_REQUIRES ""
#endif

#define GRAFT_EXPORT __attribute__((visibility("default")))

// NOLINTBEGIN(bugprone-macro-parentheses): a parameter's name takes no parentheses
/// Defines the stamp and the entry point of a plugin; the block that follows
/// registers its types.
#define GRAFT_PLUGIN(plugin_name, registry)                                                      \
  static void graftRegisterTypes(::graft::PluginRegistry& registry);                             \
  extern "C" {                                                                                   \
  extern GRAFT_EXPORT const graft_abi_stamp graft_plugin_stamp;                                  \
  __attribute__((used, section(GRAFT_STAMP_SECTION))) const graft_abi_stamp graft_plugin_stamp = \
      ::graft::makeStamp(#plugin_name, GRAFT_PLUGIN_VERSION, GRAFT_PLUGIN_LICENSE,               \
                         GRAFT_PLUGIN_REQUIRES);                                                 \
  GRAFT_EXPORT int graft_plugin_register(const graft_registrar* registrar,                       \
                                         graft_message* message) {                               \
    return ::graft::detail::guarded(message, [&] {                                               \
      ::graft::PluginRegistry types(registrar);                                                  \
      graftRegisterTypes(types);                                                                 \
      return GRAFT_OK;                                                                           \
    });                                                                                          \
  }                                                                                              \
  }                                                                                              \
  static void graftRegisterTypes(::graft::PluginRegistry& registry)
// NOLINTEND(bugprone-macro-parentheses)
