#include "twin/report/plot.h"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/templates.h"
#include "twin/core/error.h"

namespace twin::report::report_plot_test {
namespace {

using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// For golden/joints.gp, which takes a table and a value.
Figure Sines(std::size_t points) {
  Figure figure{.id = "joints", .columns = "t [s]"};
  figure.values["span"] = 1e-3 * static_cast<double>(points);
  for (int j = 1; j <= 7; ++j) {
    figure.columns += fmt::format(",q {0} [rad],q_d {0} [rad]", j);
  }
  for (std::size_t i = 0; i < points; ++i) {
    const double t = 1e-3 * static_cast<double>(i + 1);
    std::vector<double>& row = figure.rows.emplace_back(1, t);
    for (int j = 0; j < 7; ++j) {
      row.push_back(std::sin(10 * t + j));
      row.push_back(std::sin(10 * t + j + 0.1));
    }
  }
  return figure;
}

/// For application/histograms.gp, which takes names.
Figure Histogram(std::string name) {
  return {.id = "histograms",
          .columns = "panel,centre,width,runs",
          .rows = {{1, 0.5, 1, 3}, {1, 1.5, 1, 4}},
          .names = {std::move(name), "[mm]"}};
}

/// The points of the first curve of a colour: x and y in pixels.
std::vector<std::pair<double, double>> PointsOf(const std::string& svg, const std::string& colour) {
  std::vector<std::pair<double, double>> points;
  std::size_t at = svg.find("stroke='" + colour + "'");
  const std::size_t end = svg.find("'/>", at);
  while ((at = svg.find_first_of("ML", at + 1)) < end) {
    char* rest = nullptr;
    const double x = std::strtod(svg.c_str() + at + 1, &rest);
    if (*rest == ',') points.emplace_back(x, std::strtod(rest + 1, nullptr));
  }
  return points;
}

TEST(DrawPlotTest, TheSameFigureGivesTheSameBytes) {
  const std::string svg = DrawPlot("golden/", Sines(40));
  EXPECT_THAT(svg, HasSubstr("</svg>"));
  EXPECT_EQ(svg, DrawPlot("golden/", Sines(40)));
}

TEST(DrawPlotTest, NamesAreTextAndNothingElse) {
  const std::string svg = DrawPlot("application/", Histogram("$`x` & co. <'a'> @line {1}"));
  EXPECT_THAT(svg, HasSubstr("$`x` &amp; co. &lt;'a'> @line {1}"));
}

TEST(DrawPlotTest, ColoursAreThoseOfTheStyle) {
  EXPECT_THAT(DrawPlot("golden/", Sines(5)), HasSubstr("rgb(192,  39,  45)"));
}

TEST(DrawPlotTest, SizeIsThatOfTheFile) {
  EXPECT_THAT(DrawPlot("golden/", Sines(5)), HasSubstr("width=\"900\" height=\"300\""));
}

TEST(DrawPlotTest, OfManyPointsItDrawsSomeAndKeepsThePeaks) {
  Figure figure = Sines(20'000);
  figure.rows[6'283][1] = 7;
  figure.rows[10'001][1] = -7;
  const std::string svg = DrawPlot("golden/", figure);
  EXPECT_LT(svg.size(), 1'200'000U);
  const auto points = PointsOf(svg, "rgb( 11,  60, 111)");
  EXPECT_LT(points.size(), 9'000U);
  const auto [high, low] = std::ranges::minmax(points, {}, [](const auto& p) { return p.second; });
  // On the axis of 900 pixels the plot begins at 77 and ends at 882: 11 and 3 characters' margins.
  EXPECT_NEAR(high.first, 77 + 0.31415 * 805, 25);
  EXPECT_NEAR(low.first, 77 + 0.50005 * 805, 25);
  EXPECT_GT(low.second - high.second, 150);
}

TEST(DrawPlotTest, OfFewPointsItDrawsAll) {
  // And the two of the key's sample.
  EXPECT_EQ(PointsOf(DrawPlot("golden/", Sines(200)), "rgb( 11,  60, 111)").size(), 202U);
}

TEST(DrawPlotTest, WhatIsNotFiniteBreaksALine) {
  Figure whole = Sines(40);
  Figure broken = whole;
  broken.rows[20][1] = kNan;
  broken.rows[30][1] = 1e200;  // no more than gnuplot can take
  const auto moves = [](const std::string& svg) {
    const std::size_t begin = svg.find("stroke='rgb( 11,  60, 111)'");
    const std::string path = svg.substr(begin, svg.find("'/>", begin) - begin);
    return std::ranges::count(path, 'M');
  };
  EXPECT_EQ(moves(DrawPlot("golden/", broken)), moves(DrawPlot("golden/", whole)) + 2);
}

TEST(DrawPlotTest, FiguresWithoutARowAreDrawn) {
  Figure nothing = Sines(0);
  nothing.values["span"] = 1;
  EXPECT_THAT(DrawPlot("golden/", nothing), HasSubstr("</svg>"));
}

TEST(DrawPlotTest, SaysThatGnuplotIsMissing) {
  const std::string path = ::getenv("PATH");
  ::setenv("PATH", "/nowhere", 1);
  std::string says;
  try {
    says = DrawPlot("golden/", Sines(5));
  } catch (const EnvironmentError& error) {
    says = error.what();
  }
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(says, HasSubstr("install it"));
}

TEST(CsvTest, HasALineForEveryRow) {
  const Figure figure{.columns = "x [s],y [1]", .rows = {{1, 3}, {2, kNan}}};
  EXPECT_EQ(Csv(figure), "x [s],y [1]\n1,3\n2,\n");
}

TEST(TemplatesTest, AreThoseOfTheFolder) {
  EXPECT_THAT(TemplateFiles(), Contains(Field(&TemplateFile::name, "experiment/noise.html")));
  EXPECT_THAT(TemplateText("style.gp"), HasSubstr("set encoding utf8"));
}

// gnuplot knows no short name after an apostrophe in double quotes.
TEST(TemplatesTest, PlotsHaveNoApostropheBeforeAShortName) {
  for (const TemplateFile& file : TemplateFiles()) {
    if (!file.name.ends_with(".gp") || file.name == "style.gp") continue;
    EXPECT_THAT(std::string(file.text),
                Not(::testing::ContainsRegex("\"[^\"\n]*[a-z]'[a-z ][^\"\n]*\"[^\n]*@")))
        << file.name;
  }
}

}  // namespace
}  // namespace twin::report::report_plot_test
