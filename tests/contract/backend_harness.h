#pragma once

#include <functional>
#include <memory>
#include <string>

#include "twin/backend/backend.h"

namespace twin::test {

/// A connected backend and a way to let its time pass. One implementation per backend and drive.
class BackendHarness {
 public:
  virtual ~BackendHarness() = default;

  [[nodiscard]] virtual backend::Backend& backend() = 0;

  /// Lets time pass until a state has been read. @returns false when none came within 1 s of its
  /// time.
  [[nodiscard]] virtual bool AwaitState(RobotState& state) = 0;
};

/// Where the harness's arm rests at the start.
inline constexpr JointVector kHarnessStart{
    0, -0.785398163397, 0, -2.356194490192, 0, 1.570796326795, 0.785398163397};

/// Names a harness for the parametrised suite.
struct HarnessCase {
  std::string name;
  std::function<std::unique_ptr<BackendHarness>()> make;
};

/// The emulated robot in process, lockstep, on the MuJoCo plant (primitive shapes) and on the ideal
/// plant.
[[nodiscard]] HarnessCase MujocoHarness();
[[nodiscard]] HarnessCase IdealPlantHarness();

}  // namespace twin::test
