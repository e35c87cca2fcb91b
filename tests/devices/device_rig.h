#pragma once

#include <memory>
#include <optional>

#include "twin/core/time.h"
#include "twin/teleop/device.h"

namespace twin::devices {

/// A device, and what stands for the hands that hold it.
class DeviceRig {
 public:
  virtual ~DeviceRig() = default;
  [[nodiscard]] virtual teleop::Device& device() = 0;
  /// The hands deflect x (ahead) by half, and press the gripper's button once.
  virtual void Act() = 0;
  /// The device goes, for ever.
  virtual void Go() = 0;

  /// Waits, at an instant that goes on, until the device gives a sample. It must.
  [[nodiscard]] teleop::OperatorSample Await();
  /// As Await, for a sample that shows `gripper_presses`.
  [[nodiscard]] teleop::OperatorSample AwaitPresses(std::uint32_t gripper_presses);
  /// Waits until the device is lost. It must be.
  void AwaitLoss();

  /// Of the run: goes on by a millisecond with every Read().
  [[nodiscard]] std::optional<teleop::OperatorSample> Read() {
    now_ += kCycle;
    return device().Read(now_);
  }

 private:
  Time now_{};
};

[[nodiscard]] std::unique_ptr<DeviceRig> MakeEvdevRig();
[[nodiscard]] std::unique_ptr<DeviceRig> MakeNetworkRig();
[[nodiscard]] std::unique_ptr<DeviceRig> MakeScriptRig();
[[nodiscard]] std::unique_ptr<DeviceRig> MakeRecordedRig();

}  // namespace twin::devices
