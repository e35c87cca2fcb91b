#include <algorithm>
#include <exception>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/host.h"
#include "cli/interrupt.h"
#include "cli/progress.h"
#include "cli/result_folder.h"
#include "cli/say.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/experiment/calibration.h"
#include "twin/experiment/experiment.h"
#include "twin/experiment/page.h"
#include "twin/scenario/data_directory.h"

namespace twin::cli {
namespace {

namespace fs = std::filesystem;
using experiment::Experiment;
using experiment::Findings;

std::string KnownIds() {
  std::string ids;
  for (const Experiment& one : experiment::Experiments()) {
    ids += fmt::format("{}{}", ids.empty() ? "" : ", ", one.id);
  }
  return ids;
}

/// Those that were asked for, in the order of the paper. @throws InputError for one there is not.
std::vector<Experiment> Chosen(const std::vector<std::string>& ids) {
  const auto known = experiment::Experiments();
  for (const std::string& id : ids) {
    if (id == "all" || std::ranges::find(known, id, &Experiment::id) != known.end()) continue;
    throw InputError(fmt::format(
        "experiment \"{}\": there is none of that name; there are {}, and all", id, KnownIds()));
  }
  const bool all = std::ranges::find(ids, "all") != ids.end();
  std::vector<Experiment> chosen;
  for (const Experiment& one : known) {
    if (all || std::ranges::find(ids, one.id) != ids.end()) chosen.push_back(one);
  }
  return chosen;
}

void CheckSeeds(int seeds) {
  constexpr int kMost = 1000;
  if (seeds >= 1 && seeds <= kMost) return;
  throw InputError(fmt::format(
      "--seeds {}: must be from 1 to {}; so many runs are averaged, the report's default is 20",
      seeds, kMost));
}

/// A folder that is there as long as this.
class ScratchFolder {
 public:
  explicit ScratchFolder(fs::path path) : path_(std::move(path)) {
    std::error_code error;
    fs::create_directories(path_, error);
    if (error) {
      throw EnvironmentError(fmt::format(
          "{}: cannot be made ({}); choose a folder of your own with --out, or make room",
          path_.string(), error.message()));
    }
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// One report from its flags to its files.
class ExperimentSession {
 public:
  ExperimentSession(const ExperimentFlags& flags, const Host& host,
                    const scenario::Catalogue& catalogue)
      : flags_(flags),
        catalogue_(catalogue),
        chosen_(Chosen(flags.ids)),
        data_(scenario::FindDataDirectory({host.executable, flags.data.models, flags.data.meshes})),
        cache_(host.cache),
        scenarios_(flags.calibration.value_or(data_.models / "experiments")),
        out_(flags.out) {
    CheckSeeds(flags.seeds);
    calibration_ = experiment::ReadCalibration(scenarios_);
    RequireProgram("gnuplot", host.path, "apt-get install gnuplot-nox");
  }

  ExitCode Execute();

 private:
  void Clear() const;
  [[nodiscard]] Findings Do(const Experiment& one, const fs::path& scratch);
  void WriteCsv(const Findings& findings) const;
  void WritePage() const;
  /// A line for each demand that was missed, and each experiment that failed. @returns whether all
  /// is well.
  [[nodiscard]] bool TellFailures() const;
  [[nodiscard]] fs::path page() const { return out_.folder() / "report.html"; }
  [[nodiscard]] fs::path tables() const { return out_.folder() / "csv"; }

  const MonotonicClock clock_;
  const ExperimentFlags& flags_;
  const scenario::Catalogue& catalogue_;
  const std::vector<Experiment> chosen_;
  const scenario::DataDirectory data_;
  const fs::path cache_;
  const fs::path scenarios_;
  experiment::Calibration calibration_;
  ResultFolder out_;
  const InterruptGuard interrupt_;
  std::vector<Findings> findings_;
};

/// Takes away what an earlier report left, by name.
void ExperimentSession::Clear() const {
  std::error_code error;
  fs::remove(page(), error);
  for (const auto& entry : fs::directory_iterator(tables(), error)) {
    const std::string name = entry.path().filename();
    const bool is_ours = std::ranges::any_of(experiment::Experiments(), [&](const Experiment& one) {
      return name.starts_with(fmt::format("{}_", one.id)) && name.ends_with(".csv");
    });
    std::error_code ignored;
    if (is_ours) fs::remove(entry.path(), ignored);
  }
  fs::create_directories(tables(), error);
  if (error) {
    throw EnvironmentError(fmt::format("{}: cannot be made ({}); choose another --out",
                                       tables().string(), error.message()));
  }
}

Findings ExperimentSession::Do(const Experiment& one, const fs::path& scratch) {
  Progress progress(std::string(one.id), Progress::StyleOfStdout(flags_.quiet), clock_);
  const experiment::Setting setting{
      .catalogue = catalogue_,
      .files = {data_.models, data_.mesh_package, cache_, false},
      .scenarios = scenarios_,
      .scratch = scratch,
      .seed = flags_.seed.value_or(1),
      .seeds = flags_.seeds,
      .progress = [&progress](double share) { progress.Show(share, ""); },
      .interrupted = interrupt_.flag()};
  try {
    return one.run(setting);
  } catch (const std::exception& failure) {
    interrupt_.ThrowIfInterrupted();
    return {.id = std::string(one.id), .title = std::string(one.title), .failure = failure.what()};
  }
}

void ExperimentSession::WriteCsv(const Findings& findings) const {
  for (const experiment::Figure& figure : findings.figures) {
    WriteWholeFile(tables() / experiment::CsvName(findings, figure), experiment::Csv(figure));
  }
}

void ExperimentSession::WritePage() const {
  experiment::PageFacts facts{.seed = flags_.seed.value_or(1),
                              .seeds = flags_.seeds,
                              .calibration = calibration_.hash,
                              .version = TWIN_VERSION};
  for (const std::string& yaml : calibration_.yaml) (facts.parameters += yaml) += '\n';
  WriteWholeFile(page(), experiment::Page(findings_, facts));
}

bool ExperimentSession::TellFailures() const {
  bool is_well = true;
  for (const Findings& findings : findings_) {
    if (findings.succeeded()) continue;
    is_well = false;
    std::string lines;
    if (!findings.failure.empty()) lines = fmt::format("failed: {}\n", findings.failure);
    lines += experiment::MissedLines(findings);
    while (!lines.empty()) {
      const std::size_t end = lines.find('\n');
      Say(stderr, fmt::format("panda-twin: {}: {}\n", findings.id, lines.substr(0, end)));
      lines.erase(0, end + 1);
    }
  }
  return is_well;
}

ExitCode ExperimentSession::Execute() {
  out_.Prepare();
  Clear();
  const ScratchFolder scratch(out_.folder() / "scratch.partial");
  for (const Experiment& one : chosen_) {
    const Time begin = clock_.Now();
    findings_.push_back(Do(one, scratch.path()));
    interrupt_.ThrowIfInterrupted();
    WriteCsv(findings_.back());
    if (flags_.quiet) continue;
    Say(stdout, fmt::format("{:<14}{} ({:.1f} s)\n", one.id, experiment::Outcome(findings_.back()),
                            ToSeconds(clock_.Now() - begin)));
  }
  WritePage();
  if (!flags_.quiet) Say(stdout, fmt::format("report        {}\n", page().string()));
  return TellFailures() ? kOk : kFailed;
}

ExitCode List() {
  for (const Experiment& one : experiment::Experiments()) {
    Say(stdout, fmt::format("{:<14}{}\n", one.id, one.title));
  }
  FinishOutput();
  return kOk;
}

}  // namespace

ExitCode ExperimentCommand(const ExperimentFlags& flags, const Host& host,
                           const scenario::Catalogue& catalogue) {
  if (flags.list) return List();
  return ExperimentSession(flags, host, catalogue).Execute();
}

}  // namespace twin::cli
