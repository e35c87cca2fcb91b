#include "twin/report/plot.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>

#include <fmt/format.h>

#include "report/gnuplot.h"
#include "report/script.h"
#include "report/templates.h"
#include "twin/core/error.h"

namespace twin::report {
namespace {

/// Adds a table as the data block `$name`. gnuplot draws NaN as a gap.
void AddTable(std::string& script, std::string_view name, std::string_view columns,
              const std::vector<std::vector<double>>& rows) {
  const auto width = static_cast<std::size_t>(1 + std::ranges::count(columns, ','));
  script += fmt::format("${} << EOD\n{}\n", name, columns);
  for (const std::vector<double>& row : rows) {
    TWIN_CHECK(row.size() == width);
    for (std::size_t i = 0; i < width; ++i) {
      // gnuplot fails on larger numbers.
      const bool can_be_drawn = std::abs(row[i]) < 1e100;
      script += can_be_drawn ? fmt::format("{:.9g}", row[i]) : std::string("NaN");
      script += i + 1 < width ? ',' : '\n';
    }
  }
  if (rows.empty()) {  // gnuplot refuses an empty table
    for (std::size_t i = 0; i < width; ++i) script += i + 1 < width ? "NaN," : "NaN\n";
  }
  script += "EOD\n";
}

std::string ScriptOf(std::string_view prefix, const Figure& figure) {
  std::string script(TemplateText("style.gp"));
  if (!figure.columns.empty()) AddTable(script, "data", figure.columns, figure.rows);
  for (const auto& [key, table] : figure.tables) AddTable(script, key, table.columns, table.rows);
  // gnuplot fails without a point, because it finds no range: such a figure shows empty axes.
  if (figure.rows.empty() && figure.tables.empty()) {
    script += "panel = panel . \"; set xrange [0.1:1]; set yrange [0.1:1]\"\n";
  }
  for (const auto& [key, value] : figure.values) {
    script += std::isfinite(value) ? fmt::format("{} = {:.9g}\n", key, value)
                                   : fmt::format("{} = NaN\n", key);
  }
  if (!figure.names.empty()) {
    script += fmt::format("array names[{}]\n", figure.names.size());
    for (std::size_t i = 0; i < figure.names.size(); ++i) {
      script += fmt::format("names[{}] = {}\n", i + 1, Quote(figure.names[i]));
    }
  }
  const std::string& plot = figure.plot.empty() ? figure.id : figure.plot;
  return script.append(TemplateText(fmt::format("{}{}.gp", prefix, plot)));
}

/// A point of a path, as gnuplot writes it: "L101.50,42.00".
struct PathPoint {
  std::string_view text;
  double x = 0;
  double y = 0;
};

std::optional<PathPoint> PointOf(std::string_view word) {
  PathPoint point{.text = word};
  if (!word.starts_with('L')) return std::nullopt;
  const char* const end = word.data() + word.size();
  const auto x = std::from_chars(word.data() + 1, end, point.x);
  if (x.ec != std::errc() || x.ptr == end || *x.ptr != ',') return std::nullopt;
  const auto y = std::from_chars(x.ptr + 1, end, point.y);
  return y.ec == std::errc() ? std::optional(point) : std::nullopt;
}

/// Thins a line: of its points in the same half of a pixel, keeps first, lowest, highest and last.
class Thinning {
 public:
  explicit Thinning(std::string& out) : out_(out) {}

  void Add(const PathPoint& point) {
    constexpr double kPerPixel = 2;
    const double place = std::floor(kPerPixel * point.x);
    if (place != place_) Flush();
    place_ = place;
    group_.push_back(point);
  }

  void Flush() {
    const auto [low, high] = std::ranges::minmax_element(group_, {}, &PathPoint::y);
    for (auto point = group_.begin(); point != group_.end(); ++point) {
      const bool is_end = point == group_.begin() || point + 1 == group_.end();
      if (is_end || point == low || point == high) (out_ += point->text) += ' ';
    }
    group_.clear();
  }

 private:
  std::string& out_;
  double place_ = 0;
  std::vector<PathPoint> group_;
};

/// A path's commands, with fewer points.
std::string Thinned(std::string_view path) {
  std::string out;
  Thinning thinning(out);
  constexpr std::string_view kSpace = " \n\t";
  for (std::size_t at = path.find_first_not_of(kSpace); at != std::string_view::npos;) {
    const std::size_t end = std::min(path.find_first_of(kSpace, at), path.size());
    const std::string_view word = path.substr(at, end - at);
    if (const auto point = PointOf(word)) {
      thinning.Add(*point);
    } else {
      thinning.Flush();
      (out += word) += ' ';
    }
    at = path.find_first_not_of(kSpace, end);
  }
  thinning.Flush();
  return out;
}

std::string WithThinLines(std::string_view svg) {
  constexpr std::string_view kPath = " d='M";
  std::string out;
  while (true) {
    const std::size_t begin = svg.find(kPath);
    if (begin == std::string_view::npos) return out.append(svg);
    const std::size_t path = begin + kPath.size() - 1;
    const std::size_t end = std::min(svg.find('\'', path), svg.size());
    out.append(svg.substr(0, path)).append(Thinned(svg.substr(path, end - path)));
    svg.remove_prefix(end);
  }
}

}  // namespace

std::string Csv(const Figure& figure) {
  std::string csv = figure.columns + "\n";
  for (const std::vector<double>& row : figure.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i > 0) csv += ',';
      if (std::isfinite(row[i])) csv += fmt::format("{:.9g}", row[i]);
    }
    csv += '\n';
  }
  return csv;
}

std::string DrawPlot(std::string_view prefix, const Figure& figure) {
  return WithThinLines(SvgOf(ScriptOf(prefix, figure)));
}

}  // namespace twin::report
