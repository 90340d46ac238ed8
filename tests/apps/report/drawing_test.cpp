// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <tinyxml2.h>

#include <clocale>
#include <cmath>
#include <limits>
#include <random>

#include "apps/report/axes.hpp"
#include "apps/report/svg.hpp"
#include "tests/apps/report/written_report.hpp"

namespace graft::report {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Escape, ReadsBackAsWritten) {
  for (const std::string text :
       {"a<b>&\"c'", "plain", "Schubladengriff \u00F6\u00E4\u00FC \u4E2D \U0001F600", "]]>",
        "&amp;", ""}) {
    const std::string xml = "<t a=\"" + escapeXml(text) + "\">" + escapeXml(text) + "</t>";
    tinyxml2::XMLDocument document;
    ASSERT_EQ(document.Parse(xml.c_str()), tinyxml2::XML_SUCCESS) << xml;
    EXPECT_EQ(document.RootElement()->Attribute("a"), text);
    const char* content = document.RootElement()->GetText();
    EXPECT_EQ(content != nullptr ? content : "", text);
  }
}

TEST(Escape, ReplacesWhatXmlCannotHold) {
  const std::string mark = "\xEF\xBF\xBD";
  EXPECT_EQ(escapeXml(std::string("a\x01\x1B\0b", 5)), "a" + mark + mark + mark + "b");
  EXPECT_EQ(escapeXml("\xFF\xC3"), mark + mark);
  EXPECT_EQ(escapeXml("\xC0\xAF"), mark + mark);             // overlong
  EXPECT_EQ(escapeXml("\xED\xA0\x80"), mark + mark + mark);  // surrogate
  EXPECT_EQ(escapeXml("\xF4\x90\x80\x80"), mark + mark + mark + mark);
  EXPECT_EQ(escapeXml("\xE2\x82"), mark + mark);  // cut off
}

TEST(Numbers, AreShortAndNeverStrange) {
  EXPECT_EQ(shortNumber(1.50), "1.5");
  EXPECT_EQ(shortNumber(100), "100");
  EXPECT_EQ(shortNumber(-0.0001), "0");
  EXPECT_EQ(shortNumber(0.005, 3), "0.005");
  EXPECT_EQ(fixedNumber(-0.0001, 2), "0.00");
  EXPECT_EQ(fixedNumber(2, 2), "2.00");
  EXPECT_EQ(fixedNumber(kNan, 2), "-");
  EXPECT_EQ(shortNumber(kInfinity), "-");
  EXPECT_EQ(groupedNumber(0), "0");
  EXPECT_EQ(groupedNumber(999), "999");
  EXPECT_EQ(groupedNumber(1000), "1,000");
  EXPECT_EQ(groupedNumber(1234567), "1,234,567");
}

TEST(Numbers, RoughOnesKeepThreeDigits) {
  EXPECT_EQ(roughNumber(13043470.7), "13,043,471");
  EXPECT_EQ(roughNumber(-1234.4), "-1,234");
  EXPECT_EQ(roughNumber(84.259), "84.3");
  EXPECT_EQ(roughNumber(3.908), "3.91");
  EXPECT_EQ(roughNumber(0), "0");
  EXPECT_EQ(roughNumber(0.0312), "0.0312");
  EXPECT_EQ(roughNumber(4.13e-7), "4.13e-7");
  EXPECT_EQ(roughNumber(2.5e12), "2.5e12");
  EXPECT_EQ(roughNumber(kNan), "-");
}

TEST(Paths, LeaveOutWhatIsNotFinite) {
  PathData path;
  path.polyline({{0, 0}, {1, 1}, {kNan, 2}, {3, 3}, {4, 4}, {5, kInfinity}});
  EXPECT_EQ(path.text(), "M0 0L1 1M3 3L4 4");
  PathData nothing;
  nothing.dot({kNan, 0});
  nothing.cross({0, kInfinity}, 2);
  nothing.polyline({});
  nothing.close();
  nothing.curveTo({0, 0}, {kNan, 0});
  EXPECT_TRUE(nothing.empty()) << nothing.text();
  PathData dot;
  dot.dot({1, 2});
  EXPECT_EQ(dot.text(), "M1 2h0");
}

TEST(Pictures, SkipShapesThatAreNotFinite) {
  Svg svg(10, 10);
  svg.circle({kNan, 0}, 1, "w1");
  svg.rect({0, 0}, kNan, 1, "w1");
  svg.rect({0, 0}, -1, 1, "w1");
  svg.text({0, kInfinity}, "x", "small");
  svg.line({kNan, 0}, {1, 1}, "w1");
  EXPECT_EQ(testing::defectOf(svg.standalone("t")), "");
  EXPECT_EQ(svg.inlined("t").find("<circle"), std::string::npos);
}

TEST(Ticks, AreRoundNumbersWithinTheRange) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> exponent(-6, 6);
  std::uniform_real_distribution<double> middle(-5, 5);
  for (int n = 0; n < 2000; ++n) {
    const double size = std::pow(10.0, exponent(random));
    const double center = middle(random) * size;
    const Range range(center - size / 2, center + size / 2);
    const int wanted = 3 + n % 8;
    const std::vector<double> ticks = niceTicks(range, wanted);
    ASSERT_GE(ticks.size(), 2u);
    // Steps are off the wish by at most a factor of 1.5 (to 2, then 3.5/2, ...).
    EXPECT_LE(double(ticks.size()), 1.75 * wanted + 1);
    EXPECT_GE(double(ticks.size()), wanted / 1.75 - 1);
    EXPECT_GE(ticks.front(), range.low - 1e-6 * size);
    EXPECT_LE(ticks.back(), range.high + 1e-6 * size);
    const double step = ticks[1] - ticks[0];
    const double digit = step / std::pow(10.0, std::floor(std::log10(step) + 1e-9));
    EXPECT_TRUE(std::abs(digit - 1) < 1e-6 || std::abs(digit - 2) < 1e-6 ||
                std::abs(digit - 5) < 1e-6)
        << digit;
    const std::vector<std::string> labels = tickLabels(ticks);
    for (std::size_t i = 1; i < labels.size(); ++i) EXPECT_NE(labels[i], labels[i - 1]);
  }
}

TEST(Ticks, NothingForEmptyRanges) {
  EXPECT_TRUE(niceTicks(Range(), 5).empty());
  EXPECT_TRUE(niceTicks(Range(1, 1), 5).empty());
  EXPECT_TRUE(niceTicks(Range(0, 1), 0).empty());
}

TEST(Ticks, LogarithmicOnesStayInRange) {
  for (const double high : {1.3, 9.0, 120.0, 3e4, 5e9, 2e30}) {
    const Range range(1.02, high);
    const std::vector<double> ticks = logTicks(range);
    EXPECT_GE(ticks.size(), 2u) << high;
    EXPECT_LE(ticks.size(), 12u) << high;
    for (const double tick : ticks) {
      EXPECT_GE(tick, range.low * (1 - 1e-9));
      EXPECT_LE(tick, range.high * (1 + 1e-9));
    }
  }
}

TEST(AxesTest, EqualScaleContainsTheRanges) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> size(0.1, 10);
  for (int n = 0; n < 200; ++n) {
    const Range x(-size(random), size(random));
    const Range y(-size(random), size(random));
    const Axes axes = Axes::equal({10, 20, 100 * size(random), 100 * size(random)}, x, y);
    EXPECT_LE(axes.x().low, x.low + 1e-9);
    EXPECT_GE(axes.x().high, x.high - 1e-9);
    EXPECT_LE(axes.y().low, y.low + 1e-9);
    EXPECT_GE(axes.y().high, y.high - 1e-9);
    const Point origin = axes.at(0, 0);
    const Point right = axes.at(1, 0);
    const Point up = axes.at(0, 1);
    EXPECT_NEAR(right.x - origin.x, origin.y - up.y, 1e-6);
    EXPECT_NEAR(right.y, origin.y, 1e-9);
  }
}

TEST(AxesTest, LogScaleIsEvenInFactors) {
  const Axes axes({0, 0, 100, 100}, {0, 1}, {1, 10000}, true);
  EXPECT_NEAR(axes.at(0, 1).y, 100, 1e-9);
  EXPECT_NEAR(axes.at(0, 100).y, 50, 1e-9);
  EXPECT_NEAR(axes.at(0, 10000).y, 0, 1e-9);
}

TEST(Legend, BreaksLinesAndMeasuresAsItDraws) {
  const std::vector<LegendEntry> entries(6, {Mark::kDot, "s-ink w5", "a long enough text"});
  Svg svg(300, 300);
  const double drawn = drawLegend(&svg, {0, 0}, 300, entries);
  EXPECT_EQ(drawn, drawLegend(nullptr, {0, 0}, 300, entries));
  EXPECT_GT(drawn, drawLegend(nullptr, {0, 0}, 3000, entries));
  EXPECT_EQ(drawLegend(nullptr, {0, 0}, 300, {}), 0);
}

}  // namespace
}  // namespace graft::report
