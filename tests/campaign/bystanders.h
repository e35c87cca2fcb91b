#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "conformance/dice.h"
#include "conformance/mode_rules.h"
#include "twin/core/modes.h"
#include "twin/fci/hand_client.h"
#include "twin/server/control_channel.h"
#include "twin/server/served_robot.h"

namespace twin::campaign {

/// Who else is about a served robot beside the client of its arm: a client of its hand, and a
/// program on its control channel. Holds the server to what docs/reference/control-channel.md and
/// twin/core/hand_command.h promise them.
///
/// Threads: one. Errors: BrokenPromise (wire_client.h).
class Bystanders {
 public:
  /// Dice and robot must outlive this. @param device  on the robot's flange, with nothing to hold.
  /// @pre the robot's time runs, in lockstep.
  Bystanders(test::Dice& dice, server::ServedRobot& robot, HandDevice device);

  /// One of them does something, between two motions. @param now  the robot, before it and after.
  /// @param done  gets what it was.
  void Act(test::Situation& now, std::vector<std::string>& done);
  /// How often the robot's cycles may go on from a snapshot's instead of the last one.
  [[nodiscard]] int ways_back() const { return ways_back_; }

 private:
  /// What a snapshot keeps of what is known here.
  struct Kept {
    std::uint64_t cycle = 0;
    test::Situation now;
  };

  // The control channel.
  nlohmann::json Ask(const server::ControlRequest& request);
  /// @pre it cannot be refused. @returns the cycle after it.
  std::uint64_t Do(const server::ControlRequest& request);
  void Refuse(const server::ControlRequest& request);
  server::ControlRequest DrawRequest();
  void Step(const server::ControlRequest& step, const test::Situation& now);
  void Operate(const server::ControlRequest& request, test::Ask ask, test::Situation& now);
  void Reset(const server::ControlRequest& reset, test::Situation& now);
  void Keep(const server::ControlRequest& snapshot, const test::Situation& now);
  void GoBack(const server::ControlRequest& restore, test::Situation& now);

  // The hand.
  std::string UseHand();
  void TrySecondHandClient() const;
  HandCommand DrawHandCommand();
  std::optional<HandResult> AwaitOutcome(HandTicket ticket, bool steps);
  /// Lets time pass until the last command has ended, and holds it to its promise.
  void AwaitHand(const HandCommand& command, HandTicket ticket);
  void CheckFingers(const HandCommand& command);
  void CheckPump(const HandCommand& command);

  test::Dice& dice_;
  server::ServedRobot& robot_;
  const HandDevice device_;
  const bool may_reset_;
  const server::ControlledRobot controlled_;
  const std::filesystem::path socket_;
  const server::ControlChannel channel_;
  std::map<std::string, Kept> snapshots_;
  int ways_back_ = 0;
  std::optional<fci::HandClient> hand_;
  HandTicket last_ = 0;       ///< taken of hand_; 0 without any
  bool may_be_busy_ = false;  ///< the hand: a command was left to itself
};

}  // namespace twin::campaign
