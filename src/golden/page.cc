#include "twin/golden/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "twin/golden/signature.h"
#include "twin/render/image.h"
#include "twin/report/page.h"
#include "twin/report/plot.h"

namespace twin::golden {
namespace {

using nlohmann::json;

constexpr std::string_view kTitle = "panda-twin: video regression";

std::string AddressOf(const render::Image& image) {
  const std::vector<char> png = render::EncodePng(image);
  return "data:image/png;base64," + report::Base64({png.data(), png.size()});
}

bool IsSame(const KeyPicture& key, const ViewPictures& other) {
  return std::any_of(other.keys.begin(), other.keys.end(), [&](const KeyPicture& theirs) {
    return theirs.frame == key.frame && theirs.colour == key.colour;
  });
}

/// One side of a viewer as JSON, without the parts that equal `other`'s; null: all parts.
json SideOf(const ViewPictures& view, const ViewPictures* other) {
  const bool same_strip = other != nullptr && other->signatures == view.signatures;
  json keys = json::object();
  for (const KeyPicture& key : view.keys) {
    if (other != nullptr && IsSame(key, *other)) continue;
    keys[fmt::format("{}", key.frame)] = AddressOf(key.colour);
  }
  return {{"frames", view.signatures.size()},
          {"strip", same_strip ? json() : json(AddressOf(JoinSignatures(view.signatures)))},
          {"keys", std::move(keys)}};
}

json JsonOf(const ViewPictures& expected, const ViewPictures& actual) {
  json same = json::array();
  for (const KeyPicture& key : actual.keys) {
    if (IsSame(key, expected)) same.push_back(key.frame);
  }
  return {{"name", actual.name},
          {"width", actual.width},
          {"height", actual.height},
          {"expected", SideOf(expected, nullptr)},
          {"actual", SideOf(actual, &expected)},
          {"same", std::move(same)}};
}

/// Time range of the joint plot, s.
double SpanOf(const CaseResult& result) {
  const double film =
      result.pictures.interval_s *
      static_cast<double>(std::max(result.pictures.frames, result.golden.pictures.frames));
  return result.joints.t.empty() ? film : std::max(film, result.joints.t.back());
}

/// What viewer.js reads.
json ViewerOf(const CaseResult& result) {
  const auto& actual = result.pictures.views;
  std::size_t first_view = 0;
  std::size_t first = 0;
  if (const GateResult* failure = result.comparison.FirstFailure()) {
    first = failure->first->frame;
    for (std::size_t i = 0; i < actual.size(); ++i) {
      if (actual[i].name == failure->first->view) first_view = i;
    }
  }
  json views = json::array();
  for (std::size_t i = 0; i < actual.size(); ++i) {
    views.push_back(JsonOf(result.golden.pictures.views[i], actual[i]));
  }
  return {{"views", std::move(views)},
          {"small", {kStripColumns, kSignatureWidth, kSignatureHeight}},
          {"interval", result.pictures.interval_s},
          {"span", SpanOf(result)},
          {"first", first},
          {"firstView", first_view}};
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

json GatesOf(const Comparison& comparison) {
  json list = json::array();
  for (const GateResult& gate : comparison.gates) {
    const bool decides = gate.gate > Gate::kHashes;
    list.push_back({{"gate", Name(gate.gate)},
                    {"meaning", Meaning(gate.gate)},
                    {"worst", gate.worst},
                    {"limit", gate.limit},
                    {"verdict", gate.passed ? "met"
                                : decides   ? "missed"
                                            : "reported"},
                    {"outcome", gate.passed ? "passed"
                                : decides   ? "failed"
                                            : "not known"},
                    {"place", WhereText(gate.worst_at)}});
  }
  return list;
}

/// Measured and desired positions of the joints.
std::string JointsSvg(const CaseResult& result) {
  report::Figure figure{.id = "joints", .columns = "t [s]"};
  figure.values["span"] = SpanOf(result);
  for (std::size_t joint = 1; joint <= kJoints; ++joint) {
    figure.columns += fmt::format(",q {0} [rad],q_d {0} [rad]", joint);
  }
  for (std::size_t i = 0; i < result.joints.t.size(); ++i) {
    std::vector<double>& row = figure.rows.emplace_back(1, result.joints.t[i]);
    for (std::size_t joint = 0; joint < kJoints; ++joint) {
      row.insert(row.end(), {result.joints.q[joint][i], result.joints.q_d[joint][i]});
    }
  }
  return report::DrawPlot("golden/", figure);
}

json CaseOf(const CaseResult& result, std::size_t number) {
  json views = json::array();
  for (const ViewPictures& view : result.pictures.views) views.push_back(view.name);
  json approvals = json::array();
  for (const Approval& approval : result.golden.approvals) {
    approvals.push_back({{"version", approval.version},
                         {"reason", approval.reason},
                         {"changed", approval.changed}});
  }
  return {{"number", number},
          {"name", result.name},
          {"run", result.run},
          {"verdict", result.comparison.passed() ? "met" : "failed"},
          {"description", Describe(result.comparison, result.pictures)},
          {"gates", GatesOf(result.comparison)},
          {"data", ViewerOf(result).dump()},
          {"views", std::move(views)},
          {"joints", report::InlineSvg(JointsSvg(result), fmt::format("joints{}", number))},
          {"approve", result.approve},
          {"approvals", std::move(approvals)}};
}

}  // namespace

std::string PageOf(std::span<const CaseResult> results) {
  json cases = json::array();
  for (std::size_t i = 0; i < results.size(); ++i) cases.push_back(CaseOf(results[i], i));
  return report::RenderPage("golden/regression", {{"title", kTitle}, {"cases", std::move(cases)}});
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
    const std::string text = report::Escape(Describe(result.comparison, result.pictures));
    xml += fmt::format("<testcase classname=\"video\" name=\"{}\">", report::Escape(result.name));
    xml += result.comparison.passed() ? fmt::format("<system-out>{}</system-out>", text)
                                      : fmt::format("<failure message=\"{}\"/>", text);
    xml += "</testcase>\n";
  }
  return xml + "</testsuite>\n</testsuites>\n";
}

}  // namespace twin::golden
