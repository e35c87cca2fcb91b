#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace twin::report {

/// Numbers in columns.
struct Table {
  std::string columns{};                    ///< head of its CSV: "name [unit],..."
  std::vector<std::vector<double>> rows{};  ///< a value for each column; not finite: there is none
};

/// What a plot shows; src/report/templates has how, as a gnuplot file.
struct Figure {
  std::string id{};       ///< letters, digits and '_'
  std::string plot{};     ///< its file, where several figures share one; else id
  std::string columns{};  ///< of its table, `$data` in the file: as Table
  std::vector<std::vector<double>> rows{};
  std::map<std::string, Table> tables{};   ///< further ones, under their names
  std::map<std::string, double> values{};  ///< further numbers, under their names
  std::vector<std::string> names{};        ///< texts: names[1], names[2], ...
};

/// The table as CSV: its columns, then a line for each row. What is not finite is left empty.
[[nodiscard]] std::string Csv(const Figure& figure);

/// Draws a figure with gnuplot, after style.gp, which says what the file can use. Lines keep, in
/// each column of pixels, their first, lowest, highest and last point, so that a picture of any
/// number of points stays small and no peak is lost. The same figure gives the same bytes, with the
/// same version of gnuplot.
///
/// Threads: any thread. Real-time: no; runs gnuplot from PATH and waits for it.
/// @param prefix  of the file in src/report/templates, which goes on with the figure's name and
/// ".gp": "experiment/noise_". @pre there is such a file; each row has a value for each column.
/// @returns an SVG document. @throws EnvironmentError when gnuplot is missing or fails.
[[nodiscard]] std::string DrawPlot(std::string_view prefix, const Figure& figure);

}  // namespace twin::report
