// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/report.hpp"

#include "apps/report/page.hpp"
#include "apps/report/pictures.hpp"

namespace graft::report {

namespace {

/// Draws pictures into the page and into files of their own.
class Writer {
 public:
  Writer(Page& page, StagedDirectory& out) : page_(page), out_(out) {}

  void one(const Picture& picture) {
    page_.figure(picture);
    write(picture);
  }
  void many(const std::vector<Picture>& pictures, const std::string& caption) {
    page_.figures(pictures, caption);
    for (const Picture& picture : pictures) write(picture);
  }

 private:
  void write(const Picture& picture) {
    out_.write("pictures/" + picture.name + ".svg", picture.svg.standalone(picture.title));
  }

  Page& page_;
  StagedDirectory& out_;
};

std::string mapCaption(const lfd::LearnResult& result) {
  std::string caption =
      "Bases and gripper paths of all demonstrations, seen from above. At first the base stands "
      "where the person stood; in the end it should be green everywhere.";
  if (result.scene.map == nullptr) return caption + " The task has no map of obstacles.";
  return caption +
         " Red squares are footprints that touch an occupied cell; they should disappear.";
}

void addResult(Page& page, Writer& pictures, const lfd::LearnResult& result) {
  addTable(page, result);
  pictures.one(tablePicture(result));
  page.heading("Where the robot stands");
  pictures.many(mapPictures(result), mapCaption(result));
  addGrasp(page, result);
  pictures.one(graspPicture(result));
  page.heading("Demonstrations");
  pictures.one(segmentsPicture(result));
  pictures.one(tracksPicture(result));
  addSolve(page, result);
  pictures.one(convergencePicture(result.summary));
  pictures.one(graphPicture(result));
  addModel(page, result);
}

}  // namespace

void writeReport(const lfd::LearnResult& result, StagedDirectory& out,
                 const std::vector<std::string>& messages) {
  const std::string& task = result.task.task.name;
  Page page((task.empty() ? "Unnamed task" : task) +
            (result.common_grasp ? ": learned from demonstrations" : ": no common grasp"));
  Writer pictures(page, out);
  addOverview(page, result);
  if (result.common_grasp) {
    if (result.holds.modes.size() > 1) {
      addModes(page, result);
      pictures.one(holdsPicture(result));
    }
    addMessages(page, result, messages);
    addResult(page, pictures, result);
  } else {
    addDisagreement(page, result);
    pictures.one(holdsPicture(result));
    addMessages(page, result, messages);
    page.heading("Demonstrations");
    pictures.one(segmentsPicture(result));
  }
  addWeights(page, result);
  addSeconds(page, result);
  out.write("report.html", page.text());
}

void writeTuning(const std::vector<lfd::TuneTrial>& trials, StagedDirectory& out) {
  const Picture picture = tunePicture(trials);
  out.write("pictures/tune.svg", picture.svg.standalone(picture.title));
}

}  // namespace graft::report
