// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/robot/urdf.hpp"

#include <gtest/gtest.h>

#include <clocale>

#include "tests/support/test_data.hpp"
#include "types_lfd/robot/chain.hpp"

namespace graft::lfd {
namespace {

const char* const kJoint =
    "<joint name='j' type='revolute'><parent link='a'/><child link='b'/>"
    "<axis xyz='0 0 1'/><limit lower='-1' upper='1' velocity='1'/></joint>";

/// A robot of two links on lines 2 and 3, then `body`.
std::string robot(const std::string& body) {
  return "<robot name='r'>\n<link name='a'/>\n<link name='b'/>\n" + body + "\n</robot>\n";
}

std::string joint(const std::string& inside, const std::string& type = "revolute") {
  return "<joint name='j' type='" + type + "'><parent link='a'/><child link='b'/>\n" + inside +
         "</joint>";
}

std::string messagesOf(const std::string& text) {
  Diagnostics diagnostics;
  try {
    readUrdfText("f.urdf", text, diagnostics);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    return error.formatted();
  }
  return diagnostics.errorCount() > 0 ? diagnostics.text() : std::string();
}

struct BadUrdf {
  const char* what;
  std::string text;
  const char* message;
};

TEST(Urdf, RefusesDefectsWithTheirLine) {
  const std::string limit = "<limit lower='-1' upper='1' velocity='1'/>";
  const std::vector<BadUrdf> cases = {
      {"empty", "", "f.urdf:"},
      {"wrong root", "<sdf/>", "f.urdf:1: error: expected <robot>"},
      {"two roots", "<robot name='r'/><robot name='r'/>", "second root element"},
      {"dtd", "<!DOCTYPE x [<!ENTITY a 'b'>]><robot name='r'/>", "not allowed"},
      {"truncated", robot(kJoint).substr(0, 70), "not valid XML"},
      {"no links", "<robot name='r'/>", "no links"},
      {"no name", "<robot/>", "needs the attribute 'name'"},
      {"joint loop",
       "<robot name='r'><link name='r'/><link name='a'/><link name='b'/>\n"
       "<joint name='1' type='fixed'><parent link='a'/><child link='b'/></joint>\n"
       "<joint name='2' type='fixed'><parent link='b'/><child link='a'/></joint></robot>",
       "f.urdf:3: error: the joints form a loop: 'a' <- 'b' <- 'a'"},
      {"self joint",
       robot("<joint name='j' type='fixed'><parent link='a'/><child link='a'/></joint>"),
       "f.urdf:4: error: joint 'j' joins link 'a' to itself"},
      {"two parents",
       "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>\n"
       "<joint name='1' type='fixed'><parent link='a'/><child link='c'/></joint>\n"
       "<joint name='2' type='fixed'><parent link='b'/><child link='c'/></joint></robot>",
       "f.urdf:3: error: link 'c' has two parents, by the joints '1' and '2'"},
      {"two root links", robot(""), "f.urdf:3: error: two root links, 'a' and 'b'"},
      {"unknown link",
       robot("<joint name='j' type='fixed'><parent link='a'/><child link='x'/></joint>"),
       "f.urdf:4: error: joint 'j' names the unknown link 'x'"},
      {"duplicate link", robot(std::string("<link name='b'/>") + kJoint),
       "f.urdf:4: error: a second link named 'b'"},
      {"duplicate joint", robot(std::string(kJoint) + "\n" + kJoint),
       "f.urdf:5: error: a second joint named 'j'"},
      {"empty name", robot("<link name=''/>"), "f.urdf:4: error: attribute 'name'"},
      {"blank in name", robot("<link name='x y'/>"), "is not a name"},
      {"no child", robot("<joint name='j' type='fixed'><parent link='a'/></joint>"),
       "joint 'j' has no <child>"},
      {"unknown type", robot(joint("", "hinge")), "f.urdf:4: error: unknown joint type 'hinge'"},
      {"zero axis", robot(joint("<axis xyz='0 0 0'/>" + limit)),
       "f.urdf:5: error: the axis of joint 'j' has no direction"},
      {"axis of two", robot(joint("<axis xyz='0 1'/>" + limit)), "expected 3 numbers, got 2"},
      {"axis of four", robot(joint("<axis xyz='0 1 0 0'/>" + limit)), "expected 3 numbers, got 4"},
      {"nan axis", robot(joint("<axis xyz='0 nan 0'/>" + limit)), "not a finite number"},
      {"no limit", robot(joint("<axis xyz='0 0 1'/>")), "joint 'j' needs a <limit>"},
      {"lower > upper", robot(joint("<limit lower='1' upper='-1' velocity='1'/>")),
       "f.urdf:5: error: joint 'j' has lower 1 above upper -1"},
      {"huge limit", robot(joint("<limit lower='-1e308' upper='1e308' velocity='1'/>")),
       "limit beyond"},
      {"nan limit", robot(joint("<limit lower='nan' upper='1' velocity='1'/>")),
       "not a finite number"},
      {"no velocity", robot(joint("<limit lower='0' upper='1'/>")), "attribute 'velocity'"},
      {"negative velocity", robot(joint("<limit lower='0' upper='1' velocity='-1'/>")),
       "negative velocity"},
      {"decimal comma", robot(joint("<limit lower='0,5' upper='1' velocity='1'/>")),
       "decimal comma"},
      {"origin of two", robot(joint("<origin xyz='0 1'/>" + limit)), "expected 3 numbers"},
      {"inf origin", robot(joint("<origin xyz='0 1 inf'/>" + limit)), "not a finite number"},
      {"mimic unknown", robot(joint("<mimic joint='k'/>" + limit)),
       "joint 'j' mimics the unknown joint 'k'"},
      {"mimic self", robot(joint("<mimic joint='j'/>" + limit)), "joint 'j' mimics itself"},
      {"mimic nan", robot(joint("<mimic joint='j' multiplier='nan'/>" + limit)),
       "not a finite number"},
      {"xacro element", robot("<xacro:include filename='x'/>"), "run xacro first"},
      {"xacro value", robot(joint("<origin xyz='0 0 ${h}'/>" + limit)), "run xacro first"},
  };
  for (const BadUrdf& c : cases) {
    EXPECT_NE(messagesOf(c.text).find(c.message), std::string::npos)
        << c.what << ": " << messagesOf(c.text);
  }
}

TEST(Urdf, ReportsAllDefectsOfOneFile) {
  Diagnostics diagnostics;
  readUrdfText("f", robot("<link name=''/><link name='x y'/>" + joint("<axis xyz='0 0 1'/>")),
               diagnostics);
  EXPECT_EQ(diagnostics.errorCount(), 3U);
}

TEST(Urdf, MimicCircleEnds) {
  const std::string limit = "<limit lower='-1' upper='1' velocity='1'/>";
  const std::string text =
      "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>"
      "<joint name='1' type='revolute'><parent link='a'/><child link='b'/>" +
      limit +
      "<mimic joint='2'/></joint><joint name='2' type='revolute'><parent link='b'/>"
      "<child link='c'/>" +
      limit + "<mimic joint='1'/></joint></robot>";
  EXPECT_NE(messagesOf(text).find("mimics itself by way of others"), std::string::npos);
}

TEST(Urdf, EveryTruncationIsAnError) {
  const std::string text = robot(kJoint);
  ASSERT_EQ(messagesOf(text), "");
  for (std::size_t n = 0; n + 2 < text.size(); ++n) {
    EXPECT_NE(messagesOf(text.substr(0, n)), "") << n;
  }
}

TEST(Urdf, WarnsButGoesOn) {
  Diagnostics diagnostics;
  const UrdfModel model = readUrdfText(
      "f", robot(joint("<axis xyz='0 0 2'/><limit lower='0' upper='1' velocity='0'/>") + "<foo/>"),
      diagnostics);
  EXPECT_EQ(diagnostics.errorCount(), 0U);
  EXPECT_EQ(diagnostics.warningCount(), 2U);
  EXPECT_NE(diagnostics.text().find("the first is <foo>"), std::string::npos);
  EXPECT_TRUE(model.joints.at(0).axis.isApprox(Eigen::Vector3d::UnitZ()));
}

TEST(Urdf, KeepsCollisionSolidsAndSkipsMeshes) {
  Diagnostics diagnostics;
  const UrdfModel model = readUrdfText(
      "f",
      "<robot name='r'><link name='a'>"
      "<collision><origin xyz='1 2 3'/><geometry><box size='1 2 3'/></geometry></collision>"
      "<collision><geometry><cylinder radius='.1' length='2'/></geometry></collision>"
      "<collision><geometry><sphere radius='.5'/></geometry></collision>"
      "<collision><geometry><mesh filename='file:///etc/passwd'/></geometry></collision>"
      "</link></robot>",
      diagnostics);
  ASSERT_EQ(diagnostics.text(), "");
  ASSERT_EQ(model.links.at(0).collision.size(), 3U);
  EXPECT_EQ(model.links[0].collision[0].size, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(model.links[0].collision[0].link_T_solid.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(model.links[0].collision[1].size, Eigen::Vector3d(0.1, 2, 0));
}

TEST(Urdf, LongChainIsReadWithoutRecursion) {
  std::string text = "<robot name='r'><link name='l0'/>";
  constexpr int kCount = 5000;
  for (int i = 1; i <= kCount; ++i) {
    const std::string n = std::to_string(i);
    text += "<link name='l" + n + "'/><joint name='j" + n + "' type='fixed'><parent link='l" +
            std::to_string(i - 1) + "'/><child link='l" + n + "'/></joint>";
  }
  EXPECT_EQ(messagesOf(text + "</robot>"), "");
}

std::string chainMessage(const std::string& text, const std::string& base, const std::string& tip) {
  Diagnostics diagnostics;
  const UrdfModel model = readUrdfText("f.urdf", text, diagnostics);
  EXPECT_EQ(diagnostics.errorCount(), 0U) << diagnostics.text();
  try {
    Chain(model, base, tip);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    return error.formatted();
  }
  return "";
}

TEST(Chain, RefusesWhatItCannotFollow) {
  const std::string limit = "<limit lower='-1' upper='1' velocity='1'/>";
  const std::string good = robot(kJoint);
  EXPECT_EQ(chainMessage(good, "a", "b"), "");
  EXPECT_NE(chainMessage(good, "a", "x").find("no link 'x'"), std::string::npos);
  EXPECT_NE(chainMessage(good, "b", "a").find("no chain of joints"), std::string::npos);
  EXPECT_NE(chainMessage(good, "a", "a").find("no moving joint"), std::string::npos);
  EXPECT_NE(chainMessage(robot(joint("", "floating")), "a", "b").find("f.urdf:4: error: joint 'j'"),
            std::string::npos);
  const std::string mimic =
      "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>\n"
      "<joint name='1' type='revolute'><parent link='a'/><child link='b'/>" +
      limit +
      "</joint>\n"
      "<joint name='2' type='revolute'><parent link='b'/><child link='c'/>" +
      limit + "<mimic joint='1'/></joint></robot>";
  EXPECT_NE(chainMessage(mimic, "a", "c").find("f.urdf:3: error: joint '2' mimics '1'"),
            std::string::npos);
}

TEST(Urdf, ReadsTheSharedRobots) {
  for (const char* file :
       {"robots/pr2/pr2_moveit_resources.urdf", "robots/tiago/tiago_no_hand.urdf"}) {
    GRAFT_REQUIRE_DATA(file);
    Diagnostics diagnostics;
    const UrdfModel model = readUrdf(::graft::testing::dataPath(file), diagnostics);
    EXPECT_EQ(diagnostics.errorCount(), 0U) << diagnostics.text();
    // A tree: every link but the root has one joint above it.
    EXPECT_EQ(model.links.size(), model.joints.size() + 1);
    EXPECT_EQ(model.jointAbove("base_footprint"), -1);
  }
}

}  // namespace
}  // namespace graft::lfd
