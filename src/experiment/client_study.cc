#include "experiment/client_study.h"

#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <system_error>

#include <fmt/format.h>

#include "experiment/loop_runs.h"
#include "experiment/runs.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/core/robot_state.h"
#include "twin/fci/capture.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/protocol.h"
#include "twin/onboard/onboard_config.h"
#include "twin/record/pcapng_reader.h"
#include "twin/robot/robot_config.h"
#include "twin/rt/host_time.h"
#include "twin/run/remote.h"
#include "twin/server/served_robot.h"

namespace twin::experiment {
namespace {

/// Measurements of the client from outside.
struct Observation {
  MotionTally tally;
  std::string how_it_ended;
  bool was_ended = false;      ///< by this study, after ClientProgram::most
  std::uint64_t overruns = 0;  ///< of the robot's own thread
};

/// Serves, runs the client, and waits for its end. @param capture  file for the wire's datagrams.
void Observe(const Config& config, const ClientProgram& program,
             const std::filesystem::path& capture, Observation& seen) {
  fci::Capture kept(capture);
  {
    server::ServedRobotSettings settings;
    settings.server.arm_port = program.arm_port;
    settings.server.hand_port = static_cast<std::uint16_t>(program.arm_port + 1);
    settings.server.model_library = program.model_library;
    settings.server.capture = &kept;
    settings.sink = &seen.tally;
    const robot::RobotConfig served = run::MakeServedConfig(run::DefaultServed(), config.files);
    server::ServedRobot robot(served, robot::MakePlant(served), std::move(settings));
    robot.Start();
    const MonotonicClock clock;
    constexpr Duration kPollPeriod = std::chrono::milliseconds(20);
    ClientProcess client(program.command);
    const Time begin = clock.Now();
    while (!client.HasEnded()) {
      ThrowIfInterrupted(config);
      if (program.most && clock.Now() >= begin + *program.most) {
        client.End();
        seen.was_ended = true;
        break;
      }
      rt::SleepUntil(clock, clock.Now() + kPollPeriod);
    }
    seen.how_it_ended = client.HowItEnded();
    // The robot comes to rest, and the last datagrams arrive.
    rt::SleepUntil(clock, clock.Now() + 10 * kPollPeriod);
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

void AddAll(const MotionTally& tally, const std::vector<double>& latencies, Findings& findings) {
  const run::CycleCounts& counts = tally.counts();
  const LoopSample sample{.d_EXT_us = latencies, .interval_us = {}, .counts = counts};
  for (const TableRow& row : kTableOne) {
    if (&row == &kTableOne[kUnserved]) {
      findings.Add(row.name, row.unit, row.of(sample)).Paper(row.paper[kBare]);
    } else if (!latencies.empty()) {
      findings.Add(fmt::format("{}, on the wire", row.name), row.unit, row.of(sample));
    }
  }
  findings.Add("commands that these are of", "", latencies.size());
  findings.Add("states of a motion that were never answered", "",
               counts.cycles() - latencies.size());
  const auto longest = static_cast<double>(counts.longest_loss);
  findings.Add("most unserved in a row", "cycles", longest);
  findings.Add(fmt::format("margin to the {} that end a motion", MotionTally::EndsTheMotion()),
               "cycles", std::max(0.0, MotionTally::EndsTheMotion() - longest));
  findings.Add("commands that came late, twice or for no state", "", counts.dropped);
}

void AddEach(const MotionTally& tally, Findings& findings) {
  int number = 0;
  for (const TalliedMotion& motion : tally.motions()) {
    ++number;
    findings.Add(fmt::format("motion {}, {:.3f} s{}: unserved cycles", number,
                             static_cast<double>(motion.counts.cycles()) * kCycleSeconds,
                             motion.HowItEnded()),
                 "%", motion.counts.unserved_percent());
    findings.Add(fmt::format("motion {}: most unserved in a row", number), "cycles",
                 motion.counts.longest_loss);
  }
}

/// Demands on any program: it ends well, and so do its motions.
void AddEnd(const Observation& seen, Findings& findings) {
  const auto aborted = std::ranges::count_if(
      seen.tally.motions(), [](const TalliedMotion& motion) { return motion.errors.any(); });
  findings.Add("motions that an error of the robot ended", "", aborted)
      .Demand("none", aborted == 0);
  if (seen.was_ended) return;
  const bool well = seen.how_it_ended == "exit code 0";
  findings.Add(fmt::format("the program ended well ({})", seen.how_it_ended), "", well ? 1.0 : 0.0)
      .Demand("exit code 0", well);
}

std::map<std::string, std::string> ClientValues(const ClientProgram& program,
                                                const Observation& seen) {
  return {{"command", program.command},
          {"port", fmt::format("{}", program.arm_port)},
          {"end", seen.how_it_ended},
          {"motions", fmt::format("{}", seen.tally.motions().size())},
          {"most", fmt::format("{}", MotionTally::EndsTheMotion())},
          {"overruns", seen.overruns > 0 ? fmt::format("{}", seen.overruns) : std::string()},
          {"full", seen.tally.is_full() ? "yes" : ""}};
}

/// Distribution of d_EXT on the wire.
Figure ClientLatencyFigure(const std::vector<double>& latencies_us) {
  const std::vector<double> edges = LogEdges(1, 4000, 40);
  return FigureOf("wire", {{"d_EXT on the wire [us]", edges},
                           {"in bin [%]", Percent(Histogram(latencies_us, edges))},
                           {"longer [1]", Exceedance(latencies_us, edges)}});
}

/// Successive unserved cycles over the motions' time, beside the number that ends a motion.
Figure ClientLossesFigure(const MotionTally& tally) {
  constexpr std::size_t kMostPoints = 4000;
  Figure figure{.id = "losses",
                .columns = "t [s],unserved in a row [1]",
                .values = {{"most", MotionTally::EndsTheMotion()}}};
  const std::vector<std::uint8_t>& lost = tally.lost_in_row();
  const std::size_t step = lost.size() / kMostPoints + 1;
  for (std::size_t k = 0; k < lost.size(); k += step) {
    const auto end = lost.begin() + static_cast<std::ptrdiff_t>(std::min(k + step, lost.size()));
    const double most = *std::max_element(lost.begin() + static_cast<std::ptrdiff_t>(k), end);
    figure.rows.push_back({static_cast<double>(k) * kCycleSeconds, most});
  }
  return figure;
}

}  // namespace

ClientProcess::ClientProcess(const std::string& command) try
    : process_("/bin/sh", {"-c", command},
               {.in = STDIN_FILENO, .out = STDOUT_FILENO, .error = STDERR_FILENO}) {
  GiveTerminalTo(process_.pid());
} catch (const std::system_error& error) {
  throw EnvironmentError(
      fmt::format("cannot start /bin/sh for the client: {}", error.code().message()));
}

ClientProcess::~ClientProcess() {
  End();
}

void ClientProcess::GiveTerminalTo(pid_t group) {
  if (::isatty(STDIN_FILENO) == 0) return;
  // A background process that asks for the foreground would get SIGTTOU and stop.
  sigset_t output;
  sigset_t before;
  ::sigemptyset(&output);
  ::sigaddset(&output, SIGTTOU);
  ::pthread_sigmask(SIG_BLOCK, &output, &before);
  ::tcsetpgrp(STDIN_FILENO, group);
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void ClientProcess::End() {
  if (HasEnded()) return;
  constexpr int kLooks = 100;
  ::kill(-process_.pid(), SIGTERM);
  for (int look = 0; look < kLooks && !HasEnded(); ++look) ::usleep(10'000);
  if (HasEnded()) return;
  ::kill(-process_.pid(), SIGKILL);
  while (!HasEnded()) ::usleep(1'000);
}

bool ClientProcess::HasEnded() {
  if (status_) return true;
  status_ = process_.Poll();
  if (status_) GiveTerminalTo(::getpgrp());
  return status_.has_value();
}

std::string ClientProcess::HowItEnded() const {
  if (WIFSIGNALED(*status_)) return fmt::format("signal {}", WTERMSIG(*status_));
  return fmt::format("exit code {}", WEXITSTATUS(*status_));
}

std::string TalliedMotion::HowItEnded() const {
  return errors.none() ? std::string() : fmt::format(", aborted by {}", FormatErrors(errors));
}

std::uint32_t MotionTally::EndsTheMotion() noexcept {
  return onboard::OnboardConfig().abort_after_lost;
}

MotionTally::MotionTally() {
  motions_.reserve(kMotions);
  lost_in_row_.reserve(kCycles);
}

void MotionTally::Put(const record::CycleRecord& record) noexcept {
  if (record.fate == record::CommandFate::kNone) {
    if (in_motion_ && record.state.robot_mode == RobotMode::kReflex) {
      motions_.back().errors = record.state.reflex_reason;
    }
    in_motion_ = false;
    return;
  }
  is_full_ =
      is_full_ || lost_in_row_.size() == kCycles || (!in_motion_ && motions_.size() == kMotions);
  if (is_full_) return;
  if (!in_motion_) motions_.push_back({.first_id = record.state.message_id});
  in_motion_ = true;
  TalliedMotion& motion = motions_.back();
  motion.last_id = record.state.message_id;
  motion.counts.Add(record);
  counts_.Add(record);
  lost_in_row_.push_back(
      static_cast<std::uint8_t>(std::min<std::uint32_t>(record.lost_in_row, 255)));
}

bool MotionTally::IsInMotion(std::uint64_t message_id) const noexcept {
  // A command answers the state of the cycle before.
  return std::ranges::any_of(motions_, [message_id](const TalliedMotion& motion) {
    return message_id + 1 >= motion.first_id && message_id + 1 <= motion.last_id;
  });
}

std::vector<Answer> AnswersOf(const std::filesystem::path& capture) {
  record::PcapngReader reader(capture);
  std::map<std::uint64_t, double> unanswered;  // id of a state -> when it left
  std::vector<Answer> answers;
  RobotState state;
  RobotCommand command;
  while (const auto packet = reader.Next()) {
    if (packet->transport != record::Transport::kUdp) continue;
    const double at_s = ToSeconds(packet->at.time_since_epoch());
    if (packet->bytes.size() == fci::kStateBytes) {
      if (fci::Decode(packet->bytes, state) != fci::DatagramFault::kNone) continue;
      unanswered.emplace(state.message_id, at_s);
    } else if (packet->bytes.size() == fci::kCommandBytes) {
      if (fci::Decode(packet->bytes, command) != fci::DatagramFault::kNone) continue;
      const auto sent = unanswered.find(command.message_id);
      if (sent == unanswered.end()) continue;  // answered already, or never sent
      answers.push_back(
          {.message_id = command.message_id, .sent_s = sent->second, .received_s = at_s});
      unanswered.erase(unanswered.begin(), std::next(sent));
    }
  }
  return answers;
}

Findings RunClientStudy(const Config& config, const ClientProgram& program) {
  Observation seen;
  const std::filesystem::path capture = config.scratch / "client.pcapng";
  Observe(config, program, capture, seen);
  Findings findings{.id = "client",
                    .title = "Timings of a program of your own",
                    .source = "As Section 2, Table 1",
                    .page = "client",
                    .values = ClientValues(program, seen)};
  if (seen.tally.motions().empty()) {
    findings.failure = fmt::format(
        "the client ended with {} and without a motion that got a command; it must connect to "
        "127.0.0.1, port {}",
        seen.how_it_ended, program.arm_port);
    return findings;
  }
  const std::vector<Answer> answers = AnswersOf(capture);
  const std::vector<double> latencies = LatenciesOf(answers, seen.tally);
  AddAll(seen.tally, latencies, findings);
  AddEach(seen.tally, findings);
  AddEnd(seen, findings);
  if (!latencies.empty()) findings.figures.push_back(ClientLatencyFigure(latencies));
  findings.figures.push_back(ClientLossesFigure(seen.tally));
  return findings;
}

}  // namespace twin::experiment
