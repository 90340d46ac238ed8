// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/refine/refine.hpp"

#include <algorithm>

#include "core/base/parallel.hpp"
#include "types_lfd/refine/track_refiner.hpp"

namespace graft::lfd {

namespace {

void note(const std::string& demo, std::size_t count, const std::string& what,
          std::vector<std::string>& notes) {
  if (count > 0) notes.push_back(demo + ": " + std::to_string(count) + " " + what);
}

}  // namespace

RefineResult refineBases(const std::vector<DemonstrationEstimate>& demonstrations,
                         const TaskScene& scene, const RefineOptions& options) {
  RefineResult result;
  result.tracks.resize(demonstrations.size());
  ThreadPool pool(options.threads);
  pool.run(std::int64_t(demonstrations.size()), [&](std::int64_t d) {
    const auto k = std::size_t(d);
    result.tracks[k] = TrackRefiner(demonstrations[k], scene, options).run();
  });
  for (std::size_t d = 0; d < demonstrations.size(); ++d) {
    const RefinedTrack& track = result.tracks[d];
    const std::string& name = demonstrations[d].name;
    result.tuples += demonstrations[d].size();
    result.moved += track.moved;
    result.mean_distance += track.moved_distance;
    result.mean_turn += track.moved_angle;
    result.farthest = std::max(result.farthest, track.farthest);
    result.farthest_turn = std::max(result.farthest_turn, track.farthest_turn);
    result.unresolved += track.unresolved;
    result.blocked_steps += track.blocked_steps;
    result.fast_steps += track.fast_steps;
    result.solved += track.joints.solved;
    note(name, track.unresolved, "tuples have no base that is free and in reach nearby",
         result.notes);
    note(name, track.blocked_steps, "steps of the base lead through occupied cells", result.notes);
    note(name, track.fast_steps, "steps are too fast for the arm's joints or the base",
         result.notes);
  }
  if (result.moved > 0) {
    result.mean_distance /= double(result.moved);
    result.mean_turn /= double(result.moved);
  }
  return result;
}

}  // namespace graft::lfd
