#include "core/plot/charts.h"

#include <gtest/gtest.h>

#include <algorithm>
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
  const std::string german =
      ScatterChart("t", "x", "y", {{"a", {big}}, {"b", {small}}}, Ground::kMiddle, base::Language::kGerman);
  EXPECT_NE(german.find("b (10,0-mal größer gezeichnet)"), std::string::npos);
  EXPECT_EQ(german.find("drawn"), std::string::npos);
}

TEST(Charts, WhatAPictureShowsIsATableToo) {
  EXPECT_EQ(
      Csv("X, mm", "um", {{"before", {{"a \"b\"", {{1.5, -2.0}, {NAN, 1.0}}}}}, {"after", {{"c", {{1e-7, 3.0}}}}}}),
      "panel,series,\"X, mm\",um\r\nbefore,\"a \"\"b\"\"\",1.5,-2\r\nafter,c,1e-07,3\r\n");
}

TEST(Charts, AThinnedSeriesKeepsItsPeaks) {
  std::vector<Point> points;
  for (int i = 0; i < 20000; ++i) points.push_back({0.1 * i, i == 777 ? 9.0 : std::sin(i)});
  const std::vector<Point> kept = Thinned(points);
  EXPECT_LT(kept.size(), 2000u);
  const auto is_peak = [](const Point& point) { return point.y == 9.0 && std::abs(point.x - 77.7) < 1e-9; };
  EXPECT_EQ(std::count_if(kept.begin(), kept.end(), is_peak), 1);
  EXPECT_EQ(Thinned({{1.0, 2.0}}).size(), 1u);
}

TEST(Charts, FromTheBottomEveryPointStandsOnALine) {
  const Series orders = {"s", {{1, 3.0}, {2, 1.0}}};
  const std::string up = ScatterChart("t", "order", "um", {{"before", {orders}}}, Ground::kBottom);
  const std::string middle = ScatterChart("t", "order", "um", {{"before", {orders}}});
  const auto lines = [](const std::string& svg) {
    size_t count = 0;
    for (size_t at = svg.find("stroke-width=\"1.5\""); at != std::string::npos;
         at = svg.find("stroke-width=\"1.5\"", at + 1))
      ++count;
    return count;
  };
  EXPECT_EQ(lines(up), 2u);
  EXPECT_EQ(lines(middle), 0u);
}

TEST(Charts, NamesAreEscaped) {
  EXPECT_EQ(Escape("a<b>&\"\x01"), "a&lt;b&gt;&amp;&quot; ");
  EXPECT_EQ(BarChart("<t>", "x", {{"A&B", 3.0}}, 1.0, "limit").find("A&B"), std::string::npos);
}

}  // namespace
}  // namespace axiscal::plot
