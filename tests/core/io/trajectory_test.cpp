// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/trajectory.hpp"

#include <gtest/gtest.h>

#include "tests/support/test_data.hpp"

namespace graft {
namespace {

struct Read {
  Trajectory track;
  std::string messages;
  std::size_t errors = 0;
};

Read read(const std::string& name, const std::string& content) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string path = testing::writeTestFile(folder, name, content);
  Diagnostics diagnostics;
  Read result;
  result.track = readTrack(path, diagnostics);
  result.messages = diagnostics.text();
  result.errors = diagnostics.errorCount();
  return result;
}

TEST(ReadTrackCsv, TakesColumnsByNameInAnyOrder) {
  const Read tum = read("a.tum", "1.5 1 2 3 0 0 0.6 0.8\n2.5 4 5 6 0 0 0 1\n");
  const Read csv = read("a.csv",
                        "timestamp,x,y,z,qx,qy,qz,qw\n1.5,1,2,3,0,0,0.6,0.8\n"
                        "2.5,4,5,6,0,0,0,1\n");
  const Read mixed = read("b.CSV",
                          "\xEF\xBB\xBF# a comment\r\nqw, qz ,frame,z,y,x,qy,qx,timestamp,speed\r\n"
                          "\r\n0.8,0.6,map,3,2,1,0,0, 1.5 ,\r\n1,0,map,6,5,4,0,0,+2.5,9\r\n");
  ASSERT_EQ(tum.track.size(), 2u);
  EXPECT_EQ(tum.track.times, (std::vector<double>{1.5, 2.5}));
  EXPECT_EQ(tum.track.poses[0].translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(tum.track.poses[0].rotation.coeffs(), Eigen::Vector4d(0, 0, 0.6, 0.8));
  EXPECT_EQ(tum.track.poses[1].translation, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(formatTum(csv.track), formatTum(tum.track));
  EXPECT_EQ(formatTum(mixed.track), formatTum(tum.track));
  EXPECT_EQ(csv.messages, "");
  EXPECT_NE(mixed.messages.find("b.CSV:2: note: columns that are not read: 'frame', 'speed'"),
            std::string::npos)
      << mixed.messages;
}

TEST(ReadTrackCsv, RefusesWhatIsNoTrack) {
  struct Case {
    const char* name;
    const char* content;
    const char* message;
  };
  const std::string header = "timestamp,x,y,z,qx,qy,qz,qw\n";
  const Case cases[] = {
      {"empty file", "", ".csv: error: a track needs at least 2 poses, this has 0"},
      {"no header", "0,1,2,3,0,0,0,1\n1,1,2,3,0,0,0,1\n",
       ".csv:1: error: no column 'timestamp'; expected a header with the names "
       "timestamp,x,y,z,qx,qy,qz,qw"},
      {"missing column", "timestamp,x,y,z,qx,qy,qz\n", ":1: error: no column 'qw'"},
      {"column twice", "timestamp,x,x,y,z,qx,qy,qz,qw\n", ":1: error: more than one column 'x'"},
      {"semicolons", "timestamp;x;y;z;qx;qy;qz;qw\n", "separated by commas, got 'timestamp;x"},
      {"quoted", "\"timestamp\",x,y,z,qx,qy,qz,qw\n", ":1: error: no column 'timestamp'"},
      {"capitals", "timestamp,X,y,z,qx,qy,qz,qw\n", ":1: error: no column 'x'"},
      {"few fields", "H0,1,2,3,0,0,0\n", ":2: error: expected 8 fields as in the header, got 7"},
      {"many fields", "H0,1,2,3,0,0,0,1,\n",
       ":2: error: expected 8 fields as in the header, got 9"},
      {"empty field", "H0,1,,3,0,0,0,1\n", ":2:5: error: the field 'y' is empty"},
      {"word", "H0,1,2,3,0,0,zero,1\n", ":2:13: error: 'zero' is not a number"},
      {"nan", "H0,nan,2,3,0,0,0,1\n", ":2:3: error: 'nan' is not a finite number"},
      {"quaternion", "H0,1,2,3,0,0,0,0\n", ":2: error: the quaternion has length 0"},
      {"stamps fall", "H1,1,2,3,0,0,0,1\n0,1,2,3,0,0,0,1\n",
       ":3: error: time stamps must rise: 0 follows 1"},
      {"stamps repeat", "H1,1,2,3,0,0,0,1\n1,1,2,3,0,0,0,1\n",
       ":3: error: time stamps must rise: 1 follows 1"},
      {"one pose", "H1,1,2,3,0,0,0,1\n", "a track needs at least 2 poses, this has 1"}};
  for (const Case& one : cases) {
    SCOPED_TRACE(one.name);
    std::string content = one.content;
    if (!content.empty() && content[0] == 'H') content = header + content.substr(1);
    const Read result = read("t.csv", content);
    EXPECT_GE(result.errors, 1u);
    EXPECT_NE(result.messages.find(one.message), std::string::npos) << result.messages;
  }
}

}  // namespace
}  // namespace graft
