#pragma once

#include <array>
#include <cstdint>

namespace twin {

/// Which random quantity is drawn. Every consumer has its own stream, so that adding a draw in one
/// place changes no number anywhere else.
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
  kFault = 16,          ///< of the fault-injecting backend
  kHandSeed = 17,       ///< of the hand's way through a proxy, which is drawn apart from the arm's
  kPlannerSample = 18,  ///< where a planner's search trees grow to
  kPlannerShortcut = 19,  ///< which shortcuts of a path it tries
  kPlannerGoal = 20,      ///< random goals
  kMotionSeed = 21,       ///< of a session's later motions
  kGoalSeed = 22,         ///< of an application's later goals
  kObjects = 23,          ///< sizes, masses and places of a scenario's objects
  kPlace = 24,            ///< where an application puts something
  kOperatorDelay = 32,    ///< of what an operator's hands do, on the way to the robot
  kOperatorLoss = 33,
  kOperatorBurst = 34,
  kOperatorDuplicate = 35,
  kOperatorReorder = 36,
  kFeedbackDelay = 37,  ///< of what the operator is made to feel, on the way back
  kFeedbackLoss = 38,
  kFeedbackBurst = 39,
  kFeedbackDuplicate = 40,
  kFeedbackReorder = 41,
  kPerson = 42,  ///< hands and eyes of a scripted person
  kTest = 1000,
};

/// Counter-based random numbers: a pure function of (seed, stream, tick, draw), without state.
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
