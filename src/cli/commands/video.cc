#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/commands/commands.h"
#include "cli/shared_flags.h"
#include "cli/terminal.h"
#include "twin/application/record_run.h"
#include "twin/core/error.h"
#include "twin/golden/approval.h"
#include "twin/golden/case_run.h"
#include "twin/golden/comparison.h"
#include "twin/golden/page.h"
#include "twin/record/log_reader.h"
#include "twin/run/result_folder.h"
#include "twin/scenario/video_case.h"

namespace twin::cli {
namespace {

struct VideoFlags {
  std::vector<std::string> cases;  ///< empty: all there are; to approve, at least one
  std::filesystem::path goldens = "tests/golden/cases";
  std::filesystem::path out = "out/video";     ///< of runs and the page
  std::optional<std::filesystem::path> log;    ///< a recorded run instead of a new one; one case
  std::optional<std::filesystem::path> junit;  ///< file for machines
  std::string reason;                          ///< to approve
  DataFlags data;
};

namespace fs = std::filesystem;

/// Makes the file for machines, and removes it, before the work. @throws EnvironmentError.
void TryJunit(const fs::path& file) {
  std::error_code error;
  const fs::path partial = run::PartialOf(file);
  errno = 0;
  std::ofstream probe(partial);
  const int why = probe ? (fs::is_directory(file, error) ? EISDIR : 0) : errno;
  if (probe) fs::remove(partial, error);
  if (why == 0) return;
  throw EnvironmentError(
      fmt::format("--junit: {}: cannot be written ({}); name a file in a folder that exists and "
                  "may be written to",
                  file.string(), std::generic_category().message(why)));
}

constexpr const char* kGoldensFlag = "--goldens names the folder of cases";

/// The names of all cases, sorted.
std::vector<std::string> CasesIn(const fs::path& goldens) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(goldens, error)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  if (error) {
    throw InputError(fmt::format("{}: cannot be read ({}); {}", goldens.string(), error.message(),
                                 kGoldensFlag));
  }
  if (names.empty()) {
    throw InputError(fmt::format("{}: there is no case in it (<name>.yaml); {}", goldens.string(),
                                 kGoldensFlag));
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<scenario::VideoCase> Wanted(const VideoFlags& flags) {
  const std::vector<std::string> all = CasesIn(flags.goldens);
  for (const std::string& name : flags.cases) {
    if (std::find(all.begin(), all.end(), name) != all.end()) continue;
    throw InputError(fmt::format("there is no case {} in {}; there are {}", name,
                                 flags.goldens.string(), fmt::join(all, ", ")));
  }
  std::vector<scenario::VideoCase> cases;
  for (const std::string& name : flags.cases.empty() ? all : flags.cases) {
    cases.push_back(scenario::LoadVideoCase(flags.goldens / (name + ".yaml")));
  }
  if (flags.log && cases.size() != 1) {
    throw InputError("--log goes with one case: name it");
  }
  return cases;
}

std::string RunText(const scenario::VideoCase& wanted, const VideoFlags& flags) {
  if (flags.log) return flags.log->string();
  std::string text = wanted.scenario.string();
  if (wanted.lab) text += fmt::format(", lab {}", *wanted.lab);
  if (wanted.seed) text += fmt::format(", seed {}", *wanted.seed);
  return text;
}

std::string ApproveCommand(const scenario::VideoCase& wanted, const VideoFlags& flags) {
  std::string command = fmt::format("panda-twin video approve {}", wanted.name);
  if (flags.goldens != VideoFlags().goldens) command += " --goldens " + flags.goldens.string();
  if (flags.log) command += " --log " + flags.log->string();
  return command + " --reason \"why they are right\"";
}

/// @throws InputError when the log's run is not the case's, or is to be whole and is not.
void RequireRunOf(const scenario::VideoCase& wanted, const scenario::Scenario& scenario,
                  const fs::path& log, bool whole, const Log& notes) {
  const record::LogReader reader(log);
  if (reader.truncated()) {
    const std::string cut =
        fmt::format("{}: the run was killed, and its last part is missing", log.string());
    if (whole) throw InputError(cut + "; approve the log of a whole run");
    notes->info(cut);
  }
  golden::RequireRunOf(wanted, scenario, reader, log);
}

/// A command while it goes on.
class VideoSession {
 public:
  VideoSession(const VideoFlags& flags, const Program& program)
      : flags_(flags), program_(program), terminal_(program.log, program.is_quiet()) {
    RequireProgram("ffmpeg", program.host.path, "apt-get install ffmpeg");
  }

  /// @param always  a page is written whatever comes of it, and nothing is a failure.
  int Compare(bool always) {
    const std::vector<scenario::VideoCase> cases = Wanted(flags_);
    // A page of what differs has plots; a check may need one.
    RequireProgram("gnuplot", program_.host.path, "apt-get install gnuplot-nox");
    if (flags_.junit) TryJunit(*flags_.junit);
    std::vector<golden::Golden> goldens;
    goldens.reserve(cases.size());
    for (const scenario::VideoCase& wanted : cases) goldens.push_back(ReadGoldenOf(wanted));
    std::vector<golden::CaseResult> results;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      results.push_back(CheckVideo(cases[i], std::move(goldens[i])));
      terminal_.Print(fmt::format("{:<24} {:<6} {}\n", cases[i].name,
                                  results.back().comparison.passed() ? "ok" : "FAILED",
                                  Describe(results.back().comparison, results.back().pictures)));
    }
    return Conclude(results, always);
  }

  int Approve() {
    const std::vector<scenario::VideoCase> cases = Wanted(flags_);
    const golden::GoldensLock lock(flags_.goldens);
    for (const scenario::VideoCase& wanted : cases) golden::RequireNothingElse(FolderOf(wanted));
    for (const scenario::VideoCase& wanted : cases) {
      std::optional<golden::Golden> old;
      if (golden::HasGolden(FolderOf(wanted))) old = golden::ReadGolden(FolderOf(wanted));
      golden::CaseRun run = RunOf(wanted, true);
      run.Take(nullptr, [this] { terminal_.ThrowIfInterrupted(); });
      const golden::Approved approved =
          golden::Approve(old, run.Evidence(), flags_.reason, TWIN_VERSION);
      terminal_.ThrowIfInterrupted();
      if (approved.changed) golden::WriteGolden(FolderOf(wanted), approved.golden);
      terminal_.Print(fmt::format("{:<24} {}\n", wanted.name,
                                  approved.changed
                                      ? "approved: " + approved.golden.approvals.back().changed
                                      : "was approved before; nothing was written"));
    }
    return kOk;
  }

 private:
  [[nodiscard]] fs::path FolderOf(const scenario::VideoCase& wanted) const {
    return flags_.goldens / wanted.name;
  }

  /// Runs the case, unless the flags name a log. A run that fails is taken as it came out: its
  /// pictures tell more. @param whole  a log of a run that was killed will not do.
  [[nodiscard]] golden::CaseRun RunOf(const scenario::VideoCase& wanted, bool whole) const {
    const run::RunFiles files = FilesOf(flags_.data, program_);
    if (files.mesh_package.empty()) {
      throw EnvironmentError(
          "the robot's meshes were not found, and pictures that were approved show them; "
          "scripts/setup fetches them, or name them with --meshes");
    }
    application::RunOptions options{
        .scenario = files.models / wanted.scenario,
        .out = flags_.out / wanted.name,
        .site = wanted.lab ? "lab " + *wanted.lab : "the scenario's own",
        .makes_video = false,
        .makes_plots = false};
    scenario::Scenario scenario = scenario::Load(options.scenario);
    ReplaceSite(wanted.lab, wanted.seed, flags_.data, program_.host, scenario);
    scenario.Validate();
    if (flags_.log) {
      const fs::path log = run::FindLog(*flags_.log);
      RequireRunOf(wanted, scenario, log, whole, program_.log);
      return {wanted, flags_.goldens / (wanted.name + ".yaml"), log, files};
    }
    Terminal quiet(program_.log, true);
    try {
      application::RecordRun({scenario, options, files, program_.catalogue, quiet});
    } catch (const RobotFault& fault) {
      program_.log->info("{}: the run failed: {}", wanted.name, fault.what());
    }
    return {wanted, flags_.goldens / (wanted.name + ".yaml"), options.out / "run.mcap", files};
  }

  [[nodiscard]] golden::Golden ReadGoldenOf(const scenario::VideoCase& wanted) const {
    if (golden::HasGolden(FolderOf(wanted))) return golden::ReadGolden(FolderOf(wanted));
    throw InputError(fmt::format("{}: nothing was approved of this case yet: {}",
                                 FolderOf(wanted).string(), ApproveCommand(wanted, flags_)));
  }

  golden::CaseResult CheckVideo(const scenario::VideoCase& wanted, golden::Golden golden) const {
    golden::CaseRun run = RunOf(wanted, false);
    run.Take(&golden, [this] { terminal_.ThrowIfInterrupted(); });
    golden::CaseResult result{wanted.name, RunText(wanted, flags_), ApproveCommand(wanted, flags_)};
    try {
      result.comparison = golden::Compare(golden, run.Evidence());
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}", FolderOf(wanted).string(), error.what()));
    }
    terminal_.ThrowIfInterrupted();
    result.golden = std::move(golden);
    result.pictures = run.pictures();
    result.joints = run.Joints();
    return result;
  }

  /// Writes what is to be written. @returns kFailed when a check failed.
  int Conclude(const std::vector<golden::CaseResult>& results, bool always) {
    const auto failed = std::count_if(results.begin(), results.end(), [](const auto& result) {
      return !result.comparison.passed();
    });
    if (flags_.junit) run::WriteWholeFile(*flags_.junit, golden::JUnitOf(results));
    const fs::path page = flags_.out / "report.html";
    if (failed > 0 || always) {
      run::MakeFolder(flags_.out);
      run::WriteWholeFile(page, golden::PageOf(results));
      terminal_.Print(fmt::format("report                   {}\n", page.string()));
    } else {
      RemoveStale(page);
    }
    if (failed == 0 || always) return kOk;
    throw RobotFault(fmt::format("{} of {} cases look different from what was approved; see {}",
                                 failed, results.size(), page.string()));
  }

  /// Removes the page of an earlier check, which is out of date.
  static void RemoveStale(const fs::path& page) {
    if (!golden::IsPage(page)) return;
    std::error_code error;
    fs::remove(page, error);
    if (error) {
      throw EnvironmentError(fmt::format("{}: of an earlier check, and cannot be removed ({})",
                                         page.string(), error.message()));
    }
  }

  const VideoFlags& flags_;
  const Program& program_;
  Terminal terminal_;
};

int CheckVideo(const VideoFlags& flags, const Program& program) {
  return VideoSession(flags, program).Compare(false);
}

int Report(const VideoFlags& flags, const Program& program) {
  return VideoSession(flags, program).Compare(true);
}

int Approve(const VideoFlags& flags, const Program& program) {
  return VideoSession(flags, program).Approve();
}

/// The options that all three have, and --junit.
void AddCases(CLI::App& command, VideoFlags& flags, bool has_junit) {
  Add(command, "cases CASE...", flags.cases, "Which (default: all there are)");
  Add(command, "--goldens DIR", flags.goldens, "Folder of cases and of what was approved")
      ->capture_default_str();
  Add(command, "--log FILE|DIR", flags.log, "One case: a recorded run instead of a new one");
  Add(command, "--out DIR", flags.out, "Folder of the runs' results and of report.html")
      ->capture_default_str();
  AddData(command, flags.data);
  if (!has_junit) return;
  Add(command, "--junit FILE", flags.junit, "Write what came of the cases for machines, as XML");
}

}  // namespace

void AddVideo(CLI::App& app, Program& program) {
  CLI::App* video =
      app.add_subcommand("video", "Compare the pictures of runs with those that were approved");
  video->require_subcommand(1);
  const auto [check, check_flags] = AddCommand(
      *video, program, "check", "Compare, and fail when something looks different", &CheckVideo);
  const auto [approve, flags] = AddCommand(*video, program, "approve",
                                           "Keep what the cases look like now as right", &Approve);
  const auto [report, report_flags] = AddCommand(
      *video, program, "report", "Compare, and write the page whatever comes of it", &Report);
  AddCases(check, check_flags, true);
  AddCases(approve, flags, false);
  AddCases(report, report_flags, true);
  approve.get_option("cases")->required()->description("Which");
  Add(approve, "--reason TEXT", flags.reason, "Why they are right; it is kept")->required();
  AddFooter(*video);  // after its commands, which else would repeat it
}

}  // namespace twin::cli
