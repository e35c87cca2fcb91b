#include "report/abort_page.h"

#include <cmath>

#include <fmt/format.h>

#include "report/abort_figure.h"
#include "report/abort_panels.h"
#include "report/gnuplot.h"
#include "twin/report/html.h"

namespace twin::report {
namespace {

std::string_view NameOf(const RunEnd& end, rt::CommandFate fate) {
  switch (fate) {
    case rt::CommandFate::kServed: return "served";
    case rt::CommandFate::kHeld: return "held";
    case rt::CommandFate::kNone: break;
  }
  return end.fates_unknown() ? "not known" : "none due";
}

/// All that the figure shows, in numbers.
std::string CycleTable(const RunEnd& end) {
  const std::vector<EndPanel> panels = EndPanels(end);
  std::string html = "<div class=\"wide\"><table>\n<tr><th>state</th><th>command</th>";
  for (const EndPanel& panel : panels) {
    for (const EndCurve& curve : panel.curves) {
      html += fmt::format("<th>{}<br>{}</th>", Escape(curve.name), Escape(panel.unit));
    }
  }
  html += "</tr>\n";
  for (std::size_t i = 0; i < end.cycles.size(); ++i) {
    const rt::CycleRecord& cycle = end.cycles[i].cycle;
    html += fmt::format("<tr{}><td>{}</td><td class=\"word\">{}</td>",
                        cycle.fate == rt::CommandFate::kHeld ? " class=\"held\"" : "",
                        cycle.state.message_id, NameOf(end, cycle.fate));
    for (const EndPanel& panel : panels) {
      for (const EndCurve& curve : panel.curves) {
        html += std::isfinite(curve.values[i]) ? fmt::format("<td>{:.7g}</td>", curve.values[i])
                                               : "<td></td>";
      }
    }
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string ApproachTable(const RunEnd& end) {
  std::string html = "<table>\n";
  for (const Approach& approach : end.approach.Closest()) {
    html += fmt::format("<tr><td>{}</td><td>{:.1f} %</td><td class=\"word\">{}</td></tr>\n",
                        Escape(approach.what), 100 * approach.share, Escape(PlaceOf(approach)));
  }
  return html + "</table>\n";
}

std::string RunLine(const RunEnd& end) {
  const record::RunInfo& run = end.run;
  return fmt::format("scenario {}, seed {}, {}, panda-twin {}", Escape(run.scenario), run.seed,
                     Escape(run.drive), Escape(run.version));
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
  std::string html =
      fmt::format("<h1>{}</h1>\n<p class=\"run\">{}</p>\n", Escape(headline), RunLine(end));
  html += ToHtml(paragraphs);
  html += fmt::format("<h2>The last {} cycles</h2>\n", std::min(end.cycles.size(), RunEnd::kShown));
  html += InlineSvg(SvgOf(EndScript(end)), "end");
  html += "<details><summary>In numbers</summary>\n" + CycleTable(end) + "</details>\n";
  if (end.approach.has_limits()) {
    html += "<h2>How close it had come to the limits before</h2>\n" + ApproachTable(end);
  }
  return HtmlPage(headline, html);
}

}  // namespace twin::report
