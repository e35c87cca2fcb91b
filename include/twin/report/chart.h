#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace twin::report {

/// Colours that stay apart for colour-blind readers and in grey; the same thing has the same one in
/// every chart.
namespace colour {
inline constexpr std::string_view kBare = "#0b3c6f";          ///< LF, dark blue
inline constexpr std::string_view kSynchronous = "#c0272d";   ///< RS, red
inline constexpr std::string_view kAsynchronous = "#f0a030";  ///< RA, amber
inline constexpr std::string_view kReference = "#7f7f7f";     ///< what was intended, grey
inline constexpr std::string_view kLimit = "#222222";         ///< limits, near black
/// Of further curves, in their order.
inline constexpr std::array<std::string_view, 6> kSeries{"#0b3c6f", "#f0a030", "#c0272d",
                                                         "#2a8c7a", "#7a2a90", "#9cc3e6"};
}  // namespace colour

/// Points of a chart that belong together.
struct ChartCurve {
  enum class Style : std::uint8_t { kLine, kDashed, kSteps, kPoints, kBars };

  std::string name{};  ///< in the key; empty: not in it
  std::string_view colour = colour::kBare;
  Style style = Style::kLine;
  std::vector<double> x{};
  std::vector<double> y{};  ///< as many; what is not finite is not drawn and breaks a line
};

/// Values on a grid, as colours.
struct HeatMap {
  std::vector<double> x{};  ///< centres of the columns, rising
  std::vector<double> y{};  ///< centres of the rows, rising
  std::vector<double> z{};  ///< z[row * x.size() + column]
  std::string z_label{};
  std::optional<std::array<double, 2>> z_range{};  ///< of the colours; absent: of the values
};

/// One pair of axes.
struct ChartPanel {
  std::string title{};
  std::string x_label{};  ///< with its unit: "t [s]"
  std::string y_label{};
  bool log_x = false;
  bool log_y = false;
  std::optional<std::array<double, 2>> x_range{};
  std::optional<std::array<double, 2>> y_range{};
  std::vector<ChartCurve> curves{};
  std::optional<HeatMap> map{};  ///< under the curves
};

/// A picture of one or more panels.
struct Chart {
  std::string title{};
  int columns = 1;
  int width = 900;         ///< pixels
  int panel_height = 300;  ///< pixels
  std::vector<ChartPanel> panels{};
};

/// Draws with gnuplot. Curves of more than some thousand points are drawn by the lowest and the
/// highest of what falls into the same place. The same chart gives the same bytes, with the same
/// version of gnuplot.
///
/// Threads: any thread. Real-time: no; runs gnuplot from PATH and waits for it.
/// @returns an SVG document. @throws EnvironmentError when gnuplot is missing or fails.
/// @pre every curve has as many x as y, every map a value for each of its places; at least one
/// panel.
[[nodiscard]] std::string DrawChart(const Chart& chart);

}  // namespace twin::report
