#include "cli/video_command.h"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <fstream>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/host.h"
#include "cli/interrupt.h"
#include "cli/result_folder.h"
#include "cli/say.h"
#include "cli/video_case_run.h"
#include "twin/core/error.h"
#include "twin/golden/approval.h"
#include "twin/golden/comparison.h"
#include "twin/golden/goldens_lock.h"
#include "twin/golden/page.h"

namespace twin::cli {
namespace {

namespace fs = std::filesystem;

/// Makes the file for machines, and removes it, before the work. @throws EnvironmentError.
void TryJunit(const fs::path& file) {
  std::error_code error;
  const fs::path partial = PartialOf(file);
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

/// A command while it goes on.
class VideoSession {
 public:
  VideoSession(const VideoFlags& flags, const Host& host, const run::Catalogue& catalogue)
      : flags_(flags), host_(host), catalogue_(catalogue) {
    RequireProgram("ffmpeg", host.path, "apt-get install ffmpeg");
  }

  ExitCode Compare() {
    const std::vector<scenario::VideoCase> cases = Wanted(flags_);
    if (flags_.junit) TryJunit(*flags_.junit);
    std::vector<golden::Golden> goldens;
    goldens.reserve(cases.size());
    for (const scenario::VideoCase& wanted : cases) goldens.push_back(ReadGoldenOf(wanted));
    std::vector<golden::CaseResult> results;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      results.push_back(Check(cases[i], std::move(goldens[i])));
      Tell(fmt::format("{:<24} {:<6} {}\n", cases[i].name,
                       results.back().comparison.passed() ? "ok" : "FAILED",
                       Describe(results.back().comparison, results.back().pictures)));
    }
    return Conclude(results);
  }

  ExitCode Approve() {
    const std::vector<scenario::VideoCase> cases = Wanted(flags_);
    const golden::GoldensLock lock(flags_.goldens);
    for (const scenario::VideoCase& wanted : cases) golden::RequireNothingElse(FolderOf(wanted));
    for (const scenario::VideoCase& wanted : cases) {
      std::optional<golden::Golden> old;
      if (golden::HasGolden(FolderOf(wanted))) old = golden::ReadGolden(FolderOf(wanted));
      VideoCaseRun run(wanted, flags_, host_, catalogue_);
      run.Take(nullptr, interrupt_);
      const golden::Approved approved =
          golden::Approve(old, run.Evidence(), flags_.reason, TWIN_VERSION);
      interrupt_.ThrowIfInterrupted();
      if (approved.changed) golden::WriteGolden(FolderOf(wanted), approved.golden);
      Tell(fmt::format("{:<24} {}\n", wanted.name,
                       approved.changed ? "approved: " + approved.golden.approvals.back().changed
                                        : "was approved before; nothing was written"));
    }
    return kOk;
  }

 private:
  [[nodiscard]] fs::path FolderOf(const scenario::VideoCase& wanted) const {
    return flags_.goldens / wanted.name;
  }

  [[nodiscard]] golden::Golden ReadGoldenOf(const scenario::VideoCase& wanted) const {
    if (golden::HasGolden(FolderOf(wanted))) return golden::ReadGolden(FolderOf(wanted));
    throw InputError(fmt::format("{}: nothing was approved of this case yet: {}",
                                 FolderOf(wanted).string(), ApproveCommand(wanted, flags_)));
  }

  golden::CaseResult Check(const scenario::VideoCase& wanted, golden::Golden golden) const {
    VideoCaseRun run(wanted, flags_, host_, catalogue_);
    run.Take(&golden, interrupt_);
    golden::CaseResult result{wanted.name, RunText(wanted, flags_), ApproveCommand(wanted, flags_)};
    try {
      result.comparison = golden::Compare(golden, run.Evidence());
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}", FolderOf(wanted).string(), error.what()));
    }
    interrupt_.ThrowIfInterrupted();
    result.golden = std::move(golden);
    result.pictures = run.pictures();
    result.joints = run.Joints();
    return result;
  }

  /// Writes what is to be written. @returns kFailed when a check failed.
  ExitCode Conclude(const std::vector<golden::CaseResult>& results) const {
    const auto failed = std::count_if(results.begin(), results.end(), [](const auto& result) {
      return !result.comparison.passed();
    });
    if (flags_.junit) WriteWholeFile(*flags_.junit, golden::JUnitOf(results));
    const fs::path page = flags_.out / "report.html";
    if (failed > 0 || flags_.deed == VideoDeed::kReport) {
      MakeFolder(flags_.out);
      WriteWholeFile(page, golden::PageOf(results));
      Tell(fmt::format("report                   {}\n", page.string()));
    } else {
      RemoveStale(page);
    }
    if (failed == 0 || flags_.deed == VideoDeed::kReport) return kOk;
    throw RobotFault(fmt::format("{} of {} cases look different from what was approved; see {}",
                                 failed, results.size(), page.string()));
  }

  /// An earlier check's page tells of what is no more.
  static void RemoveStale(const fs::path& page) {
    if (!golden::IsPage(page)) return;
    std::error_code error;
    fs::remove(page, error);
    if (error) {
      throw EnvironmentError(fmt::format("{}: of an earlier check, and cannot be removed ({})",
                                         page.string(), error.message()));
    }
  }

  void Tell(const std::string& line) const {
    if (flags_.quiet) return;
    Say(stdout, line);
    std::fflush(stdout);
  }

  const VideoFlags& flags_;
  const Host& host_;
  const run::Catalogue& catalogue_;
  const InterruptGuard interrupt_;
};

}  // namespace

ExitCode VideoCommand(const VideoFlags& flags, const Host& host,
                      const run::Catalogue& catalogue) {
  VideoSession session(flags, host, catalogue);
  return flags.deed == VideoDeed::kApprove ? session.Approve() : session.Compare();
}

}  // namespace twin::cli
