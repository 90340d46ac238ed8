// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/segments_file.hpp"

#include "core/base/text.hpp"

namespace graft::lfd {

std::string formatSegments(const std::vector<MatchedDemonstration>& matched,
                           const std::vector<Segmentation>& segments) {
  if (matched.size() != segments.size()) {
    throw Error(ExitCode::kInternal, "segments and demonstrations differ in number");
  }
  std::string out = "demo,grasp_time,release_time\n";
  for (std::size_t i = 0; i < matched.size(); ++i) {
    out += matched[i].name;
    out += ',';
    appendDouble(out, matched[i].times.at(segments[i].grasp));
    out += ',';
    appendDouble(out, matched[i].times.at(segments[i].release));
    out += '\n';
  }
  return out;
}

}  // namespace graft::lfd
