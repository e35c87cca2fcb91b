// Puts faults into the film of a recorded run, one after the other, and tells which gates find
// them.
//
//     golden_defects CASES CASE LOG MODELS MESHES [EVERY]
//
// What is expected is what was approved of the case; with EVERY it is taken from the film itself,
// as it is without a fault, and only each so many frames are looked at, which is faster. Hashes
// count for nothing. Prints a table in Markdown. Exit code 1: a fault was not found, or the film
// without one raised an alarm.

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "golden/defects.h"
#include "twin/golden/case_run.h"
#include "twin/golden/comparison.h"
#include "twin/golden/golden.h"
#include "twin/replay/recording.h"
#include "twin/scenario/video_case.h"

namespace twin::golden {
namespace {

std::vector<std::size_t> KeysOf(const Golden& golden) {
  std::vector<std::size_t> keys;
  for (const KeyPicture& key : golden.pictures.views.at(0).keys) keys.push_back(key.frame);
  return keys;
}

void PrintHeader() {
  std::string line = "| defect |";
  std::string rule = "|---|";
  for (std::size_t i = 2; i < kGates; ++i) {
    line += fmt::format(" {} |", Name(static_cast<Gate>(i)));
    rule += "---|";
  }
  fmt::print("{} found at |\n{}---|\n", line, rule);
}

/// A row: what each gate measured, in bold where it failed.
void PrintRow(std::string_view name, const Comparison& comparison) {
  fmt::print("| {} |", name);
  for (std::size_t i = 2; i < kGates; ++i) {
    const GateResult& gate = comparison.gates[i];
    const char* const bold = gate.passed ? "" : "**";
    fmt::print(" {0}{1:.3g}{0} |", bold, gate.worst);
  }
  const GateResult* failure = comparison.FirstFailure();
  fmt::print(" {} |\n",
             failure == nullptr
                 ? std::string("-")
                 : fmt::format("frame {}, {}", failure->first->frame,
                               failure->first->body.empty() ? "the film" : failure->first->body));
  std::fflush(stdout);
}

int Run(char** arguments, std::optional<std::size_t> every) {
  const std::filesystem::path cases = arguments[0];
  const scenario::VideoCase wanted =
      scenario::LoadVideoCase(cases / (std::string(arguments[1]) + ".yaml"));
  const replay::Recording recording(arguments[2], {arguments[3], arguments[4], {}, false});
  const render::Film film = recording.Film();
  PicturePlan plan = PlanOf(wanted);
  Golden golden;
  if (every) {
    plan.every = *every;
    golden.pictures = TakePictures(film, plan);
  } else {
    golden = ReadGolden(cases / wanted.name);
  }
  const std::vector<std::size_t> keys = KeysOf(golden);
  PrintHeader();
  const Pictures clean = FaultyFilm(film, plan).Take(keys);
  const Comparison without = Compare(golden, {&clean, 0, {}});
  PrintRow("none", without);
  bool found_all = without.passed();
  for (const Defect& defect : Defects()) {
    if (defect.applies && !defect.applies(film)) continue;
    FaultyFilm faulty(film, plan);
    if (defect.in_film) defect.in_film(faulty);
    Pictures pictures = faulty.Take(keys);
    if (defect.in_pictures) defect.in_pictures(pictures);
    const Comparison comparison = Compare(golden, {&pictures, 0, {}});
    PrintRow(defect.name, comparison);
    found_all = found_all && !comparison.passed();
  }
  return found_all ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace
}  // namespace twin::golden

int main(int argc, char** argv) {
  constexpr int kFewest = 6;
  if (argc != kFewest && argc != kFewest + 1) {
    fmt::print(stderr, "usage: golden_defects CASES CASE LOG MODELS MESHES [EVERY]\n");
    return 2;
  }
  try {
    const auto every = argc > kFewest
                           ? std::optional<std::size_t>(std::strtoul(argv[kFewest], nullptr, 10))
                           : std::nullopt;
    return twin::golden::Run(argv + 1, every);
  } catch (const std::exception& error) {
    fmt::print(stderr, "golden_defects: {}\n", error.what());
    return EXIT_FAILURE;
  }
}
