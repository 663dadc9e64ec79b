#include "core/plot/charts.h"

#include <gtest/gtest.h>

#include <cmath>

namespace axiscal::plot {
namespace {

TEST(Charts, TicksAreRoundAndInside) {
  EXPECT_EQ(Ticks(-10.0, 10.0, 4), (std::vector<double>{-10, -5, 0, 5, 10}));
  EXPECT_EQ(Ticks(0.0, 1.0, 5).size(), 6u);
  EXPECT_TRUE(Ticks(1.0, 1.0, 5).empty());
  for (const double tick : Ticks(0.013, 0.047, 6)) {
    EXPECT_GE(tick, 0.013);
    EXPECT_LE(tick, 0.047 + 1e-12);
  }
}

TEST(Charts, DecimationKeepsThePeakOfEveryColumn) {
  std::vector<Pixel> points;
  for (int i = 0; i < 20000; ++i) points.push_back({100.0 + 0.01 * i, i == 12345 ? 7.0 : 50.0 + std::sin(i)});
  const std::vector<Pixel> kept = Decimated(points, 5000, 100.0, 300.0);
  EXPECT_LE(kept.size(), 402u);
  double highest = 1e9;
  for (const Pixel& point : kept) highest = std::min(highest, point.y);
  EXPECT_EQ(highest, 7.0);
  EXPECT_EQ(Decimated({{1, 2}, {1, 3}, {1, 2.5}}, 5000, 0, 10).size(), 3u);
}

TEST(Charts, APictureStaysSmallAndLeavesOutWhatIsNoNumber) {
  Series series = {"many", {}};
  for (int i = 0; i < 100000; ++i) series.points.push_back({i * 0.1, std::sin(0.001 * i)});
  series.points.push_back({NAN, 1.0});
  series.points.push_back({1.0, INFINITY});
  const std::string svg = ScatterChart("t", "x", "y", {{"before", {series}}, {"after", {{"none", {}}}}});
  EXPECT_LT(svg.size(), 100000u);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(Charts, APanelThatWouldBeFlatGetsItsOwnScaleAndSaysSo) {
  const Series big = {"s", {{0, 10.0}, {1, -10.0}}}, small = {"s", {{0, 1.0}, {1, -1.0}}}, half = {"s", {{0, 5.0}}};
  EXPECT_NE(
      ScatterChart("t", "x", "y", {{"before", {big}}, {"after", {small}}}).find("after (drawn 10.0 times larger)"),
      std::string::npos);
  EXPECT_EQ(ScatterChart("t", "x", "y", {{"before", {big}}, {"after", {half}}}).find("drawn"), std::string::npos);
}

TEST(Charts, NamesAreEscaped) {
  EXPECT_EQ(Escape("a<b>&\"\x01"), "a&lt;b&gt;&amp;&quot; ");
  EXPECT_EQ(BarChart("<t>", "x", {{"A&B", 3.0}}, 1.0, "limit").find("A&B"), std::string::npos);
}

}  // namespace
}  // namespace axiscal::plot
