// SPDX-License-Identifier: BSD-3-Clause
// An initial guess along the odometry: every vertex from the one whose id is one less (or
// one more, behind a held vertex), by the edges that join the two. Where loop closures may
// be wrong this is the safer start; what has no such edge is left to a spanning tree.
#include <algorithm>
#include <cstdio>
#include <vector>

#include "core/types/plugin.hpp"

namespace {

/// An edge between vertices whose ids differ by one.
struct Step {
  std::int64_t from;
  std::int64_t to;
  const graft_guess_group* group;
  std::int64_t edge;
  int slot;  ///< of `to`
};

std::vector<Step> findSteps(const graft_guess_problem& problem) {
  std::vector<Step> steps;
  for (std::int64_t g = 0; g < problem.group_count; ++g) {
    const graft_guess_group& group = problem.groups[g];
    if (group.batch.arity != 2 || group.type->propagate == nullptr) continue;
    for (std::int64_t e = 0; e < group.batch.count; ++e) {
      const std::int64_t a = group.vertices[2 * e];
      const std::int64_t b = group.vertices[2 * e + 1];
      const std::int64_t apart = problem.ids[b] - problem.ids[a];
      if (apart != 1 && apart != -1) continue;
      steps.push_back({a, b, &group, e, 1});
      steps.push_back({b, a, &group, e, 0});
    }
  }
  // Where several edges join two vertices, the first one that can tell counts.
  std::stable_sort(steps.begin(), steps.end(),
                   [](const Step& l, const Step& r) { return l.from < r.from; });
  return steps;
}

int guess(const graft_guess_problem* problem, graft_message* message) {
  return graft::detail::guarded(message, [&] {
    const std::vector<Step> steps = findSteps(*problem);
    std::vector<std::int64_t> queue;
    for (std::int64_t v = 0; v < problem->vertex_count; ++v) {
      if (problem->held[v] != 0) queue.push_back(v);
    }
    std::int64_t placed = 0;
    std::vector<double> estimate;
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const std::int64_t from = queue[next];
      auto step = std::lower_bound(steps.begin(), steps.end(), from,
                                   [](const Step& s, std::int64_t v) { return s.from < v; });
      for (; step != steps.end() && step->from == from; ++step) {
        const std::int64_t to = step->to;
        if (problem->held[to] != 0 || problem->placed[to] != 0) continue;
        const graft_edge_batch edge = graft::singleEdge(step->group->batch, step->edge);
        const int dim = problem->types[to]->ambient_dim;
        estimate.assign(problem->estimates[to], problem->estimates[to] + dim);
        if (step->group->type->propagate(&edge, step->slot, estimate.data()) != GRAFT_OK) continue;
        std::copy(estimate.begin(), estimate.end(), problem->estimates[to]);
        problem->placed[to] = 1;
        queue.push_back(to);
        ++placed;
      }
    }
    if (placed > 0) return GRAFT_OK;
    std::snprintf(message->text, sizeof message->text,
                  "no edge joins a held vertex and one whose id is one more or less");
    return GRAFT_FAILED;
  });
}

constexpr graft_guess_type kType = {sizeof(graft_guess_type), "odometry",
                                    "every vertex from the one with the id before it", &guess};

}  // namespace

GRAFT_PLUGIN(guess_odometry, registry) { registry.addGuess(kType); }
