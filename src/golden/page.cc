#include "twin/golden/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <string_view>

#include "golden/page_script.h"
#include "twin/golden/signature.h"
#include "twin/render/png.h"
#include "twin/report/chart.h"
#include "twin/report/html.h"

namespace twin::golden {
namespace {

using report::Escape;

constexpr std::string_view kTitle = "panda-twin: video regression";

std::string AddressOf(const render::Image& image) {
  const std::vector<char> png = render::EncodePng(image);
  return fmt::format("\"data:image/png;base64,{}\"", report::Base64({png.data(), png.size()}));
}

bool IsSame(const KeyPicture& key, const ViewPictures& other) {
  return std::any_of(other.keys.begin(), other.keys.end(), [&](const KeyPicture& theirs) {
    return theirs.frame == key.frame && theirs.colour == key.colour;
  });
}

/// One side of a viewer as JSON, without the parts that equal `other`'s; null: all parts.
std::string SideJson(const ViewPictures& view, const ViewPictures* other) {
  const bool same_strip = other != nullptr && other->signatures == view.signatures;
  std::string keys;
  for (const KeyPicture& key : view.keys) {
    if (other != nullptr && IsSame(key, *other)) continue;
    keys += fmt::format("{}\"{}\":{}", keys.empty() ? "" : ",", key.frame, AddressOf(key.colour));
  }
  return fmt::format("{{\"frames\":{},\"strip\":{},\"keys\":{{{}}}}}", view.signatures.size(),
                     same_strip ? "null" : AddressOf(JoinSignatures(view.signatures)), keys);
}

std::string ViewJson(const ViewPictures& expected, const ViewPictures& actual) {
  std::string same;
  for (const KeyPicture& key : actual.keys) {
    if (IsSame(key, expected)) same += fmt::format("{}{}", same.empty() ? "" : ",", key.frame);
  }
  return fmt::format(
      "{{\"name\":\"{}\",\"width\":{},\"height\":{},\"expected\":{},\"actual\":{},\"same\":[{}]}}",
      actual.name, actual.width, actual.height, SideJson(expected, nullptr),
      SideJson(actual, &expected), same);
}

/// Time range of the joint plot, s.
double SpanOf(const CaseResult& result) {
  const double film =
      result.pictures.interval_s *
      static_cast<double>(std::max(result.pictures.frames, result.golden.pictures.frames));
  return result.joints.t.empty() ? film : std::max(film, result.joints.t.back());
}

std::string DataJson(const CaseResult& result) {
  const auto& actual = result.pictures.views;
  std::size_t first_view = 0;
  std::size_t first = 0;
  if (const GateResult* failure = result.comparison.FirstFailure()) {
    first = failure->first->frame;
    for (std::size_t i = 0; i < actual.size(); ++i) {
      if (actual[i].name == failure->first->view) first_view = i;
    }
  }
  std::string views;
  for (std::size_t i = 0; i < actual.size(); ++i) {
    if (i > 0) views += ",";
    views += ViewJson(result.golden.pictures.views[i], actual[i]);
  }
  return fmt::format(
      "{{\"views\":[{}],\"small\":[{},{},{}],\"interval\":{},\"span\":{},\"first\":{},"
      "\"firstView\":{}}}",
      views, kStripColumns, kSignatureWidth, kSignatureHeight, result.pictures.interval_s,
      SpanOf(result), first, first_view);
}

std::string WhereText(const std::optional<Place>& place) {
  if (!place) return {};
  std::string text = fmt::format("frame {}", place->frame);
  if (!place->view.empty()) text += ", " + place->view;
  if (place->region.width > 0) {
    text += fmt::format(", {} x {} pixels at ({}, {})", place->region.width, place->region.height,
                        place->region.left, place->region.top);
  }
  if (!place->body.empty()) text += ", " + place->body;
  return text;
}

std::string GatesHtml(const Comparison& comparison) {
  std::string html =
      "<div class=\"wide\"><table>\n<tr><th>gate</th><th>measures</th><th>worst</th><th>at "
      "most</th><th>verdict</th><th>worst at</th></tr>\n";
  for (const GateResult& gate : comparison.gates) {
    const bool decides = gate.gate > Gate::kHashes;
    const std::string_view verdict = gate.passed ? "met" : decides ? "missed" : "reported";
    html += fmt::format(
        "<tr><td>{}</td><td class=\"word\">{}</td><td>{:.4g}</td><td>{:.4g}</td><td "
        "class=\"{}\">{}</td><td class=\"word\">{}</td></tr>\n",
        Name(gate.gate), Escape(Meaning(gate.gate)), gate.worst, gate.limit, verdict,
        gate.passed ? "passed"
        : decides   ? "failed"
                    : "not known",
        Escape(WhereText(gate.worst_at)));
  }
  return html + "</table></div>\n";
}

std::string JointsSvg(const CaseResult& result) {
  report::Chart chart;
  report::ChartPanel& panel = chart.panels.emplace_back();
  panel.x_label = "t [s]";
  panel.y_label = "q, dashed q_d [rad]";
  panel.x_range = {{0, SpanOf(result)}};
  for (std::size_t joint = 0; joint < kJoints; ++joint) {
    const std::string_view colour = joint < report::colour::kSeries.size()
                                        ? report::colour::kSeries[joint]
                                        : report::colour::kReference;
    panel.curves.push_back({.name = fmt::format("{}", joint + 1),
                            .colour = colour,
                            .x = result.joints.t,
                            .y = result.joints.q[joint]});
    panel.curves.push_back({.colour = colour,
                            .style = report::ChartCurve::Style::kDashed,
                            .x = result.joints.t,
                            .y = result.joints.q_d[joint]});
  }
  return report::DrawChart(chart);
}

std::string ViewerHtml(const CaseResult& result, std::size_t number) {
  std::string buttons;
  for (const ViewPictures& view : result.pictures.views) {
    buttons += fmt::format("<button class=\"view\">{}</button>", Escape(view.name));
  }
  std::string panels;
  for (const char* name : {"expected", "actual", "difference, 16 times"}) {
    panels += fmt::format("<figure><figcaption>{}</figcaption><canvas></canvas></figure>", name);
  }
  return fmt::format(
      "<script type=\"application/json\">{}</script>\n<div class=\"controls\">{}</div>\n<div "
      "class=\"panels\">{}</div>\n<div class=\"controls\"><button "
      "class=\"previous\">&#9664;</button><input type=\"range\" min=\"0\" value=\"0\"><button "
      "class=\"next\">&#9654;</button></div>\n<p class=\"where\"></p>\n<div "
      "class=\"joints\">{}</div>\n",
      DataJson(result), buttons, panels,
      report::InlineSvg(JointsSvg(result), fmt::format("joints{}", number)));
}

std::string CaseHtml(const CaseResult& result, std::size_t number) {
  std::string html = fmt::format(
      "<section class=\"case\" id=\"case{}\">\n<h2>{}</h2>\n<p class=\"run\">{}</p>\n<p "
      "class=\"{}\">{}</p>\n{}{}",
      number, Escape(result.name), Escape(result.run),
      result.comparison.passed() ? "met" : "failed",
      Escape(Describe(result.comparison, result.pictures)), GatesHtml(result.comparison),
      ViewerHtml(result, number));
  html += fmt::format("<p>If the actual pictures are right:</p>\n<pre>{}</pre>\n",
                      Escape(result.approve));
  html += "<details><summary>What was approved before</summary>\n<table>\n";
  for (const Approval& approval : result.golden.approvals) {
    html +=
        fmt::format("<tr><td>{}</td><td class=\"word\">{}</td><td class=\"word\">{}</td></tr>\n",
                    Escape(approval.version), Escape(approval.reason), Escape(approval.changed));
  }
  return html + "</table></details>\n</section>\n";
}

std::string SummaryHtml(std::span<const CaseResult> results) {
  std::string html = "<table>\n<tr><th>case</th><th>verdict</th></tr>\n";
  for (std::size_t i = 0; i < results.size(); ++i) {
    html += fmt::format("<tr><td><a href=\"#case{}\">{}</a></td><td class=\"{}\">{}</td></tr>\n", i,
                        Escape(results[i].name), results[i].comparison.passed() ? "met" : "missed",
                        Escape(Describe(results[i].comparison, results[i].pictures)));
  }
  return html + "</table>\n";
}

}  // namespace

std::string PageOf(std::span<const CaseResult> results) {
  std::string body = fmt::format(
      "<style>{}</style>\n<h1>Pictures compared with those approved</h1>\n<p class=\"run\">Under "
      "the mouse, expected and actual change places. Key pictures are shown whole, the frames "
      "between them as small as they are kept.</p>\n{}",
      PageStyle(), SummaryHtml(results));
  for (std::size_t i = 0; i < results.size(); ++i) body += CaseHtml(results[i], i);
  return report::HtmlPage(kTitle, body + fmt::format("<script>{}</script>\n", PageScript()));
}

bool IsPage(const std::filesystem::path& file) {
  constexpr std::size_t kHead = 1000;
  std::string head(kHead, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(head.data(), kHead);
  return head.find(fmt::format("<title>{}</title>", kTitle)) != std::string::npos;
}

std::string JUnitOf(std::span<const CaseResult> results) {
  const auto failures = std::count_if(results.begin(), results.end(), [](const CaseResult& result) {
    return !result.comparison.passed();
  });
  std::string xml = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n<testsuite name=\"video\" "
      "tests=\"{}\" failures=\"{}\">\n",
      results.size(), failures);
  for (const CaseResult& result : results) {
    const std::string text = Escape(Describe(result.comparison, result.pictures));
    xml += fmt::format("<testcase classname=\"video\" name=\"{}\">", Escape(result.name));
    xml += result.comparison.passed() ? fmt::format("<system-out>{}</system-out>", text)
                                      : fmt::format("<failure message=\"{}\"/>", text);
    xml += "</testcase>\n";
  }
  return xml + "</testsuite>\n</testsuites>\n";
}

}  // namespace twin::golden
