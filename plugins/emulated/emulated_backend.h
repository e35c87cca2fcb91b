#pragma once

#include <memory>
#include <string>
#include <utility>

#include "plugins/emulated/emulated_base.h"
#include "plugins/emulated/emulated_hand.h"
#include "twin/backend/backend.h"
#include "twin/backend/refusal.h"
#include "twin/backend/registry.h"
#include "twin/onboard/onboard_controller.h"
#include "twin/plant/plant.h"
#include "twin/robot/robot.h"

namespace twin::plugins {

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

}  // namespace twin::plugins
