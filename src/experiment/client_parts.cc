#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <system_error>

#include <fmt/format.h>

#include "experiment/client_parts.h"
#include "twin/core/error.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/protocol.h"
#include "twin/onboard/onboard_config.h"
#include "twin/record/pcapng_reader.h"

namespace twin::experiment {

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

}  // namespace twin::experiment
