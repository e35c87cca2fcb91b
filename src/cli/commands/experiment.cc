#include <algorithm>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/commands/commands.h"
#include "cli/shared_flags.h"
#include "cli/terminal.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/experiment/experiment.h"
#include "twin/experiment/page.h"
#include "twin/loop/host_timing.h"
#include "twin/report/plot.h"
#include "twin/run/result_folder.h"
#include "twin/scenario/data_directory.h"

namespace twin::cli {
namespace {

struct ExperimentFlags {
  std::vector<std::string> ids;  ///< or all
  std::optional<std::uint64_t> seed;
  std::string drive = "lockstep";  ///< or realtime
  std::optional<int> seeds;        ///< runs of what is averaged, in [1, 1000]; 20, in realtime 5
  std::optional<std::filesystem::path> out;  ///< out/experiments, or out/experiments_realtime
  std::optional<std::filesystem::path> calibration;  ///< instead of models/experiments
  std::optional<std::string> client;                 ///< a program to be timed, for /bin/sh
  std::uint16_t port = 1337;                         ///< where the client finds the arm
  std::optional<double> seconds;                     ///< after which the client is ended
  bool list = false;                                 ///< only say which there are
  DataFlags data;
};

namespace fs = std::filesystem;
using experiment::Experiment;
using experiment::Findings;

/// Ids of experiments. @param all  false: of those that run in lockstep only.
std::string IdsOf(bool all) {
  std::vector<std::string_view> ids;
  for (const Experiment& one : experiment::Experiments()) {
    if (all || one.run_on_wall_clock == nullptr) ids.push_back(one.id);
  }
  return fmt::format("{}", fmt::join(ids, ", "));
}

/// Those that were asked for, in the order of the paper. @throws InputError for one there is not.
std::vector<Experiment> Chosen(const std::vector<std::string>& ids, bool on_wall_clock) {
  const auto known = experiment::Experiments();
  for (const std::string& id : ids) {
    if (id == "all" || std::ranges::find(known, id, &Experiment::id) != known.end()) continue;
    throw InputError(fmt::format(
        "experiment \"{}\": there is none of that name; there are {}, and all", id, IdsOf(true)));
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
  const loop::HostFacts host = loop::ReadHostFacts();
  return fmt::format(
      "{} processors ({}{}), {}{}, {}", host.processors, host.processor,
      host.virtual_machine ? ", virtual" : "", host.kernel,
      host.realtime_kernel ? " PREEMPT_RT" : "",
      host.may_use_fifo ? "threads at real-time priority" : "no real-time priority was permitted");
}

experiment::ClientProgram ClientOf(const ExperimentFlags& flags, const Program& program) {
  experiment::ClientProgram client{
      .command = *flags.client, .arm_port = flags.port, .model_library = ModelLibraryOf(program)};
  if (flags.seconds) client.most = FromSeconds(*flags.seconds);
  return client;
}

/// @returns the flags. @throws InputError when a client was given beside other experiments.
const ExperimentFlags& RequireClientAlone(const ExperimentFlags& flags) {
  if (!flags.client) return flags;
  if (flags.client->empty()) throw InputError("--client: give the program's command line");
  if (flags.ids == std::vector<std::string>{"timings"}) return flags;
  throw InputError("--client goes with the experiment timings, and with that alone");
}

/// One report from its flags to its files.
class ExperimentSession {
 public:
  ExperimentSession(const ExperimentFlags& flags, const Program& program)
      : flags_(flags),
        program_(program),
        on_wall_clock_(IsOnWallClock(RequireClientAlone(flags))),
        seeds_(SeedsOf(flags)),
        chosen_(Chosen(flags.ids, on_wall_clock_)),
        data_(DataOf(flags.data, program.host)),
        scenarios_(flags.calibration.value_or(data_.models / "experiments")),
        terminal_(program.log, program.is_quiet()),
        out_(flags.out.value_or(flags.client     ? "out/experiments_client"
                                : on_wall_clock_ ? "out/experiments_realtime"
                                                 : "out/experiments")) {
    calibration_ = experiment::ReadCalibration(scenarios_);
    RequireProgram("gnuplot", program.host.path, "apt-get install gnuplot-nox");
  }

  int Execute();

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
  const Program& program_;
  const bool on_wall_clock_;
  const int seeds_;
  const std::vector<Experiment> chosen_;
  const scenario::DataDirectory data_;
  const fs::path scenarios_;
  experiment::Calibration calibration_;
  Terminal terminal_;
  run::ResultFolder out_;
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
  run::MakeFolder(tables());
}

Findings ExperimentSession::Do(const Experiment& one, const fs::path& scratch) {
  const experiment::Config config{
      .catalogue = program_.catalogue,
      .files = {data_.models, data_.mesh_package, program_.host.cache, false},
      .scenarios = scenarios_,
      .scratch = scratch,
      .seed = flags_.seed.value_or(1),
      .seeds = seeds_,
      .is_calibrated = !flags_.calibration,
      .on_wall_clock = on_wall_clock_,
      .progress = [this, &one](double share) { terminal_.Show(one.id, share, ""); },
      .interrupted = &terminal_.interrupted()};
  try {
    if (flags_.client) return experiment::RunClientStudy(config, ClientOf(flags_, program_));
    return experiment::Run(one, config);
  } catch (const std::exception& failure) {
    terminal_.ThrowIfInterrupted();
    if (flags_.client && dynamic_cast<const EnvironmentError*>(&failure) != nullptr) throw;
    return {.id = std::string(one.id), .title = std::string(one.title), .failure = failure.what()};
  }
}

void ExperimentSession::WriteCsv(const Findings& findings) const {
  for (const experiment::Figure& figure : findings.figures) {
    run::WriteWholeFile(tables() / experiment::CsvName(findings, figure), report::Csv(figure));
  }
}

void ExperimentSession::WritePage() const {
  experiment::PageFacts facts{.seed = flags_.seed.value_or(1),
                              .seeds = seeds_,
                              .calibration = calibration_.hash,
                              .version = TWIN_VERSION};
  if (on_wall_clock_) {
    facts.machine = MachineText();
    if (!flags_.client) {
      facts.left_out = fmt::format(
          "Left out: {}; nothing in them hangs on how a machine keeps time, and the report in "
          "lockstep has them.",
          IdsOf(false));
    }
  }
  for (const std::string& yaml : calibration_.yaml) (facts.parameters += yaml) += '\n';
  run::WriteWholeFile(page(), experiment::Page(findings_, facts));
}

bool ExperimentSession::TellFailures() const {
  bool is_well = true;
  for (const Findings& findings : findings_) {
    if (findings.succeeded()) continue;
    is_well = false;
    std::string text;
    if (!findings.failure.empty()) text = fmt::format("failed: {}\n", findings.failure);
    std::istringstream lines(text + experiment::MissedLines(findings));
    for (std::string line; std::getline(lines, line);) {
      Say(stderr, fmt::format("panda-twin: {}: {}\n", findings.id, line));
    }
  }
  return is_well;
}

int ExperimentSession::Execute() {
  out_.Prepare();
  RequireOurs();
  const run::ScratchFolder scratch(out_.folder() / "scratch.partial");
  for (const Experiment& one : chosen_) {
    const Time begin = clock_.Now();
    findings_.push_back(Do(one, scratch.path()));
    terminal_.ThrowIfInterrupted();
    terminal_.Print(fmt::format("{:<14}{} ({:.1f} s)\n", one.id,
                                experiment::Outcome(findings_.back()),
                                ToSeconds(clock_.Now() - begin)));
  }
  Clear();  // what was there stays until there is something in its place
  for (const Findings& findings : findings_) WriteCsv(findings);
  run::WriteWholeFile(json(), experiment::FindingsJson(findings_, seeds_, calibration_.hash));
  WritePage();
  terminal_.Print(fmt::format("report        {}\n", page().string()));
  return TellFailures() ? kOk : kFailed;
}

int ListExperiments() {
  for (const Experiment& one : experiment::Experiments()) {
    Say(stdout, fmt::format("{:<14}{}\n", one.id, one.title));
  }
  FinishOutput();
  return kOk;
}

int RunExperiments(const ExperimentFlags& flags, const Program& program) {
  if (flags.ids.empty() && !flags.list) throw CLI::RequiredError("experiments or --list");
  if (flags.list) return ListExperiments();
  return ExperimentSession(flags, program).Execute();
}

}  // namespace

void AddExperiment(CLI::App& app, Program& program) {
  const auto [experiment, flags] =
      AddCommand(app, program, "experiment",
                 "Reproduce the paper's tables and figures, as a report", &RunExperiments);
  CLI::Option* ids = Add(experiment, "experiments ID...", flags.ids, "Which (see --list), or all");
  experiment.add_flag("--list", flags.list, "Say which there are")->excludes(ids);
  AddSeed(experiment, flags.seed, "Seed of all random numbers (default: 1)");
  Add(experiment, "--seeds N", flags.seeds, "Runs of what is averaged (default: 20; realtime: 5)");
  Add(experiment, "--drive", flags.drive,
      "lockstep, or realtime: on the wall clock, over UDP against a robot served here")
      ->capture_default_str();
  Add(experiment, "--out DIR", flags.out,
      "Folder of the report (default: out/experiments, or out/experiments_realtime)");
  Add(experiment, "--calibration DIR", flags.calibration,
      "Folder of the experiments' scenarios, instead of models/experiments");
  CLI::Option* client = Add(experiment, "--client \"CMD\"", flags.client,
                            "timings of a program of yours, which finds a robot at 127.0.0.1");
  Add(experiment, "--port", flags.port, "client: TCP port of the arm; the hand's is the next")
      ->capture_default_str()
      ->check(CLI::Range(1, 65534))
      ->needs(client);
  Add(experiment, "--for S", flags.seconds, "client: end it after so long, and report")
      ->check(CLI::Range(0.1, 3600.0))
      ->needs(client);
  AddData(experiment, flags.data);
}

}  // namespace twin::cli
