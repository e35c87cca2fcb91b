#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "twin/backend/backend.h"
#include "twin/backend/registry.h"
#include "twin/robot/robot_config.h"

namespace twin::test {

/// A connected backend and a way to let its time pass. One implementation per backend and drive.
class BackendHarness {
 public:
  virtual ~BackendHarness() = default;

  [[nodiscard]] virtual backend::Backend& backend() = 0;

  /// Lets time pass until a state has been read. @returns false when none came for long.
  [[nodiscard]] virtual bool AwaitState(RobotState& state, backend::ReadRule rule) = 0;

  /// Lets time pass until at least `count` more states have arrived, unread. @returns as above.
  [[nodiscard]] virtual bool AwaitArrivals(int count) = 0;

  /// Whether it depends on the machine when things happen.
  [[nodiscard]] virtual bool by_the_wall_clock() const { return false; }
  /// Whether a recovery that is asked for while the arm moves is done once it rests, not refused.
  [[nodiscard]] virtual bool recovers_at_rest() const { return false; }
  /// Whether, since ForgetDisturbances(), a state was never read or a command missed its cycle,
  /// because of the machine.
  [[nodiscard]] virtual bool disturbed() { return false; }
  /// The most states in a row that were never read since then.
  [[nodiscard]] virtual std::uint64_t missed_in_row() const { return 0; }
  virtual void ForgetDisturbances() {}

  /// The buttons and switches of a simulated robot; null for hardware.
  [[nodiscard]] virtual backend::Panel* panel() { return nullptr; }
  /// The hand; null when none is mounted.
  [[nodiscard]] virtual backend::Hand* hand() { return nullptr; }
};

/// Where the harness's arm rests at the start.
inline constexpr JointVector kHarnessStart{
    0, -0.785398163397, 0, -2.356194490192, 0, 1.570796326795, 0.785398163397};

/// A Panda of primitive shapes without a hand, at that pose, on a link without delays.
[[nodiscard]] robot::RobotConfig HarnessRobot(robot::PlantKind plant_kind);

/// Names a harness for the parametrised suites. What it makes connects the robot it is given.
struct HarnessCase {
  std::string name;
  robot::PlantKind plant_kind{};
  std::function<std::unique_ptr<BackendHarness>(const robot::RobotConfig& robot)> make;
  /// Whether it waits for every answer from a motion's first on: then none can be lost by silence.
  bool waits_for_answers = false;
  /// The least FIFO priority of the threads that its time passes on, the caller's among them.
  int fifo_priority = 0;
};

/// Those of this test program.
[[nodiscard]] std::vector<HarnessCase> Harnesses();

}  // namespace twin::test
