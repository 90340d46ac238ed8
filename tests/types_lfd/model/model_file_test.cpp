// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/model/model_file.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "tests/support/test_data.hpp"
#include "tests/types_lfd/model/synthetic_motion.hpp"

namespace graft::lfd {
namespace {

MotionModel smallModel() {
  FitOptions options;
  options.mixture.components = 2;
  return testing::SyntheticTask().model(options);
}

TEST(ModelFile, RoundTripIsExact) {
  const MotionModel model = smallModel();
  const std::string text = formatModel(model);
  const std::string path =
      graft::testing::writeTestFile(graft::testing::makeTemporaryDirectory(), "model.json", text);
  const MotionModel read = readModel(path);
  EXPECT_EQ(formatModel(read), text);
  EXPECT_EQ(read.task, model.task);
  ASSERT_EQ(read.segments.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const SegmentModel& a = model.segments[i];
    const SegmentModel& b = read.segments[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.duration, b.duration);
    EXPECT_EQ(a.start, b.start);
    EXPECT_EQ(a.end, b.end);
    EXPECT_EQ(a.chart.orientation_mean.coeffs(), b.chart.orientation_mean.coeffs());
    ASSERT_EQ(a.mixture.components.size(), b.mixture.components.size());
    for (std::size_t k = 0; k < a.mixture.components.size(); ++k) {
      EXPECT_EQ(a.mixture.components[k].weight, b.mixture.components[k].weight);
      EXPECT_EQ(a.mixture.components[k].mean, b.mixture.components[k].mean);
      EXPECT_EQ(a.mixture.components[k].covariance, b.mixture.components[k].covariance);
    }
  }
}

struct BadModel {
  const char* what;
  const char* replace;  ///< first occurrence of this in a good file ...
  const char* by;       ///< ... is replaced by this
  const char* message;
};

std::ostream& operator<<(std::ostream& out, const BadModel& bad) { return out << bad.what; }

class BadModels : public ::testing::TestWithParam<BadModel> {};

TEST_P(BadModels, AreRefusedWithTheirField) {
  std::string text = formatModel(smallModel());
  const std::size_t at = text.find(GetParam().replace);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, std::string(GetParam().replace).size(), GetParam().by);
  try {
    parseModel(text, "model.json");
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kInput);
    EXPECT_EQ(e.formatted(), GetParam().message);
  }
}

INSTANTIATE_TEST_SUITE_P(
    ModelFile, BadModels,
    ::testing::Values(
        BadModel{"another format", "graft motion model", "pbd",
                 "model.json: error: format must be 'graft motion model', not 'pbd'"},
        BadModel{"a later version", "\"version\": 1", "\"version\": 2",
                 "model.json: error: version must be 1"},
        BadModel{"version as text", "\"version\": 1", "\"version\": \"1\"",
                 "model.json: error: version must be an integer of at least 1"},
        BadModel{"unknown field", "\"version\": 1", "\"version\": 1, \"vresion\": 1",
                 "model.json: error: the file has an unknown field 'vresion'"},
        BadModel{"repeated field", "\"version\": 1", "\"version\": 1, \"version\": 1",
                 "model.json: error: the field 'version' occurs twice"},
        BadModel{"missing field", "\"duration\"", "\"durations\"",
                 "model.json: error: segments[0] has an unknown field 'durations'"},
        BadModel{"task not a text", "\"task\": \"synthetic\"", "\"task\": 3",
                 "model.json: error: task must be a text"},
        BadModel{"segments not a list", "\"segments\": [", "\"segments\": 7, \"x\": [",
                 "model.json: error: the file has an unknown field 'x'"},
        BadModel{"no JSON", "\"version\": 1", "\"version\": nan",
                 "model.json:3:14: error: not valid JSON"},
        BadModel{"huge number", "\"version\": 1", "\"version\": 1e999",
                 "model.json: error: a number is out of range"},
        BadModel{"negative duration", "\"duration\": ", "\"duration\": -",
                 "model.json: error: segments[0].duration must be positive"},
        BadModel{"another axis", "\"heading_axis\": \"x\"", "\"heading_axis\": \"w\"",
                 "model.json: error: segments[0].heading_axis must be 'x', 'y' or 'z'"},
        BadModel{"another dimension", "\"gripper_rx\"", "\"gripper_qx\"",
                 "model.json: error: segments[0].dimensions[4] must be 'gripper_rx', not "
                 "'gripper_qx'"},
        BadModel{"long quaternion", "\"orientation_mean\": [", "\"orientation_mean\": [0,",
                 "model.json: error: segments[0].orientation_mean must have 4 entries, not 5"},
        BadModel{"priors too large", "\"priors\": [", "\"priors\": [1, ",
                 "model.json: error: segments[0].means must have 3 entries, not 2"},
        BadModel{"empty name", "\"name\": \"reach\"", "\"name\": \"\"",
                 "model.json: error: segments[0].name must not be empty"}));

TEST(ModelFile, AFileCutOffAnywhereIsRefused) {
  const std::string text = formatModel(smallModel());
  for (std::size_t size = 0; size + 2 < text.size(); size += 1 + size / 7) {
    try {
      parseModel(text.substr(0, size), "m");
      FAIL() << size;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ExitCode::kInput);
      EXPECT_GT(e.where().line, 0);
    }
  }
}

TEST(ModelFile, NumbersThatContradictAreRefused) {
  const auto messageOf = [](const auto& change) -> std::string {
    MotionModel model = smallModel();
    change(model.segments[1]);
    try {
      parseModel(formatModel(model), "m");
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_EQ(messageOf([](SegmentModel&) {}), "accepted");
  EXPECT_EQ(messageOf([](SegmentModel& s) { s.mixture.components[0].weight += 1e-6; }),
            "segments[1].priors must sum to 1");
  EXPECT_EQ(messageOf([](SegmentModel& s) { s.mixture.components[0].weight = -0.1; }),
            "segments[1].priors[0] must be positive");
  EXPECT_EQ(messageOf([](SegmentModel& s) { s.mixture.components[1].covariance(2, 3) += 1; }),
            "segments[1].covariances[1] must be symmetric");
  EXPECT_EQ(messageOf([](SegmentModel& s) { s.mixture.components[1].covariance(3, 3) = -1; }),
            "segments[1].covariances[1] must be positive semidefinite with a positive variance of "
            "t");
  EXPECT_EQ(messageOf([](SegmentModel& s) { s.chart.orientation_mean.coeffs() *= 2; }),
            "segments[1].orientation_mean must have length 1");
  EXPECT_EQ(messageOf([](SegmentModel& s) { s.mixture.components.clear(); }),
            "segments[1].priors must not be empty");
}

TEST(ModelFile, AMissingFileIsNamed) {
  try {
    readModel("/nowhere/model.json");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kInput);
    EXPECT_NE(e.formatted().find("/nowhere/model.json"), std::string::npos);
  }
}

}  // namespace
}  // namespace graft::lfd
