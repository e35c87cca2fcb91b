#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/commands/commands.h"
#include "cli/python_package.h"
#include "cli/shared_flags.h"
#include "cli/sweep_jobs.h"
#include "cli/terminal.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/sweep/merge.h"
#include "twin/sweep/points.h"
#include "twin/sweep/result.h"
#include "twin/sweep/shard.h"

namespace twin::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostRuns = 1'000'000;  ///< without --yes

struct SweepFlags {
  fs::path file;
  fs::path out;             ///< a folder, or an address of an object store; empty: out/<its name>
  std::optional<int> jobs;  ///< processes; as many as processors
  std::optional<std::string> shard;
  std::optional<std::uint64_t> shards;  ///< of an engine's tasks
  std::string engine;                   ///< "ray", "ray://HOST:PORT"; empty: this machine
  bool parquet = false;                 ///< also runs.parquet
  bool yes = false;                     ///< carry out more than 10^6 runs
  DataFlags data;

  /// Whether results are in an object store.
  [[nodiscard]] bool are_stored() const { return out.string().find("://") != std::string::npos; }
};

/// A command on a sweep's file.
struct SweepOf {
  SweepOf(const SweepFlags& flags, const Program& program)
      : files(FilesOf(flags.data, program)),
        file(scenario::FindScenario(flags.file, files.models)),
        sweep(file, files.models),
        out(flags.out.empty() ? fs::path("out") / sweep.file().name : flags.out) {}

  run::RunFiles files;
  fs::path file;
  sweep::Sweep sweep;
  fs::path out;
};

/// "3 h 20 min", "12 s".
std::string SpanText(double seconds) {
  if (seconds < 90) return fmt::format("{:.3g} s", seconds);
  const double minutes = seconds / 60;
  if (minutes < 90) return fmt::format("{:.0f} min", minutes);
  return minutes < 48 * 60 ? fmt::format("{:.1f} h", minutes / 60)
                           : fmt::format("{:.1f} days", minutes / 60 / 24);
}

/// Wall-clock time of the first run, once the model is compiled, s.
double MeasureRun(const SweepOf& of, const Program& program) {
  sweep::CaseMaker maker(of.sweep, of.files);
  const sweep::PreparedCase& first = maker.Make(0);
  static_cast<void>(sweep::RunCase(first, program.catalogue, of.files, nullptr));
  const MonotonicClock clock;
  static_cast<void>(sweep::RunCase(first, program.catalogue, of.files, nullptr));
  return ToSeconds(clock.Now().time_since_epoch());
}

/// What all runs cost, by the first.
std::string CostText(const SweepOf& of, const Program& program) {
  const double one = MeasureRun(of, program);
  return fmt::format("{:.3g} s a run on one core, as the first point's took: {} in all", one,
                     SpanText(one * static_cast<double>(of.sweep.runs())));
}

std::string DescribeAxis(const scenario::SweepAxis& axis) {
  if (axis.draw) {
    return fmt::format("{} {} {}, {} {}, drawn for each run",
                       axis.draw->is_normal ? "normal" : "uniform", axis.draw->first.value,
                       axis.draw->first.unit, axis.draw->second.value, axis.draw->second.unit);
  }
  if (!axis.range)
    return fmt::format("{} values: {}", axis.values.size(),
                       fmt::join(axis.names.empty() ? axis.values : axis.names, ", "));
  const std::string scale = axis.range->is_logarithmic ? "logarithmic" : "linear";
  const std::string ends = fmt::format("{} to {} {}", axis.range->from.value, axis.range->to.value,
                                       axis.range->from.unit);
  return axis.range->steps > 0 ? fmt::format("{} values: {}, {}", axis.range->steps, ends, scale)
                               : fmt::format("sampled: {}, {}", ends, scale);
}

int PlanSweep(const SweepFlags& flags, const Program& program) {
  const SweepOf of(flags, program);
  of.sweep.CheckPoints();
  Terminal terminal(program.log, program.is_quiet());
  const scenario::SweepFile& file = of.sweep.file();
  for (const scenario::SweepAxis& axis : file.axes) {
    terminal.Print(fmt::format("{:<32}  {}\n", axis.key, DescribeAxis(axis)));
  }
  terminal.Print(fmt::format("points  {}\nruns    {} ({} seeds of each point{})\n",
                             of.sweep.points(), of.sweep.runs(), file.seeds,
                             file.stop_at_width ? ", fewer where a point ends early" : ""));
  terminal.Print(fmt::format("cost    {}\n", CostText(of, program)));
  return kOk;
}

/// @throws InputError when there are more runs than anyone starts by mistake.
void RequireFew(const SweepFlags& flags, const SweepOf& of, const Program& program) {
  if (flags.yes || of.sweep.runs() <= kMostRuns) return;
  throw InputError(fmt::format("{}: {} runs; {}; more than {} take --yes", of.file.string(),
                               of.sweep.runs(), CostText(of, program), kMostRuns));
}

int JobsOf(const SweepFlags& flags) {
  constexpr int kMostJobs = 256;
  const int processors = static_cast<int>(std::thread::hardware_concurrency());
  const int jobs = flags.jobs.value_or(std::clamp(processors, 1, kMostJobs));
  RequireInRange("--jobs", jobs, 1, kMostJobs);
  return jobs;
}

/// The command line of a worker, without its shard.
std::vector<std::string> WorkerArguments(const SweepFlags& flags, const SweepOf& of) {
  std::vector<std::string> words{"sweep", "work",          flags.file.string(),
                                 "--out", of.out.string(), "-q"};
  AddFlag("--data", flags.data.models.string(), words);
  AddFlag("--meshes", flags.data.meshes.string(), words);
  return words;
}

/// Hands a command over to the Python package, which knows engines, object stores and Parquet.
[[noreturn]] void LeaveToPython(const char* command, const SweepFlags& flags,
                                const Program& program) {
  const auto text = [](const auto& number) { return number ? fmt::format("{}", *number) : ""; };
  std::vector<std::string> words{command, flags.file.string()};
  AddFlag("--out", flags.out.string(), words);
  AddFlag("--on", flags.engine, words);
  AddFlag("--shard", flags.shard.value_or(""), words);
  AddFlag("--shards", text(flags.shards), words);
  AddFlag("--jobs", text(flags.jobs), words);
  AddFlag("--data", flags.data.models.string(), words);
  AddFlag("--meshes", flags.data.meshes.string(), words);
  if (flags.yes) words.emplace_back("--yes");
  if (program.is_quiet()) words.emplace_back("--quiet");
  BecomePython("sweep.__main__", words, program.host);
}

int RunSweep(const SweepFlags& flags, const Program& program) {
  RefuseIf(flags.engine.empty() && flags.shards, "--shards is for --on");
  RefuseIf(!flags.engine.empty() && (flags.shard || flags.jobs),
           "--on shares the runs out itself: leave --shard and --jobs out");
  if (!flags.engine.empty() || flags.are_stored()) LeaveToPython("run", flags, program);
  const SweepOf of(flags, program);
  const sweep::Shard shard = sweep::ParseShard(flags.shard.value_or("0/1"));
  const int jobs = JobsOf(flags);
  RequireFew(flags, of, program);
  of.sweep.CheckPoints();
  Terminal terminal(program.log, program.is_quiet());
  const std::uint64_t runs = sweep::RunsOf(of.sweep, shard);
  if (jobs > 1 && runs > 1) {
    RunJobs(
        {.executable = program.host.executable,
         .arguments = WorkerArguments(flags, of),
         .jobs = static_cast<int>(std::min<std::uint64_t>(static_cast<std::uint64_t>(jobs), runs)),
         .shard = shard,
         .runs = runs},
        terminal);
  } else {
    SweepProgress progress(runs, terminal);
    sweep::RunShard(of.sweep, shard,
                    {.catalogue = program.catalogue,
                     .files = of.files,
                     .out = of.out,
                     .done = [&progress](bool was_there) { progress.Add(1, was_there); },
                     .interrupted = &terminal.interrupted()});
    terminal.ThrowIfInterrupted();
  }
  terminal.Print(fmt::format("results  {}\n", (of.out / "runs").string()));
  return kOk;
}

/// A process of `sweep run`: it tells each run on kDoneDescriptor, and ends when nobody reads.
int WorkSweep(const SweepFlags& flags, const Program& program) {
  const SweepOf of(flags, program);
  Terminal terminal(program.log, true);
  sweep::RunShard(of.sweep, sweep::ParseShard(flags.shard.value_or("0/1")),
                  {.catalogue = program.catalogue,
                   .files = of.files,
                   .out = of.out,
                   .done =
                       [&terminal](bool was_there) {
                         const char byte = was_there ? 't' : 'd';
                         if (::write(kDoneDescriptor, &byte, 1) != 1) terminal.Interrupt();
                       },
                   .interrupted = &terminal.interrupted()});
  terminal.ThrowIfInterrupted();
  return kOk;
}

/// For the Python package: the usual folder of results; then of each run what is shared out
/// (Shard), the run or its point, and the address of its result.
int PrintAddresses(const SweepFlags& flags, const Program& program) {
  const SweepOf of(flags, program);
  RequireFew(flags, of, program);
  of.sweep.CheckPoints();
  Say(stdout, of.out.string() + "\n");
  sweep::CaseMaker maker(of.sweep, of.files);
  for (std::uint64_t run = 0; run < of.sweep.runs(); ++run) {
    const sweep::Case one = of.sweep.CaseAt(run);
    Say(stdout, fmt::format("{} {}\n", of.sweep.file().stop_at_width ? one.point : run,
                            maker.AddressOf(one)));
  }
  FinishOutput();
  return kOk;
}

int MergeSweep(const SweepFlags& flags, const Program& program) {
  if (flags.parquet || flags.are_stored()) LeaveToPython("merge", flags, program);
  const SweepOf of(flags, program);
  Terminal terminal(program.log, program.is_quiet());
  const sweep::Merged merged = sweep::Merge(of.sweep, of.files, of.out);
  if (merged.left_aside.count() > 0) {
    terminal.Note("results left aside: " + merged.left_aside.Text());
  }
  terminal.Print(fmt::format("runs    {}, {} failed ({:.2f} % succeeded)\nreport  {}\n",
                             merged.runs, merged.failures, merged.success_percent(),
                             (of.out / "report.html").string()));
  terminal.Print(fmt::format("digest  {}\n", merged.digest));
  const auto& least = of.sweep.file().least_success_percent;
  if (least && merged.success_percent() < *least) {
    throw Error(fmt::format("{:.2f} % of the runs succeeded; {} % are demanded",
                            merged.success_percent(), *least));
  }
  return kOk;
}

/// A script for bash that hands a sweep to Slurm. The file, the folder and the program must be
/// there on each node, at the same place.
int PrintSlurmScript(const SweepFlags& flags, const Program& program) {
  const SweepOf of(flags, program);
  const std::uint64_t shards = flags.shards.value_or(0);
  RequireInRange("--shards", static_cast<double>(shards), 1, 100'000);
  of.sweep.CheckPoints();
  const std::string name = "sweep-" + of.sweep.file().name;
  const auto here = [](const fs::path& path) { return fs::absolute(path).lexically_normal(); };
  const std::string out = flags.are_stored() ? of.out.string() : here(of.out).string();
  const auto command = [&](std::string_view what) {
    return fmt::format("{} sweep {} {} --out {}{}", InShell(program.host.executable.string()), what,
                       InShell(here(of.file).string()), InShell(out), DataInShell(flags.data));
  };
  const std::string shard =
      fmt::format("{} --jobs 1 --shard \"$SLURM_ARRAY_TASK_ID\"/{}", command("run"), shards);
  const std::string log =
      InShell((flags.are_stored() ? here("out") / of.sweep.file().name : fs::path(out)) / "slurm");
  Say(stdout,
      fmt::format(fmt::runtime(TextOf("sweep_slurm.sh")), fmt::arg("name", name),
                  fmt::arg("last", shards - 1), fmt::arg("log", log),
                  fmt::arg("shard", InShell(shard)), fmt::arg("merge", InShell(command("merge")))));
  FinishOutput();
  return kOk;
}

void AddFile(CLI::App& command, SweepFlags& flags) {
  Add(command, "sweep FILE", flags.file,
      "Sweep file, or one of the installed models: sweeps/losses.yaml")
      ->required();
  AddData(command, flags.data);
}

void AddOut(CLI::App& command, SweepFlags& flags) {
  Add(command, "--out DIR|URI", flags.out,
      "Folder of results, or s3://BUCKET/PATH (default: out/<name of the sweep>)");
}

}  // namespace

void AddSweep(CLI::App& app, Program& program) {
  CLI::App* sweep =
      app.add_subcommand("sweep", "Run a scenario at many points and seeds, and count failures");
  sweep->require_subcommand(1);
  const auto [plan, plan_flags] = AddCommand(
      *sweep, program, "plan", "Say how many runs there are and what they cost", &PlanSweep);
  AddFile(plan, plan_flags);
  const auto [run, flags] = AddCommand(
      *sweep, program, "run", "Carry out the runs whose results are not there yet", &RunSweep);
  AddFile(run, flags);
  AddOut(run, flags);
  Add(run, "--jobs N", flags.jobs, "So many processes (default: one per processor)");
  Add(run, "--shard I/N", flags.shard, "This share of the runs only; I counts from 0");
  Add(run, "--on ray[://HOST:PORT]", flags.engine, "Run it on a Ray cluster, as tasks");
  Add(run, "--shards N", flags.shards, "So many tasks (default: of at most 64 runs each)");
  run.add_flag("--yes", flags.yes, "Carry out more than a million runs");
  const auto [work, work_flags] = AddCommand(*sweep, program, "work", "", &WorkSweep);
  work.group("");  // of `run` alone, not in the help
  AddFile(work, work_flags);
  AddOut(work, work_flags);
  Add(work, "--shard I/N", work_flags.shard, "");
  const auto [merge, merge_flags] =
      AddCommand(*sweep, program, "merge", "Check that all results are there, and write the report",
                 &MergeSweep);
  AddFile(merge, merge_flags);
  AddOut(merge, merge_flags);
  merge.add_flag("--parquet", merge_flags.parquet, "Also write runs.parquet");
  const auto [addresses, addresses_flags] =
      AddCommand(*sweep, program, "addresses", "", &PrintAddresses);
  addresses.group("");  // of the Python package, not in the help
  AddFile(addresses, addresses_flags);
  addresses.add_flag("--yes", addresses_flags.yes, "");
  const auto [slurm, slurm_flags] = AddCommand(
      *sweep, program, "slurm", "Print a script that hands the sweep to Slurm", &PrintSlurmScript);
  AddFile(slurm, slurm_flags);
  AddOut(slurm, slurm_flags);
  Add(slurm, "--shards N", slurm_flags.shards, "So many tasks of one array job")->required();
  AddFooter(*sweep);  // after its commands, which else would repeat it
}

}  // namespace twin::cli
