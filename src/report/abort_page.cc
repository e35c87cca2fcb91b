#include "report/abort_page.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "report/abort_panels.h"
#include "report/loss_facts.h"
#include "twin/report/page.h"
#include "twin/report/plot.h"

namespace twin::report {
namespace {

using nlohmann::json;

std::string NameOf(const RunEnd& end, const EndCycle& cycle) {
  switch (cycle.cycle.fate) {
    case record::CommandFate::kServed: return "served";
    case record::CommandFate::kHeld: {
      const std::string why = end.has_ticks ? WhyHeld(cycle) : "";
      return why.empty() ? "held" : "held: " + why;
    }
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
                    {"command", NameOf(end, end.cycles[i])},
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

std::string AbortPage(const std::vector<ToldAbort>& aborts, const std::string& title,
                      const std::string& rest) {
  json sections = json::array();
  for (const ToldAbort& abort : aborts) {
    const RunEnd& end = *abort.end;
    const std::vector<EndPanel> panels = EndPanels(end);
    const std::string name = fmt::format("end{}", sections.size() + 1);
    sections.push_back({{"name", name},
                        {"headline", abort.headline},
                        {"paragraphs", ParagraphsOf(abort.paragraphs)},
                        {"cycles", std::min(end.cycles.size(), RunEnd::kShown)},
                        {"figure", InlineSvg(DrawPlot("run/", EndFigure(end, panels)), name)},
                        {"curves", CurvesOf(panels)},
                        {"rows", RowsOf(end, panels)},
                        {"limited", end.approach.has_limits()},
                        {"approaches", ApproachesOf(end)}});
  }
  const record::RunInfo& run = aborts.front().end->run;
  return RenderPage("abort", {{"title", title},
                              {"scenario", run.scenario},
                              {"seed", run.seed},
                              {"drive", run.drive},
                              {"version", run.version},
                              {"several", aborts.size() > 1},
                              {"rest", rest},
                              {"aborts", std::move(sections)}});
}

}  // namespace twin::report
