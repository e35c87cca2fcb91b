#include "twin/experiment/client_study.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiment/client_process.h"
#include "experiment/client_study_figures.h"
#include "experiment/loop_sample.h"
#include "experiment/motion_tally.h"
#include "experiment/runs.h"
#include "experiment/table_one.h"
#include "experiment/wire_times.h"
#include "twin/core/clock.h"
#include "twin/experiment/calibration.h"
#include "twin/fci/capture.h"
#include "twin/robot/make_plant.h"
#include "twin/rt/sleep.h"
#include "twin/run/remote.h"
#include "twin/run/run.h"
#include "twin/server/served_robot.h"

namespace twin::experiment {
namespace {

/// What was seen of the client from outside.
struct Observation {
  MotionTally tally;
  std::string how_it_ended;
  bool was_ended = false;      ///< by us, after ClientProgram::most
  std::uint64_t overruns = 0;  ///< of the robot's own thread
};

/// Serves, runs the client, and waits for its end. @param capture  where the wire is kept.
void Observe(const Setting& setting, const ClientProgram& program,
             const std::filesystem::path& capture, Observation& seen) {
  fci::Capture kept(capture);
  {
    server::ServedRobotSettings settings;
    settings.server.arm_port = program.arm_port;
    settings.server.hand_port = static_cast<std::uint16_t>(program.arm_port + 1);
    settings.server.model_library = program.model_library;
    settings.server.capture = &kept;
    settings.sink = &seen.tally;
    const robot::RobotConfig config = run::MakeServedConfig(run::DefaultServed(), setting.files);
    server::ServedRobot robot(config, robot::MakePlant(config), std::move(settings));
    robot.Start();
    const MonotonicClock clock;
    constexpr Duration kLook = std::chrono::milliseconds(20);
    ClientProcess client(program.command);
    const Time begin = clock.Now();
    while (!client.HasEnded()) {
      ThrowIfInterrupted(setting);
      if (program.most && clock.Now() >= begin + *program.most) {
        client.End();
        seen.was_ended = true;
        break;
      }
      rt::SleepUntil(clock, clock.Now() + kLook);
    }
    seen.how_it_ended = client.HowItEnded();
    // What it left moving comes to rest, and what it sent last has arrived.
    rt::SleepUntil(clock, clock.Now() + 10 * kLook);
    robot.End();
    seen.overruns = robot.overruns();
  }
  static_cast<void>(kept.Finish());
}

/// d_EXT of commands within motions, us, rising.
std::vector<double> LatenciesOf(const std::vector<Answer>& answers, const MotionTally& tally) {
  std::vector<double> latencies;
  for (const Answer& answer : answers) {
    if (tally.IsInMotion(answer.message_id)) {
      latencies.push_back(1e6 * (answer.received_s - answer.sent_s));
    }
  }
  std::ranges::sort(latencies);
  return latencies;
}

void AddAll(const MotionTally& tally, const std::vector<double>& latencies,
            std::vector<Comparison>& out) {
  const LoopSample sample{.d_EXT_us = latencies,
                          .interval_us = {},
                          .unserved_percent = tally.counts().unserved_percent(),
                          .longest_loss = tally.counts().longest_loss};
  for (const TableRow& row : kTableOne) {
    const bool is_unserved = &row == &kTableOne[kUnserved];
    if (latencies.empty() && !is_unserved) continue;
    out.push_back(
        {.quantity = is_unserved ? std::string(row.name) : fmt::format("{}, on the wire", row.name),
         .unit = row.unit,
         .ours = row.of(sample)});
    if (is_unserved) out.back().paper = row.paper[0];
  }
  out.push_back(
      {.quantity = "commands that these are of", .ours = static_cast<double>(latencies.size())});
  out.push_back({.quantity = "states of a motion that were never answered",
                 .ours = static_cast<double>(tally.counts().cycles() - latencies.size())});
  const auto longest = static_cast<double>(sample.longest_loss);
  out.push_back({.quantity = "most unserved in a row", .unit = "cycles", .ours = longest});
  out.push_back(
      {.quantity = fmt::format("margin to the {} that end a motion", MotionTally::EndsTheMotion()),
       .unit = "cycles",
       .ours = std::max(0.0, MotionTally::EndsTheMotion() - longest)});
  out.push_back({.quantity = "commands that came late, twice or for no state",
                 .ours = static_cast<double>(tally.counts().dropped)});
}

void AddEach(const MotionTally& tally, std::vector<Comparison>& out) {
  int number = 0;
  for (const TalliedMotion& motion : tally.motions()) {
    ++number;
    out.push_back(
        {.quantity = fmt::format("motion {}, {:.3f} s{}: unserved cycles", number,
                                 static_cast<double>(motion.counts.cycles()) * kCycleSeconds,
                                 motion.HowItEnded()),
         .unit = "%",
         .ours = motion.counts.unserved_percent()});
    out.push_back({.quantity = fmt::format("motion {}: most unserved in a row", number),
                   .unit = "cycles",
                   .ours = static_cast<double>(motion.counts.longest_loss)});
  }
}

/// What must hold of any program: it ends well, and so do its motions.
void AddEnd(const Observation& seen, std::vector<Comparison>& out) {
  const auto aborted = std::ranges::count_if(
      seen.tally.motions(), [](const TalliedMotion& motion) { return motion.errors.any(); });
  out.push_back({.quantity = "motions that an error of the robot ended",
                 .ours = static_cast<double>(aborted),
                 .demand = "none",
                 .verdict = Judge(aborted == 0)});
  if (seen.was_ended) return;
  const bool well = seen.how_it_ended == "exit code 0";
  out.push_back({.quantity = fmt::format("the program ended well ({})", seen.how_it_ended),
                 .ours = well ? 1.0 : 0.0,
                 .demand = "exit code 0",
                 .verdict = Judge(well)});
}

std::map<std::string, std::string> ValuesOf(const ClientProgram& program, const Observation& seen) {
  return {{"command", program.command},
          {"port", fmt::format("{}", program.arm_port)},
          {"end", seen.how_it_ended},
          {"motions", fmt::format("{}", seen.tally.motions().size())},
          {"most", fmt::format("{}", MotionTally::EndsTheMotion())},
          {"overruns", seen.overruns > 0 ? fmt::format("{}", seen.overruns) : std::string()},
          {"full", seen.tally.is_full() ? "yes" : ""}};
}

}  // namespace

Findings RunClientStudy(const Setting& setting, const ClientProgram& program) {
  Observation seen;
  const std::filesystem::path capture = setting.scratch / "client.pcapng";
  Observe(setting, program, capture, seen);
  Findings findings{.id = "client",
                    .title = "Timings of a program of your own",
                    .source = "As Section 2, Table 1",
                    .page = "client",
                    .values = ValuesOf(program, seen)};
  if (seen.tally.motions().empty()) {
    findings.failure = fmt::format(
        "the client ended with {} and without a motion that got a command; it must connect to "
        "127.0.0.1, port {}",
        seen.how_it_ended, program.arm_port);
    return findings;
  }
  const std::vector<Answer> answers = AnswersOf(capture);
  const std::vector<double> latencies = LatenciesOf(answers, seen.tally);
  AddAll(seen.tally, latencies, findings.comparisons);
  AddEach(seen.tally, findings.comparisons);
  AddEnd(seen, findings.comparisons);
  if (!latencies.empty()) findings.figures.push_back(ClientLatencyFigure(latencies));
  findings.figures.push_back(ClientLossesFigure(seen.tally));
  return findings;
}

}  // namespace twin::experiment
