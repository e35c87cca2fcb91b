#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "loaded_scenario.h"
#include "twin/application/record_run.h"
#include "twin/core/calendar_clock.h"
#include "twin/core/error.h"
#include "twin/core/error_catalogue.h"
#include "twin/rt/find_program.h"
#include "twin/run/explain.h"
#include "twin/run/result_folder.h"
#include "waiting.h"

namespace twin::python {
namespace {

/// Keeps what a run says for Python, which asks from another thread.
///
/// Threads: the run's; the four takers any.
class KeepingConsole final : public run::Console {
 public:
  using Line = std::pair<std::string, std::string>;  ///< level ("info", "warning"), text
  struct Progress {
    std::string work;
    double share = 0;
  };

  void Print(std::string_view text) override { Say(text); }
  void Say(std::string_view text) override {
    const std::scoped_lock lock(mutex_);
    text_ += text;
  }
  void Debug(std::string_view /*text*/) override {}
  void Note(std::string_view text) override { Keep("info", text); }
  void Warn(std::string_view text) override { Keep("warning", text); }
  void Show(std::string_view work, double share, std::string_view /*note*/) override {
    const std::scoped_lock lock(mutex_);
    progress_ = {std::string(work), share};
  }
  [[nodiscard]] const volatile bool& interrupted() const noexcept override { return interrupted_; }
  void Interrupt() noexcept override { interrupted_ = true; }

  [[nodiscard]] volatile bool& flag() noexcept { return interrupted_; }
  [[nodiscard]] std::string TakeText() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(text_, {});
  }
  [[nodiscard]] std::vector<Line> TakeLines() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(lines_, {});
  }
  /// Since the last call; nullopt: none.
  [[nodiscard]] std::optional<Progress> TakeProgress() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(progress_, std::nullopt);
  }

 private:
  void Keep(std::string level, std::string_view text) {
    const std::scoped_lock lock(mutex_);
    lines_.emplace_back(std::move(level), text);
  }

  std::mutex mutex_;
  std::string text_;
  std::vector<Line> lines_;
  std::optional<Progress> progress_;
  volatile bool interrupted_ = false;
};

/// As the flags of `panda-twin run`.
struct RunWishes {
  std::filesystem::path out;
  std::optional<std::uint64_t> seed;
  std::optional<std::string> drive;
  std::optional<std::string> lab;
  std::string quality;
  bool video = true;
  bool plots = true;
  bool strict = false;
  bool is_kept = true;  ///< in the history of runs, as a rehearsal
};

/// How a run ended that left a summary.
struct RunEnd {
  std::string failure;  ///< empty: success
  std::string text;     ///< what the program prints
  std::vector<KeepingConsole::Line> lines;
};

bool IsFine(const std::string& quality) {
  if (quality == "draft" || quality == "fine") return quality == "fine";
  throw InputError(fmt::format("quality is \"{}\"; accepted: draft, fine", quality));
}

/// @throws InputError as scenario::ApplyLab and Scenario::Validate; for a remote robot.
scenario::Scenario With(const RunWishes& wishes, const run::RunFiles& files,
                        scenario::Scenario scenario) {
  if (wishes.lab) scenario::ApplyLab(scenario::FindLab(*wishes.lab, files.models), scenario);
  if (wishes.seed) scenario.seed = *wishes.seed;
  if (scenario.is_remote()) {
    throw InputError(
        "backend is fci: a robot at the other end of a wire is moved by panda-twin run --backend "
        "fci, which checks it first; say backend: mujoco for the twin");
  }
  if (wishes.drive) scenario.drive = scenario::DriveFromName(*wishes.drive);
  scenario.Validate();
  return scenario;
}

void RequirePrograms(const scenario::Scenario& scenario, const application::RunOptions& options) {
  const application::NeededPrograms needed = application::ProgramsFor(scenario, options);
  if (needed.ffmpeg) {
    rt::RequireProgram("ffmpeg", TheHost().path, "apt-get install ffmpeg, or run with video=False");
  }
  if (needed.gnuplot) {
    rt::RequireProgram("gnuplot", TheHost().path,
                       "apt-get install gnuplot-nox, or run with plots=False");
  }
}

/// @returns the failure of a run that left a summary; empty: success.
std::string Record(const LoadedScenario& loaded, const RunWishes& wishes, KeepingConsole& console) {
  const run::RunFiles files = Files();
  const scenario::Scenario scenario = With(wishes, files, loaded.scenario);
  application::RunOptions options{.scenario = loaded.file,
                                  .out = wishes.out,
                                  .site = wishes.lab ? "lab " + *wishes.lab : "the scenario's own",
                                  .makes_video = wishes.video,
                                  .makes_plots = wishes.plots,
                                  .has_fine_pictures = IsFine(wishes.quality),
                                  .strict = wishes.strict};
  RequirePrograms(scenario, options);
  const CalendarClock calendar;
  const run::RunHistory history(TheHost().state, calendar);
  if (wishes.is_kept) {
    options.hardware.history = &history;
    options.hardware.rehearsal.hash = run::RehearsalHash(scenario, files);
  }
  try {
    application::RecordRun({scenario, options, files, TheCatalogue(), console});
  } catch (const InputError&) {
    throw;
  } catch (const EnvironmentError&) {
    throw;
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

RunEnd Run(const LoadedScenario& loaded, const RunWishes& wishes, const nb::object& progress) {
  KeepingConsole console;
  RunEnd end;
  std::function<void()> attend;
  if (!progress.is_none()) {
    attend = [&] {
      if (const auto now = console.TakeProgress()) progress(now->work, now->share);
    };
  }
  DoAndWait(
      console.flag(), [&] { end.failure = Record(loaded, wishes, console); }, attend);
  end.text = console.TakeText();
  end.lines = console.TakeLines();
  return end;
}

report::Explanation Explain(const std::filesystem::path& log, std::optional<std::uint64_t> motion,
                            bool draws_page) {
  using Parts = report::ExplanationParts;
  volatile bool interrupted = false;
  report::Explanation explanation;
  DoAndWait(interrupted, [&] {
    explanation = run::Explain(log, motion, draws_page ? Parts::kTextAndPage : Parts::kText);
  });
  return explanation;
}

/// From 1 on; nullopt: the error is of no joint.
std::optional<int> JointOf(const report::ExplainedError& error) {
  const Violation& violation = error.violation;
  if (EntryOf(violation).axis != AxisKind::kJoint || violation.axis < 0) return std::nullopt;
  return violation.axis + 1;
}

/// A property that only a log with the violated value has.
template <typename Get>
auto IfKnown(Get get) {
  return [get](const report::ExplainedError& error) {
    using Value = decltype(get(error.violation));
    return error.has_value ? std::optional<Value>(get(error.violation)) : std::nullopt;
  };
}

void AddExplanation(nb::module_& module) {
  using report::ExplainedError;
  nb::class_<ExplainedError>(module, "ExplainedError", "The error that ended a motion.")
      .def_prop_ro(
          "name",
          [](const ExplainedError& self) { return std::string(Name(self.violation.error)); })
      .def_prop_ro("joint", &JointOf)
      .def_prop_ro("axis", [](const ExplainedError& self) { return AxisName(self.violation); })
      .def_prop_ro("value", IfKnown([](const Violation& violation) { return violation.value; }))
      .def_prop_ro("limit", IfKnown([](const Violation& violation) { return violation.limit; }))
      .def_prop_ro("unit",
                   [](const ExplainedError& self) { return std::string(UnitOf(self.violation)); })
      .def_ro("cycle", &ExplainedError::cycle)
      .def_prop_ro("time",
                   [](const ExplainedError& self) { return ToSeconds(self.at.time_since_epoch()); })
      .def_ro("motion", &ExplainedError::motion);
  nb::class_<report::Explanation>(module, "Explanation", "How a run ended; see explain().")
      .def_ro("aborted", &report::Explanation::aborted)
      .def_ro("error", &report::Explanation::error)
      .def_ro("text", &report::Explanation::text)
      .def_ro("page", &report::Explanation::page);
  module.def("explain", &Explain, nb::arg("log"), nb::arg("motion").none(), nb::arg("draws_page"));
  module.def("find_log", &run::FindLog, nb::arg("named"));
}

}  // namespace

void AddRun(nb::module_& module) {
  nb::class_<RunEnd>(module, "RunEnd", "How a run ended; see run().")
      .def_ro("failure", &RunEnd::failure)
      .def_ro("text", &RunEnd::text)
      .def_ro("lines", &RunEnd::lines);
  module.def(
      "run",
      [](const LoadedScenario& scenario, std::filesystem::path out,
         std::optional<std::uint64_t> seed, std::optional<std::string> drive,
         std::optional<std::string> lab, std::string quality, bool video, bool plots, bool strict,
         bool is_kept, const nb::object& progress) {
        return Run(scenario,
                   {std::move(out), seed, std::move(drive), std::move(lab), std::move(quality),
                    video, plots, strict, is_kept},
                   progress);
      },
      nb::arg("scenario"), nb::kw_only(), nb::arg("out"), nb::arg("seed").none(),
      nb::arg("drive").none(), nb::arg("lab").none(), nb::arg("quality"), nb::arg("video"),
      nb::arg("plots"), nb::arg("strict"), nb::arg("is_kept"), nb::arg("progress").none(),
      nb::sig("def run(scenario: LoadedScenario, *, out: str | os.PathLike[str], seed: int | None, "
              "drive: str | None, lab: str | None, quality: str, video: bool, plots: bool, strict: "
              "bool, is_kept: bool, progress: collections.abc.Callable[[str, float], None] | None) "
              "-> RunEnd"));
  AddExplanation(module);
}

}  // namespace twin::python
