#include "twin/replay/recording.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/render/frame_painter.h"
#include "twin/run/film.h"

namespace twin::replay {
namespace {

constexpr std::size_t kMostLetters = 48;

/// Cuts a text to one line of a picture, in the characters of its font.
std::string LineOf(std::string_view text) {
  std::string line(text.substr(0, text.find('\n')));
  std::erase_if(line, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; });
  std::ranges::replace_if(
      line, [](char c) { return c < ' ' || c > '~'; }, '?');
  if (line.size() > kMostLetters) line = line.substr(0, kMostLetters - 3) + "...";
  return line;
}

std::string TextOf(const control::Parameter& parameter) {
  return parameter.is_list
             ? fmt::format("{} [{}]", parameter.key, fmt::join(parameter.values, ", "))
             : fmt::format("{} {}", parameter.key, parameter.values.front());
}

/// True if a controller's parameter is a gain.
bool IsGain(std::string_view key) {
  constexpr std::array<std::string_view, 7> kWords = {"stiffness", "damping", "gain", "k0",
                                                      "p",         "i",       "d"};
  const std::string_view last = key.substr(key.find_last_of('.') + 1);
  return std::ranges::any_of(kWords, [&](std::string_view word) {
    return last == word || (word.size() > 1 && key.find(word) != std::string_view::npos);
  });
}

std::string TitleOf(const scenario::Scenario& scenario) {
  if (scenario.application) {
    if (scenario.application->type == scenario.name) return LineOf(scenario.name);
    return fmt::format("{}\n{}", LineOf(scenario.name), LineOf(scenario.application->type));
  }
  std::string gains = scenario.controller.type;
  for (const control::Parameter& parameter : scenario.controller.parameters) {
    if (IsGain(parameter.key)) gains += ", " + TextOf(parameter);
  }
  return fmt::format("{}\n{}", LineOf(scenario.name), LineOf(gains));
}

/// Drops the details after a completed step's first comma.
std::string NoteOf(const record::EventRecord& event) {
  std::string_view text = event.text;
  if (event.kind == "step" && text.find(": done") != std::string_view::npos) {
    text = text.substr(0, text.find(','));
  }
  return LineOf(fmt::format("{}: {}", event.kind, text));
}

bool IsShown(const record::EventRecord& event) {
  constexpr std::array<std::string_view, 5> kKinds = {"step", "hand", "error", "stop", "recovery"};
  return std::ranges::find(kKinds, event.kind) != kKinds.end();
}

}  // namespace

render::Film FilmOfRun(const mjModel_& model, const render::Snapshots& snapshots,
                       const scenario::Scenario& scenario,
                       std::span<const record::PlanRecord> plans,
                       std::span<const record::EventRecord> events) {
  render::Film film;
  film.model = &model;
  film.snapshots = &snapshots;
  film.title = TitleOf(scenario);
  for (const record::PlanRecord& plan : plans) {
    film.goals.push_back({.from = plan.from,
                          .until = plan.until,
                          .q = plan.q,
                          .path = plan.path,
                          .object = plan.object,
                          .O_T_object = plan.O_T_object});
    // The caption's part after a semicolon refers to a report's pair of pictures.
    const std::string_view caption =
        std::string_view(plan.caption).substr(0, plan.caption.find(';'));
    if (!caption.empty()) film.notes.push_back({plan.from, LineOf(caption)});
  }
  for (const record::EventRecord& event : events) {
    if (IsShown(event)) film.notes.push_back({event.at, NoteOf(event)});
  }
  std::ranges::stable_sort(film.notes, {}, &render::FilmNote::at);
  return film;
}

void CheckPicture(const backend::Connection& connection, const scenario::RenderSection& wanted,
                  const std::filesystem::path& scenario) {
  const render::Snapshots none(wanted.fps, connection.truth->qpos_size());
  try {
    const render::FramePainter painter({&connection.truth->model(), &none}, run::FilmOf(wanted));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", scenario.string(), error.what()));
  }
}

render::ClipStats RenderClip(const render::ClipFrames& frames, const render::ClipPaths& paths,
                             const Clock& clock, run::Console& console) {
  const Time begin = clock.Now();
  return render::RenderClip(frames, {}, paths, clock, [&](std::size_t done, std::size_t total) {
    console.ThrowIfInterrupted();
    const double rate = static_cast<double>(done) / ToSeconds(clock.Now() - begin);
    console.Show("video", static_cast<double>(done) / static_cast<double>(total),
                 fmt::format("{} of {} frames, {:.0f} frames/s", done, total, rate));
  });
}

}  // namespace twin::replay
