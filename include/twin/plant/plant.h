#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "twin/core/body_interface.h"
#include "twin/core/hand_command.h"
#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"

namespace twin::plant {

/// Hand on the flange.
enum class HandKind : std::uint8_t {
  kNone,
  kFrankaHand,  ///< the Franka Hand: two fingers on slides with one drive
  kCobotPump,   ///< the cobot pump: suction cups on one vacuum pump
};

/// @pre there is a hand.
[[nodiscard]] constexpr HandDevice DeviceOf(HandKind kind) noexcept {
  return kind == HandKind::kCobotPump ? HandDevice::kCobotPump : HandDevice::kFrankaHand;
}

/// The hand's body: force in, motion of the fingers out. It advances in its plant's Step().
///
/// Threads: the plant's. Real-time: noexcept, allocates nothing.
class HandBody {
 public:
  virtual ~HandBody() = default;

  /// Sets the drive from the plant's next Step() on, until the next call. Plant::Reset() sets zero.
  virtual void Drive(const HandDrive& drive) noexcept TWIN_REALTIME = 0;

  /// Sensors after the last Step() or Reset(). Reset() leaves the hand open.
  [[nodiscard]] virtual const HandSensors& sensors() const noexcept = 0;
};

/// The vacuum gripper's body: pump and valve in, vacuum out. It advances in its plant's Step().
///
/// Threads: the plant's. Real-time: noexcept, allocates nothing.
class SuctionBody {
 public:
  virtual ~SuctionBody() = default;

  /// Sets pump and valve from the plant's next Step() on, until the next call. Plant::Reset() stops
  /// the pump and opens the valve.
  virtual void Drive(const PumpDrive& drive) noexcept TWIN_REALTIME = 0;

  /// Sensors after the last Step() or Reset(). Reset() leaves no vacuum.
  [[nodiscard]] virtual const PumpSensors& sensors() const noexcept = 0;
};

/// A mobile base under the arm: a URDF with a link named `arm_mount`, the pose of the arm's base O,
/// and four wheels on continuous joints, named front_left_wheel, front_right_wheel, rear_left_wheel
/// and rear_right_wheel, each with one cylinder for contact.
///
/// With a base the world frame is on the floor (z = 0), and O moves with the base.
struct BaseOptions {
  std::filesystem::path urdf;
  BasePose start;  ///< of the point between the wheels, on the floor
};

/// The base's body: wheel torques in, wheel rotation out. It advances in its plant's Step().
///
/// Threads: the plant's. Real-time: noexcept, allocates nothing.
class BaseBody {
 public:
  virtual ~BaseBody() = default;

  /// Sets the wheel torques from the plant's next Step() on, until the next call. Plant::Reset()
  /// sets zero.
  virtual void Drive(const WheelDrive& drive) noexcept TWIN_REALTIME = 0;

  /// Sensors after the last Step() or Reset(). Reset() leaves the base at rest on its tyres, at its
  /// start, all q zero.
  [[nodiscard]] virtual const WheelSensors& sensors() const noexcept = 0;
};

/// A shape of the engine's model that a body would overlap, and how deep, m.
struct Overlap {
  int geom = 0;
  double depth = 0;
};

/// The arm's body: torque in, joint motion out, one millisecond at a time.
///
/// Threads: one thread. Real-time: Step() and Place() are noexcept and allocate nothing.
class Plant {
 public:
  /// A copy of all that changes in a plant: bodies, solver, hand, base, brakes, disturbances,
  /// noise.
  class State {
   public:
    State() = default;
    virtual ~State() = default;
    State(const State&) = delete;
    State& operator=(const State&) = delete;
  };

  virtual ~Plant() = default;

  /// Sets the arm to `q` (rad) at rest and restarts plant time and noise. Does not throw.
  virtual void Reset(const JointVector& q) = 0;

  /// Advances by exactly 1 ms under `drive`, constant over the step; then sensors() has the result.
  virtual void Step(const JointDrive& drive) noexcept TWIN_REALTIME = 0;

  /// Announces that a motion starts with the next Step(), for plant::Push::motion. Real-time:
  /// noexcept.
  virtual void BeginMotion() noexcept TWIN_REALTIME {}

  /// Draws the noise of the sensors from another seed from the next Step() on.
  virtual void Reseed(std::uint64_t /*seed*/) noexcept TWIN_REALTIME {}

  /// A body placed deeper than this in another is refused, m. What rests on something sinks in
  /// less.
  static constexpr double kMostOverlap = 1e-3;

  /// Puts a free body at rest at X_WB, between two steps. @param body  of the engine's model, as
  /// FreeBodyNamed() has it (observers.h). @param X_WB  of its frame in the world.
  /// @returns absent when done; else the deepest overlap beyond kMostOverlap, without any effect.
  virtual std::optional<Overlap> Place(int /*body*/,
                                       const Transform& /*X_WB*/) noexcept TWIN_REALTIME {
    return {};
  }

  /// @returns a copy of the state, between two steps. Allocates.
  [[nodiscard]] virtual std::unique_ptr<const State> Save() const = 0;
  /// Goes back to `state`: the same drives then give the same bits as after Save().
  /// @pre this plant has saved it. Allocates.
  virtual void Restore(const State& state) = 0;

  /// Sensors after the last Step() or Reset().
  [[nodiscard]] virtual const JointSensors& sensors() const noexcept = 0;

  /// Whoever drives this plant will only hold it from now on. Real-time: noexcept.
  virtual void StandBy() noexcept TWIN_REALTIME {}
  /// Whether another arm of the same model still moves, so that this one must go on to be driven:
  /// false once all stand by, and of an arm alone.
  [[nodiscard]] virtual bool is_awaited() const noexcept TWIN_REALTIME { return false; }

  /// The hand on the flange, owned by the plant; null without one that has fingers.
  [[nodiscard]] virtual HandBody* hand() noexcept { return nullptr; }

  /// The vacuum gripper on the flange, owned by the plant; null without one.
  [[nodiscard]] virtual SuctionBody* suction() noexcept { return nullptr; }

  /// The mobile base below the arm, owned by the plant; null if the arm is fixed to the world.
  [[nodiscard]] virtual BaseBody* base() noexcept { return nullptr; }
};

}  // namespace twin::plant
