#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace twin::report {

/// Numbers in columns.
struct Table {
  std::string columns{};                    ///< header of the CSV: "name [unit],..."
  std::vector<std::vector<double>> rows{};  ///< one value per column; not finite: no value
};

/// Data of a plot; a gnuplot file in src/report/templates draws it.
struct Figure {
  std::string id{};       ///< letters, digits and '_'
  std::string plot{};     ///< name of its gnuplot file, if several figures share one; empty: id
  std::string columns{};  ///< header of its table, `$data` in the gnuplot file; as in Table
  std::vector<std::vector<double>> rows{};
  std::map<std::string, Table> tables{};   ///< further tables, by name
  std::map<std::string, double> values{};  ///< further numbers, by name
  std::vector<std::string> names{};        ///< texts: names[1], names[2], ...
};

/// The table as CSV: header, then one line per row. Values that are not finite are left empty.
[[nodiscard]] std::string Csv(const Figure& figure);

/// Draws a figure with gnuplot. Runs style.gp, which documents the available variables, then the
/// figure's file. In each column of pixels, a line keeps its first, lowest, highest and last point:
/// the picture stays small for any number of points, and no peak is lost. The same figure gives the
/// same bytes, with the same version of gnuplot.
///
/// Threads: any. Not real-time: runs gnuplot from PATH and waits.
/// @param prefix  start of the file's path in src/report/templates, as "experiment/noise_"; the
/// figure's name and ".gp" follow. @pre the file exists; each row has a value for each column.
/// @returns an SVG document. @throws EnvironmentError if gnuplot is missing or fails.
[[nodiscard]] std::string DrawPlot(std::string_view prefix, const Figure& figure);

}  // namespace twin::report
