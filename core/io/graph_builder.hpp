// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string_view>
#include <unordered_map>

#include "core/io/graph_loader.hpp"

namespace graft {

/// What a tag of a graph file means; all null if nothing provides it.
struct TagType {
  const graft_vertex_type* vertex = nullptr;
  const graft_edge_type* edge = nullptr;
  const graft_resource_type* resource = nullptr;
  /// Where "qx qy qz qw" stands among the type's numbers, -1 = nowhere.
  int quaternion = -1;
  bool known() const { return vertex != nullptr || edge != nullptr || resource != nullptr; }
};

/// Where "qx qy qz qw" stands among the numbers that `fields` names; -1 = nowhere.
int quaternionField(const char* fields);

/// The host's side of loading: collects what a reader finds, in any order, and
/// resolves it at the end (ids, slots, resources). Defects go to the
/// diagnostics with their lines.
class GraphBuilder {
 public:
  GraphBuilder(std::string path, Registry& registry, const LoadOptions& options,
               Diagnostics& diagnostics);

  /// What a tag means; loads the plugin that has it.
  const TagType& tag(std::string_view name);
  /// Reports, or counts, a line with a tag that nothing provides.
  void unknownTag(std::string_view name, std::int64_t line);

  void addVertex(const TagType& type, std::int64_t id, const double* estimate, int count,
                 std::int64_t line);
  void addResource(const TagType& type, std::int64_t id, std::vector<std::string> tokens,
                   std::int64_t line);
  void fix(std::int64_t id, std::int64_t line) { fixed_.push_back({id, line}); }
  struct EdgeNumbers {
    const std::int64_t* vertices;
    int arity;
    const std::int64_t* resources;
    int resource_count;
    const double* measurement;
    int measurement_count;
    const double* information;
    int information_count;
  };
  void addEdge(const TagType& type, const EdgeNumbers& numbers, std::int64_t line);

  /// The robust kernel, or level, of the edge that was added last. Reports an unknown
  /// name, a width that is not positive, a negative level, and an edge that has one already.
  void setKernel(std::string_view name, double width, std::int64_t line, std::int64_t column);
  void setLevel(std::int32_t level, std::int64_t line);

  /// Says that a vertex or resource could not be read: edges are then not
  /// checked, for their complaints would be echoes.
  void definitionLost() { definitions_good_ = false; }

  void error(std::int64_t line, std::int64_t column, const std::string& text);
  void warning(std::int64_t line, const std::string& text);
  Diagnostics& diagnostics() { return diagnostics_; }
  const std::string& path() const { return path_; }

  /// Tells where a token of a line stands (0 = the tag), for better messages.
  using ColumnOf = std::function<std::int64_t(std::int64_t line, int token)>;
  void setColumns(ColumnOf columns) { columns_ = std::move(columns); }

  /// Resolves everything. The result is usable only if no error was reported.
  LoadedGraph finish();

 private:
  struct PendingEdge {
    const TagType* type;
    std::int64_t line;
    std::size_t ids;      ///< first of arity + resource_count ids
    std::size_t numbers;  ///< first of measurement, then information
    std::int32_t arity;
    std::int32_t resource_count;
    std::int32_t measurement_count;
    std::int32_t information_count;
    std::int32_t kernel = -1;
    std::int32_t level = -1;
  };
  struct PendingResource {
    const TagType* type;
    std::int64_t id;
    std::vector<std::string> tokens;
    std::int64_t line;
  };
  struct PendingFix {
    std::int64_t id;
    std::int64_t line;
  };

  std::int64_t column(std::int64_t line, int token) const;
  bool checkQuaternion(const TagType& type, const double* numbers, std::int64_t line);
  bool checkInformation(const PendingEdge& edge, int error_dim, double* upper);
  static std::string nameOf(const PendingEdge& edge);
  void resolveResources();
  void makeVertices();
  void resolveEdge(const PendingEdge& edge);
  void resolveFixed();
  void findIsolated();

  std::string path_;
  Registry& registry_;
  const LoadOptions& options_;
  Diagnostics& diagnostics_;
  ColumnOf columns_;
  std::unordered_map<std::string, TagType> tags_;
  const TagType* last_tag_ = nullptr;
  std::string last_name_;
  TagType unknown_;
  LoadedGraph loaded_;
  std::vector<PendingEdge> edges_;
  std::vector<std::int64_t> ids_;
  std::vector<double> numbers_;
  std::vector<double> good_information_;  ///< the last one judged, to skip repeats
  std::vector<PendingResource> resources_;
  std::vector<PendingFix> fixed_;
  std::size_t vertex_lines_ = 0;
  bool definitions_good_ = true;
};

}  // namespace graft
