#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "twin/backend/backend.h"
#include "twin/backend/hand.h"
#include "twin/backend/mobile_base.h"
#include "twin/backend/refusal.h"
#include "twin/backend/registry.h"
#include "twin/onboard/onboard_controller.h"
#include "twin/plant/plant.h"
#include "twin/robot/base_unit.h"
#include "twin/robot/robot.h"

namespace twin::plugins {

/// The emulated hand behind the hand seam; independent of what advances its time.
/// @tparam Robot  robot::Robot or robot::RealtimeRobot, with a hand mounted.
template <typename Robot>
class EmulatedHand final : public backend::Hand {
 public:
  /// @param robot  must outlive the hand.
  explicit EmulatedHand(Robot& robot) noexcept : robot_(robot) {}

  HandTicket Start(const HandCommand& command) override {
    const HandStart start = robot_.StartHand(command);
    backend::RequireStarted(start, command);
    return start.ticket;
  }
  [[nodiscard]] std::optional<HandResult> Outcome(HandTicket ticket) const override {
    return robot_.HandOutcome(ticket);
  }
  [[nodiscard]] HandState ReadState() const override { return robot_.hand_state(); }

 private:
  Robot& robot_;
};

/// The emulated mobile base behind the base seam; independent of what advances its time.
class EmulatedBase final : public backend::MobileBase {
 public:
  /// @param unit  must outlive the base; null without a mobile base, and then never used.
  explicit EmulatedBase(robot::BaseUnit* unit) noexcept : unit_(unit) {}

  void Drive(const BaseTwist& twist) noexcept override { unit_->Drive(twist); }
  void EmergencyStop() noexcept override { unit_->EmergencyStop(); }
  void Release() noexcept override { unit_->Release(); }
  [[nodiscard]] BaseState ReadState() const noexcept override { return unit_->ReadState(); }

 private:
  robot::BaseUnit* unit_;
};

/// A plant and its description.
struct NamedPlant {
  std::unique_ptr<plant::Plant> plant;
  std::string name;  ///< for users
};

/// The backend seam's description of an emulated robot.
[[nodiscard]] backend::Description DescribeRobot(const std::string& plant_name,
                                                 const robot::LastMotion& last);

/// The emulated robot behind the backend seam, without reading and writing; independent of what
/// advances its time.
/// @tparam Robot  robot::Robot or robot::RealtimeRobot.
template <typename Robot>
class EmulatedBackend : public backend::Backend, public backend::Panel {
 public:
  [[nodiscard]] backend::Description Describe() const final {
    return DescribeRobot(plant_name_, robot_.last_motion());
  }

  void Configure(const Setting& setting) final {
    const SetterStatus status = robot_.Configure(setting);
    backend::RequireSet(status, setting, robot_.mode());
  }

  void Operate(PanelAction action) final {
    const bool done = robot_.Operate(action);
    backend::RequireOperated(done, action, robot_.mode());
  }

  /// Null without a hand.
  [[nodiscard]] backend::Hand* hand() noexcept { return robot_.has_hand() ? &hand_ : nullptr; }

  /// Null without a mobile base.
  [[nodiscard]] backend::MobileBase* base() noexcept {
    return robot_.base() != nullptr ? &base_ : nullptr;
  }

  void Start(const MotionModes& modes) final {
    const MoveStatus status = robot_.Move(modes);
    backend::RequireStarted(status, modes, robot_.mode());
  }

  void Stop() final { robot_.StopMove(); }

  void Recover() final {
    const RecoveryStatus status = robot_.AutomaticErrorRecovery();
    backend::RequireRecovered(status, robot_.mode());
  }

 protected:
  /// @param arguments  of the robot's constructor.
  template <typename... Arguments>
  explicit EmulatedBackend(std::string plant_name, Arguments&&... arguments)
      : plant_name_(std::move(plant_name)), robot_(std::forward<Arguments>(arguments)...) {}

  [[nodiscard]] Robot& robot() noexcept { return robot_; }
  [[nodiscard]] const Robot& robot() const noexcept { return robot_; }

 private:
  std::string plant_name_;
  Robot robot_;
  EmulatedHand<Robot> hand_{robot_};
  EmulatedBase base_{robot_.base()};
};

/// Connects the emulated robot on the virtual clock: its cycles are events of the queue from now
/// on. Sets backend and panel of the connection.
void ConnectLockstep(const backend::Request& request, const backend::VirtualTime& time,
                     NamedPlant plant, backend::Connection& connection);

/// Connects the emulated robot on the wall clock, on its own thread, which runs between Begin() and
/// End() of the connection's robot_time. Sets backend, panel, arrival and robot_time.
void ConnectRealtime(const backend::Request& request, const backend::WallTime& time,
                     NamedPlant plant, backend::Connection& connection);

}  // namespace twin::plugins
