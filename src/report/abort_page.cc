#include "report/abort_page.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "report/abort_panels.h"
#include "twin/report/page.h"
#include "twin/report/plot.h"

namespace twin::report {
namespace {

using nlohmann::json;

std::string_view NameOf(const RunEnd& end, record::CommandFate fate) {
  switch (fate) {
    case record::CommandFate::kServed: return "served";
    case record::CommandFate::kHeld: return "held";
    case record::CommandFate::kNone: break;
  }
  return end.fates_unknown() ? "not known" : "none due";
}

json ParagraphsOf(const std::vector<Paragraph>& paragraphs) {
  json list = json::array();
  for (const Paragraph& paragraph : paragraphs) {
    if (paragraph.lines.empty()) continue;
    list.push_back({{"label", paragraph.label}, {"lines", paragraph.lines}});
  }
  return list;
}

/// The figure's data in numbers: one row per cycle.
json RowsOf(const RunEnd& end, const std::vector<EndPanel>& panels) {
  json rows = json::array();
  for (std::size_t i = 0; i < end.cycles.size(); ++i) {
    const record::CycleRecord& cycle = end.cycles[i].cycle;
    json values = json::array();
    for (const EndPanel& panel : panels) {
      for (const EndCurve& curve : panel.curves) {
        const double value = curve.values[i];
        values.push_back(std::isfinite(value) ? fmt::format("{:.7g}", value) : std::string());
      }
    }
    rows.push_back({{"held", cycle.fate == record::CommandFate::kHeld},
                    {"state", cycle.state.message_id},
                    {"command", NameOf(end, cycle.fate)},
                    {"values", std::move(values)}});
  }
  return rows;
}

json CurvesOf(const std::vector<EndPanel>& panels) {
  json curves = json::array();
  for (const EndPanel& panel : panels) {
    for (const EndCurve& curve : panel.curves) {
      curves.push_back({{"name", curve.name}, {"unit", panel.unit}});
    }
  }
  return curves;
}

json ApproachesOf(const RunEnd& end) {
  json list = json::array();
  for (const Approach& approach : end.approach.Closest()) {
    list.push_back({{"quantity", approach.what},
                    {"percent", fmt::format("{:.1f}", 100 * approach.share)},
                    {"place", PlaceOf(approach)}});
  }
  return list;
}

}  // namespace

std::string PlaceOf(const Approach& approach) {
  const bool is_position = approach.unit == "rad";
  return fmt::format("{:.5g} {} {:.5g} {}{}, at {:.3f} s", approach.value,
                     is_position ? "rad, limit" : "of", approach.limit, approach.unit,
                     approach.axis < 0 ? "" : fmt::format(", joint {}", approach.axis + 1),
                     approach.time);
}

std::string AbortPage(const RunEnd& end, std::string_view headline,
                      const std::vector<Paragraph>& paragraphs) {
  const std::vector<EndPanel> panels = EndPanels(end);
  return RenderPage("abort",
                    {{"title", headline},
                     {"scenario", end.run.scenario},
                     {"seed", end.run.seed},
                     {"drive", end.run.drive},
                     {"version", end.run.version},
                     {"paragraphs", ParagraphsOf(paragraphs)},
                     {"cycles", std::min(end.cycles.size(), RunEnd::kShown)},
                     {"figure", InlineSvg(DrawPlot("run/", EndFigure(end, panels)), "end")},
                     {"curves", CurvesOf(panels)},
                     {"rows", RowsOf(end, panels)},
                     {"limited", end.approach.has_limits()},
                     {"approaches", ApproachesOf(end)}});
}

}  // namespace twin::report
