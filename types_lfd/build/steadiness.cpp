// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/build/steadiness.hpp"

#include <algorithm>
#include <array>

namespace graft::lfd {

void findSteadiness(PreparedTask& prepared) {
  Weights& w = prepared.weights;
  struct Found {
    MatchedTrack MatchedDemonstration::*track;
    TrackerAccuracy accuracy;
    const char* name;
    std::array<Sigma*, kMotionPhases> weights;
  };
  const DemonstrationAccuracy& accuracy = prepared.demonstrations.front().accuracy;
  const Found entities[] = {
      {&MatchedDemonstration::hand,
       accuracy.hand,
       "steady_hand",
       {&w.steady_hand_free, &w.steady_hand_contact, &w.steady_hand_held}},
      {&MatchedDemonstration::object,
       accuracy.object,
       "steady_object",
       {&w.steady_object_free, &w.steady_object_contact, &w.steady_object_held}}};
  for (const Found& entity : entities) {
    const bool given = std::any_of(
        prepared.task.weights.begin(), prepared.task.weights.end(), [&](const WeightOverride& o) {
          return o.edge == "steady_motion" || o.edge.rfind(entity.name, 0) == 0;
        });
    if (given) continue;
    std::vector<PhasedTrack> tracks;
    for (const PreparedDemonstration& d : prepared.demonstrations) {
      PhasedTrack track{&d.matched.times, &(d.matched.*entity.track), {}};
      for (std::size_t i = 0; i < d.size(); ++i) track.phases.push_back(d.phase(i));
      tracks.push_back(std::move(track));
    }
    const auto noise =
        estimateMotionNoise(tracks, entity.accuracy, {w.steady_motion.t, w.steady_motion.r});
    for (std::size_t p = 0; p < kMotionPhases; ++p) *entity.weights[p] = {noise[p].t, noise[p].r};
  }
}

}  // namespace graft::lfd
