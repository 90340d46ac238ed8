// SPDX-License-Identifier: BSD-3-Clause
// Motion models: model.json, and mixtures as the authors of the paper publish them.
#include "tests/fuzz/fuzz.hpp"
#include "types_lfd/model/mixture_file.hpp"
#include "types_lfd/model/model_file.hpp"

namespace graft::fuzz {

void fuzzOne(std::string_view bytes) {
  const std::string text(bytes);
  accepts([&](Diagnostics&) {
    const std::string written = lfd::formatModel(lfd::parseModel(text, "model.json"));
    require(lfd::formatModel(lfd::parseModel(written, "written")) == written,
            "written, read and written again it is not the same");
  });
  accepts([&](Diagnostics& found) {
    const lfd::MixtureFile file = lfd::parseMixtureFile(text, "mixture.txt", found);
    lfd::toSegmentModel(file, "reach", 1, found);
  });
}

}  // namespace graft::fuzz
