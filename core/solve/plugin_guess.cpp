// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/plugin_guess.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/solve/edge_batch.hpp"
#include "core/types/plugin_call.hpp"

namespace graft {

namespace {

/// A problem as plain arrays over a state of its own.
class GuessView {
 public:
  GuessView(const Problem& problem, const State& state) : problem_(problem), state_(state) {
    const Graph& graph = problem.graph();
    vertices_ = graph.verticesById();
    for (const VertexBlock& block : graph.vertexBlocks()) places_.emplace_back(block.ids.size());
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      const VertexRef v = vertices_[i];
      places_[std::size_t(v.type)][std::size_t(v.index)] = std::int64_t(i);
      types_.push_back(&graph.type(v));
      ids_.push_back(graph.id(v));
      held_.push_back(problem.blockOf(v) < 0 ? 1 : 0);
      estimates_.push_back(state_.values.at(v));
    }
    placed_.assign(vertices_.size(), 0);
    const auto& groups = problem.groups();
    for (std::size_t g = 0; g < groups.size(); ++g) addGroup(groups[g], g);
    for (std::size_t g = 0; g < groups.size(); ++g) {
      views_[g].vertices = group_vertices_[g].data();
      views_[g].batch.information = group_information_[g].data();
    }
    view_ = {sizeof(graft_guess_problem),
             std::int64_t(vertices_.size()),
             types_.data(),
             ids_.data(),
             held_.data(),
             estimates_.data(),
             placed_.data(),
             std::int64_t(views_.size()),
             views_.data()};
  }

  PluginGuessResult run(const graft_guess_type& type) {
    PluginGuessResult result;
    graft_message message = {};
    const Values before = state_.values;
    const int status = callPlugin(Callback::kGuess, type.name, message,
                                  [&] { return type.guess(&view_, &message); });
    if (status != GRAFT_OK) {
      result.failed = true;
      result.reason = message.text;
      return result;
    }
    for (std::size_t i = 0; i < vertices_.size(); ++i) check(type, before, i);
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      if (placed_[i] != 0) result.placed.push_back(vertices_[i]);
    }
    result.values = std::move(state_.values);
    return result;
  }

 private:
  void addGroup(const EdgeGroup& group, std::size_t index) {
    batches_.push_back(std::make_unique<EdgeBatch>(group, index, state_, 0, group.count));
    std::vector<std::int64_t> vertices;
    for (const VertexRef v : group.vertices) {
      vertices.push_back(places_[std::size_t(v.type)][std::size_t(v.index)]);
    }
    group_vertices_.push_back(std::move(vertices));
    const auto dim = Eigen::Index(group.error_dim);
    const auto size = std::size_t(dim * dim);
    numbers_.emplace_back(std::size_t(group.count) * size);
    std::vector<const double*> information;
    for (std::int64_t e = 0; e < group.count; ++e) {
      double* out = numbers_.back().data() + std::size_t(e) * size;
      const Eigen::Map<const Eigen::MatrixXd> root(group.roots.data() + std::size_t(e) * size, dim,
                                                   dim);
      Eigen::Map<Eigen::MatrixXd>(out, dim, dim) = root.transpose() * root;
      information.push_back(out);
    }
    group_information_.push_back(std::move(information));
    graft_guess_group view = {};
    view.struct_size = sizeof view;
    view.type = group.type;
    view.batch = batches_.back()->view();
    views_.push_back(view);
  }

  void check(const graft_guess_type& type, const Values& before, std::size_t i) {
    const VertexRef v = vertices_[i];
    double* estimate = state_.values.at(v);
    const auto refuse = [&](const std::string& what) {
      throw Error(ExitCode::kPlugin, std::string("initial guess ") + type.name + ": " +
                                         problem_.describeVertex(v) + " " + what);
    };
    const double* old = before.at(v);
    if (!std::equal(old, old + types_[i]->ambient_dim, estimate)) {
      if (held_[i] != 0) refuse("is held, but was moved");
      if (placed_[i] == 0) refuse("was moved without being marked as placed");
    }
    if (placed_[i] == 0) return;
    if (held_[i] != 0) refuse("is held, but was marked as placed");
    graft_message message = {};
    const int status = callPlugin(Callback::kNormalize, types_[i]->tag, message,
                                  [&] { return types_[i]->normalize(estimate, &message); });
    if (status != GRAFT_OK) {
      refuse("got numbers that are no estimate: " + std::string(message.text));
    }
    if (!std::all_of(estimate, estimate + types_[i]->ambient_dim,
                     [](double number) { return std::isfinite(number); })) {
      refuse("got numbers that are not finite");
    }
  }

  const Problem& problem_;
  State state_;
  std::vector<VertexRef> vertices_;
  std::vector<std::vector<std::int64_t>> places_;  ///< by type and index
  std::vector<const graft_vertex_type*> types_;
  std::vector<std::int64_t> ids_;
  std::vector<std::uint8_t> held_;
  std::vector<double*> estimates_;
  std::vector<std::uint8_t> placed_;
  std::vector<std::unique_ptr<EdgeBatch>> batches_;
  std::vector<std::vector<std::int64_t>> group_vertices_;
  std::vector<std::vector<double>> numbers_;  ///< information matrices of a group
  std::vector<std::vector<const double*>> group_information_;
  std::vector<graft_guess_group> views_;
  graft_guess_problem view_ = {};
};

}  // namespace

PluginGuessResult guessByPlugin(const Problem& problem, const State& state,
                                const graft_guess_type& type) {
  return GuessView(problem, state).run(type);
}

}  // namespace graft
