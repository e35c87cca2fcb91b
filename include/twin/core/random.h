#pragma once

#include <array>
#include <cstdint>

namespace twin {

/// Purpose of a random number. Every consumer has its own stream, so an additional draw in one
/// place changes no number elsewhere.
enum class RandomStream : std::uint32_t {
  kSensorNoise = 1,
  kStateDelay = 2,
  kCommandDelay = 3,
  kStateLoss = 4,
  kCommandLoss = 5,
  kTickCost = 6,
  kControllerCost = 7,
  kControllerWake = 8,
  kStateBurst = 9,  ///< transitions of a loss model with memory
  kCommandBurst = 10,
  kStateDuplicate = 11,
  kCommandDuplicate = 12,
  kStateReorder = 13,
  kCommandReorder = 14,
  kTargetNoise = 15,
  kFault = 16,            ///< of the fault-injecting backend
  kHandSeed = 17,         ///< of the hand's link through a proxy, independent of the arm's
  kPlannerSample = 18,    ///< growth of a planner's search trees
  kPlannerShortcut = 19,  ///< shortcuts of a path to try
  kPlannerGoal = 20,      ///< random goals
  kMotionSeed = 21,       ///< of a session's later motions
  kGoalSeed = 22,         ///< of an application's later goals
  kObjects = 23,          ///< sizes, masses and places of a scenario's objects
  kPlace = 24,            ///< where an application places an object
  kProfile = 25,          ///< numbers of a robot's profile, by its covariance
  kRobotSeed = 26,        ///< of each of several robots, by its name
  kOperatorDelay = 32,    ///< of an operator's commands to the robot
  kOperatorLoss = 33,
  kOperatorBurst = 34,
  kOperatorDuplicate = 35,
  kOperatorReorder = 36,
  kFeedbackDelay = 37,  ///< of force feedback to the operator
  kFeedbackLoss = 38,
  kFeedbackBurst = 39,
  kFeedbackDuplicate = 40,
  kFeedbackReorder = 41,
  kOperator = 42,  ///< motor and visual noise of a scripted operator
  kTest = 1000,
};

/// Counter-based random numbers: a stateless function of (seed, stream, tick, draw).
///
/// The generator is Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC
/// 2011), key = seed, counter = (tick, stream, draw). The same arguments give the same number on
/// every machine, in any order of calls and on any thread. Real-time: noexcept, O(1), no
/// allocation.
class Random {
 public:
  constexpr Random(std::uint64_t seed, RandomStream stream) noexcept
      : seed_(seed), stream_(stream) {}

  /// @returns 128 random bits.
  [[nodiscard]] std::array<std::uint32_t, 4> Bits(std::uint64_t tick,
                                                  std::uint32_t draw = 0) const noexcept;

  /// @returns uniform in [0, 1), 53 random bits.
  [[nodiscard]] double Uniform(std::uint64_t tick, std::uint32_t draw = 0) const noexcept;

  /// @returns normal with mean 0 and standard deviation 1 (Box-Muller, one value per call).
  [[nodiscard]] double Normal(std::uint64_t tick, std::uint32_t draw = 0) const noexcept;

 private:
  std::uint64_t seed_;
  RandomStream stream_;
};

}  // namespace twin
