#include "twin/golden/case_run.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/render/frame_painter.h"
#include "twin/run/film.h"
#include "twin/run/result.h"

namespace twin::golden {
namespace {

/// Describes the first difference of two texts. @pre they differ.
std::string FirstDifference(const std::string& theirs, const std::string& wanted) {
  std::istringstream left(theirs);
  std::istringstream right(wanted);
  std::string a;
  std::string b;
  while (std::getline(left, a) && std::getline(right, b) && a == b) continue;
  const auto trim = [](const std::string& line) {
    constexpr std::size_t kMost = 100;
    return line.substr(std::min(line.find_first_not_of(" -"), line.size()), kMost);
  };
  return fmt::format("\"{}\", the case's \"{}\"", trim(a), trim(b));
}

/// @returns a description of the first difference between a log's run and the case, ignoring the
/// scenario's camera; empty: none.
std::string DifferenceOf(scenario::Scenario theirs, scenario::Scenario wanted) {
  if (theirs.name != wanted.name) {
    return fmt::format("its scenario is {}, the case's {}", theirs.name, wanted.name);
  }
  if (theirs.seed != wanted.seed) {
    return fmt::format("its seed is {}, the case's {}", theirs.seed, wanted.seed);
  }
  theirs.render = wanted.render;
  const std::string text = ToYaml(theirs);
  const std::string wanted_text = ToYaml(wanted);
  if (text == wanted_text) return {};
  return "its scenario's text (or lab) is another: " + FirstDifference(text, wanted_text);
}

}  // namespace

PicturePlan PlanOf(const scenario::VideoCase& wanted) {
  PicturePlan plan;
  plan.every = wanted.every;
  plan.key_frames = wanted.key_frames;
  for (const scenario::VideoView& view : wanted.views) {
    plan.views.push_back({view.name, run::FilmOf(view.render)});
  }
  return plan;
}

void RequireRunOf(const scenario::VideoCase& wanted, const scenario::Scenario& scenario,
                  const record::LogReader& reader, const std::filesystem::path& log) {
  const std::string& text = reader.run().scenario_yaml;
  if (text.empty()) return;  // replay::Recording refuses such a log
  const std::string difference =
      DifferenceOf(scenario::Parse(text, log.string() + ": scenario.yaml"), scenario);
  if (difference.empty()) return;
  throw InputError(
      fmt::format("{}: not a run of the case {}: {}", log.string(), wanted.name, difference));
}

CaseRun::CaseRun(const scenario::VideoCase& wanted, std::filesystem::path file,
                 std::filesystem::path log, const run::RunFiles& files)
    : file_(std::move(file)),
      plan_(PlanOf(wanted)),
      log_(std::move(log)),
      recording_(log_, files),
      states_(run::StatesHashOf(log_)) {}

void CaseRun::Take(const Golden* golden, const std::function<void()>& between) {
  std::optional<std::vector<std::size_t>> keys;
  if (golden != nullptr && !golden->pictures.views.empty()) {
    keys.emplace();
    for (const KeyPicture& key : golden->pictures.views[0].keys) keys->push_back(key.frame);
  }
  try {
    pictures_ = TakePictures(recording_.Film(), plan_, keys, between);
  } catch (const InputError& error) {  // for example, a body or camera that the model lacks
    throw InputError(fmt::format("{}: {}", file_.string(), error.what()));
  }
}

golden::Evidence CaseRun::Evidence() const {
  const auto look = [this](std::size_t view, std::size_t frame) {
    const render::Film film = recording_.Film();
    render::FramePainter painter(film, plan_.views[view].settings);
    return painter.Segment(FramesOf(film, plan_)[frame]);
  };
  return {&pictures_, states_, look};
}

}  // namespace twin::golden
