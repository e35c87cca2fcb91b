#include <algorithm>
#include <exception>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/host.h"
#include "cli/host_facts.h"
#include "cli/interrupt.h"
#include "cli/progress.h"
#include "cli/result_folder.h"
#include "cli/say.h"
#include "cli/summary.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/experiment/calibration.h"
#include "twin/experiment/client_study.h"
#include "twin/experiment/experiment.h"
#include "twin/experiment/page.h"
#include "twin/model/model_library.h"
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
std::vector<Experiment> Chosen(const std::vector<std::string>& ids, bool on_wall_clock) {
  const auto known = experiment::Experiments();
  for (const std::string& id : ids) {
    if (id == "all" || std::ranges::find(known, id, &Experiment::id) != known.end()) continue;
    throw InputError(fmt::format(
        "experiment \"{}\": there is none of that name; there are {}, and all", id, KnownIds()));
  }
  const bool all = std::ranges::find(ids, "all") != ids.end();
  std::vector<Experiment> chosen;
  for (const Experiment& one : known) {
    const bool by_name = std::ranges::find(ids, one.id) != ids.end();
    const bool is_there = !on_wall_clock || one.run_on_wall_clock != nullptr;
    if (by_name && !is_there) {
      throw InputError(
          fmt::format("experiment \"{}\": nothing in it hangs on how a machine keeps time; run it "
                      "without --drive realtime",
                      one.id));
    }
    if ((all && is_there) || by_name) chosen.push_back(one);
  }
  return chosen;
}

bool IsOnWallClock(const ExperimentFlags& flags) {
  if (flags.client) return true;  // whose clock is this machine's, too
  if (flags.drive == "lockstep") return false;
  if (flags.drive == "realtime") return true;
  throw InputError(fmt::format("--drive {}: must be lockstep or realtime", flags.drive));
}

/// @returns how many runs. @throws InputError when they are too many or none.
int SeedsOf(const ExperimentFlags& flags) {
  constexpr int kDefault = 20;
  constexpr int kDefaultOnWallClock = 5;
  constexpr int kMost = 1000;
  const int seeds = flags.seeds.value_or(IsOnWallClock(flags) ? kDefaultOnWallClock : kDefault);
  if (seeds >= 1 && seeds <= kMost) return seeds;
  throw InputError(fmt::format(
      "--seeds {}: must be from 1 to {}; so many runs are averaged, the report's default is 20",
      seeds, kMost));
}

std::string ReadText(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// What kept time, for the report.
std::string MachineText() {
  const HostFacts host = ReadHostFacts();
  return fmt::format(
      "{} processors ({}{}), {}{}, {}", host.processors, host.processor,
      host.virtual_machine ? ", virtual" : "", host.kernel,
      host.realtime_kernel ? " PREEMPT_RT" : "",
      host.may_use_fifo ? "threads at real-time priority" : "no real-time priority was permitted");
}

/// Those that are run in lockstep only.
std::string LeftOutText() {
  std::string ids;
  for (const Experiment& one : experiment::Experiments()) {
    if (one.run_on_wall_clock == nullptr)
      ids += fmt::format("{}{}", ids.empty() ? "" : ", ", one.id);
  }
  return fmt::format(
      "Left out: {}; nothing in them hangs on how a machine keeps time, and the report in lockstep "
      "has "
      "them.",
      ids);
}

experiment::ClientProgram ClientOf(const ExperimentFlags& flags, const Host& host) {
  experiment::ClientProgram program{
      .command = *flags.client, .arm_port = flags.port, .model_library = {}};
  if (flags.seconds) program.most = FromSeconds(*flags.seconds);
  try {
    program.model_library = model::ReadModelLibrary(model::FindModelLibrary(host.executable));
  } catch (const EnvironmentError& error) {
    Say(stderr,
        fmt::format("panda-twin: note: the client gets no model library: {}\n", error.what()));
  }
  return program;
}

/// @returns the flags. @throws InputError when a client was given beside other experiments.
const ExperimentFlags& RequireClientAlone(const ExperimentFlags& flags) {
  if (!flags.client) return flags;
  if (flags.client->empty()) throw InputError("--client: give the program's command line");
  if (flags.ids == std::vector<std::string>{"timings"}) return flags;
  throw InputError("--client goes with the experiment timings, and with that alone");
}

/// What was found, for programs: every figure beside the paper's, with its verdict.
std::string FindingsJson(const std::vector<Findings>& all, int seeds,
                         std::string_view calibration) {
  using Json = nlohmann::ordered_json;
  const auto or_null = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json();
  };
  Json experiments = Json::array();
  for (const Findings& findings : all) {
    Json comparisons = Json::array();
    for (const experiment::Comparison& one : findings.comparisons) {
      comparisons.push_back({{"quantity", one.quantity},
                             {"unit", one.unit},
                             {"paper", or_null(one.paper)},
                             {"ours", one.ours},
                             {"low", or_null(one.low)},
                             {"high", or_null(one.high)},
                             {"demand", one.demand},
                             {"verdict", experiment::Name(one.verdict)},
                             {"reason", one.reason}});
    }
    experiments.push_back({{"id", findings.id},
                           {"outcome", experiment::Outcome(findings)},
                           {"failure", findings.failure},
                           {"comparisons", std::move(comparisons)}});
  }
  return TextOf(
      {{"seeds", seeds}, {"calibration", calibration}, {"experiments", std::move(experiments)}});
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
                    const run::Catalogue& catalogue)
      : flags_(flags),
        host_(host),
        catalogue_(catalogue),
        on_wall_clock_(IsOnWallClock(RequireClientAlone(flags))),
        seeds_(SeedsOf(flags)),
        chosen_(Chosen(flags.ids, on_wall_clock_)),
        data_(scenario::FindDataDirectory({host.executable, flags.data.models, flags.data.meshes})),
        cache_(host.cache),
        scenarios_(flags.calibration.value_or(data_.models / "experiments")),
        out_(flags.out.value_or(flags.client     ? "out/experiments_client"
                                : on_wall_clock_ ? "out/experiments_realtime"
                                                 : "out/experiments")) {
    calibration_ = experiment::ReadCalibration(scenarios_);
    RequireProgram("gnuplot", host.path, "apt-get install gnuplot-nox");
  }

  ExitCode Execute();

 private:
  /// @throws InputError when something else has the report's place.
  void RequireOurs() const;
  void Clear() const;
  [[nodiscard]] Findings Do(const Experiment& one, const fs::path& scratch);
  void WriteCsv(const Findings& findings) const;
  void WritePage() const;
  /// A line for each demand that was missed, and each experiment that failed. @returns whether all
  /// is well.
  [[nodiscard]] bool TellFailures() const;
  [[nodiscard]] fs::path page() const { return out_.folder() / "report.html"; }
  [[nodiscard]] fs::path json() const { return out_.folder() / "findings.json"; }
  [[nodiscard]] fs::path tables() const { return out_.folder() / "csv"; }

  const MonotonicClock clock_;
  const ExperimentFlags& flags_;
  const Host& host_;
  const run::Catalogue& catalogue_;
  const bool on_wall_clock_;
  const int seeds_;
  const std::vector<Experiment> chosen_;
  const scenario::DataDirectory data_;
  const fs::path cache_;
  const fs::path scenarios_;
  experiment::Calibration calibration_;
  ResultFolder out_;
  const InterruptGuard interrupt_;
  std::vector<Findings> findings_;
};

void ExperimentSession::RequireOurs() const {
  std::error_code ignored;
  if (!fs::exists(page(), ignored)) return;
  if (!fs::is_regular_file(page(), ignored) || !experiment::IsPage(ReadText(page()))) {
    throw InputError(
        fmt::format("{}: is there and no report of panda-twin; choose another folder with --out",
                    page().string()));
  }
}

/// Takes away an earlier report, and the tables that it names.
void ExperimentSession::Clear() const {
  std::error_code error;
  if (fs::exists(page(), error)) {
    for (const std::string& name : experiment::CsvNamesOf(ReadText(page()))) {
      fs::remove(tables() / name, error);
    }
    fs::remove(page(), error);
    fs::remove(json(), error);
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
      .seeds = seeds_,
      .is_calibrated = !flags_.calibration,
      .on_wall_clock = on_wall_clock_,
      .progress = [&progress](double share) { progress.Show(share, ""); },
      .interrupted = interrupt_.flag()};
  try {
    if (flags_.client) return experiment::RunClientStudy(setting, ClientOf(flags_, host_));
    return on_wall_clock_ ? one.run_on_wall_clock(setting) : one.run(setting);
  } catch (const std::exception& failure) {
    interrupt_.ThrowIfInterrupted();
    if (flags_.client && dynamic_cast<const EnvironmentError*>(&failure) != nullptr) throw;
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
                              .seeds = seeds_,
                              .calibration = calibration_.hash,
                              .version = TWIN_VERSION};
  if (on_wall_clock_) {
    facts.machine = MachineText();
    if (!flags_.client) facts.left_out = LeftOutText();
  }
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
  RequireOurs();
  const ScratchFolder scratch(out_.folder() / "scratch.partial");
  for (const Experiment& one : chosen_) {
    const Time begin = clock_.Now();
    findings_.push_back(Do(one, scratch.path()));
    interrupt_.ThrowIfInterrupted();
    if (flags_.quiet) continue;
    Say(stdout, fmt::format("{:<14}{} ({:.1f} s)\n", one.id, experiment::Outcome(findings_.back()),
                            ToSeconds(clock_.Now() - begin)));
  }
  Clear();  // what was there stays until there is something in its place
  for (const Findings& findings : findings_) WriteCsv(findings);
  WriteWholeFile(json(), FindingsJson(findings_, seeds_, calibration_.hash));
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
                           const run::Catalogue& catalogue) {
  if (flags.list) return List();
  return ExperimentSession(flags, host, catalogue).Execute();
}

}  // namespace twin::cli
