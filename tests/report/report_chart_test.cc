#include "twin/report/chart.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/chart_data.h"
#include "twin/core/error.h"

namespace twin::report {
namespace {

using ::testing::DoubleEq;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

ChartCurve Sine(std::size_t points, ChartCurve::Style style = ChartCurve::Style::kLine) {
  ChartCurve curve{.name = "sine & co. <'a'>", .style = style};
  for (std::size_t i = 0; i < points; ++i) {
    curve.x.push_back(1e-3 * static_cast<double>(i + 1));
    curve.y.push_back(std::sin(10 * curve.x.back()));
  }
  return curve;
}

/// A chart of everything there is.
Chart Everything() {
  Chart chart{.title = "all of it", .columns = 2};
  using Style = ChartCurve::Style;
  for (const Style style :
       {Style::kLine, Style::kDashed, Style::kSteps, Style::kPoints, Style::kBars}) {
    for (const bool log : {false, true}) {
      chart.panels.push_back({.title = "panel",
                              .x_label = "t [s]",
                              .y_label = "y [1]",
                              .log_x = log,
                              .log_y = log,
                              .curves = {Sine(40, style), Sine(7, style)}});
    }
  }
  const std::vector<double> centres{1, 10, 100};
  HeatMap map{.x = centres, .y = {1, 2}, .z = {0, 0.5, 1, 0.2, kNan, 0.3}, .z_label = "z"};
  chart.panels.push_back({.title = "map", .log_x = true, .map = map});
  chart.panels.push_back({.title = "empty"});
  return chart;
}

TEST(DrawChartTest, TheSameChartGivesTheSameBytes) {
  const std::string svg = DrawChart(Everything());
  EXPECT_THAT(svg, HasSubstr("</svg>"));
  EXPECT_EQ(svg, DrawChart(Everything()));
}

TEST(DrawChartTest, NamesAreTextAndNothingElse) {
  const std::string svg = DrawChart({.title = "$`x` <b>", .panels = {{.curves = {Sine(5)}}}});
  EXPECT_THAT(svg, HasSubstr("$`x` &lt;b>"));
  EXPECT_THAT(svg, HasSubstr("sine &amp; co. &lt;'a'>"));
}

TEST(DrawChartTest, ColoursAreThoseOfTheCurves) {
  ChartCurve curve = Sine(5);
  curve.colour = colour::kSynchronous;
  EXPECT_THAT(DrawChart({.panels = {{.curves = {curve}}}}), HasSubstr("rgb(192,  39,  45)"));
}

TEST(DrawChartTest, SizeIsThatOfItsPanels) {
  const Chart chart{.columns = 2, .width = 700, .panel_height = 200, .panels = {3, ChartPanel()}};
  EXPECT_THAT(DrawChart(chart), HasSubstr("width=\"700\" height=\"400\""));
}

TEST(DrawChartTest, OfAMillionPointsItDrawsSome) {
  EXPECT_LT(DrawChart({.panels = {{.curves = {Sine(1'000'000)}}}}).size(), 200'000U);
}

TEST(DrawChartTest, ChartsWithoutAnythingToDrawAreDrawn) {
  const ChartCurve nothing{.name = "nothing", .x = {1, 2}, .y = {kNan, kNan}};
  const ChartCurve constant{.name = "constant", .x = {1, 1}, .y = {3, 3}};
  const ChartCurve negative{.name = "negative", .x = {-1, 0}, .y = {-1, 0}};
  for (const bool log : {false, true}) {
    const Chart chart{.panels = {{.log_x = log, .log_y = log, .curves = {nothing}},
                                 {.log_x = log, .log_y = log, .curves = {constant}},
                                 {.log_x = log, .log_y = log, .curves = {negative}},
                                 {.log_x = log, .map = HeatMap{{1}, {1}, {kNan}, "z"}}}};
    EXPECT_THAT(DrawChart(chart), HasSubstr("</svg>"));
  }
}

TEST(DrawChartTest, SaysThatGnuplotIsMissing) {
  const std::string path = ::getenv("PATH");
  ::setenv("PATH", "/nowhere", 1);
  std::string says;
  try {
    says = DrawChart(Everything());
  } catch (const EnvironmentError& error) {
    says = error.what();
  }
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(says, HasSubstr("install it"));
}

TEST(CellEdgesTest, AreMidwayBetweenCentres) {
  EXPECT_THAT(CellEdges({1, 3, 4}, false), ElementsAre(0, 2, 3.5, 4.5));
  EXPECT_THAT(
      CellEdges({1, 100, 10'000}, true),
      ElementsAre(DoubleNear(0.1, 1e-12), DoubleEq(10), DoubleEq(1000), DoubleNear(1e5, 1e-6)));
}

TEST(CellEdgesTest, OneCentreHasACellToo) {
  EXPECT_THAT(CellEdges({2}, false), ElementsAre(1.5, 2.5));
  EXPECT_THAT(CellEdges({2}, true), ElementsAre(1, 4));
  EXPECT_THAT(CellEdges({}, false), IsEmpty());
}

TEST(PointsToDrawTest, AreAllOfAShortCurve) {
  EXPECT_THAT(PointsToDraw(Sine(4000), {.x_range = {0, 4}}), SizeIs(4000));
}

TEST(PointsToDrawTest, OfALongCurveKeepTheExtremes) {
  ChartCurve curve = Sine(100'000);
  curve.y[31'415] = 7;
  curve.y[50'001] = -7;
  const auto points = PointsToDraw(curve, {.x_range = {0, 100}});
  EXPECT_LE(points.size(), 4002U);
  EXPECT_TRUE(std::ranges::any_of(
      points, [&](const Point& p) { return p.y == 7 && p.x == curve.x[31'415]; }));
  EXPECT_TRUE(std::ranges::any_of(points, [](const Point& p) { return p.y == -7; }));
  EXPECT_TRUE(std::ranges::is_sorted(points, {}, &Point::x));
}

TEST(PointsToDrawTest, OnALogarithmicAxisTheFirstDecadeIsNotMerged) {
  // Of 10,000 points from 1 to 10,000 those from 1 to 10 have a place each.
  ChartCurve curve;
  for (int i = 1; i <= 10'000; ++i) {
    curve.x.push_back(i);
    curve.y.push_back(i % 2);
  }
  const auto points = PointsToDraw(curve, {.log_x = true, .x_range = {1, 10'000}});
  ASSERT_LT(points.size(), 5000U);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(points[i].x, static_cast<double>(i + 1));
}

TEST(PointsToDrawTest, WhatIsNotFiniteBreaksALine) {
  const ChartCurve curve{.x = {1, 2, 3, 4, 5}, .y = {1, kNan, kNan, 4, -5}};
  const auto points = PointsToDraw(curve, {.x_range = {1, 5}});
  ASSERT_THAT(points, SizeIs(4));
  EXPECT_TRUE(points[1].is_gap);
  EXPECT_EQ(points[3].y, -5);
}

TEST(PointsToDrawTest, SoDoesWhatALogarithmicAxisDoesNotHave) {
  const ChartCurve curve{.x = {1, 2, 3}, .y = {1, 0, 4}};
  const auto points = PointsToDraw(curve, {.log_y = true, .x_range = {1, 3}});
  ASSERT_THAT(points, SizeIs(3));
  EXPECT_TRUE(points[1].is_gap);
}

}  // namespace
}  // namespace twin::report
