#include "plugins/ros2/arm_commander.h"

#include <exception>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/modes.h"

namespace twin::ros2 {

/// A robot that stopped by an error moves again when a person or a program says so.
void RequireReady(const RobotState& state) {
  if (state.robot_mode == RobotMode::kIdle) return;
  throw RobotFault(fmt::format(
      "the robot is in mode {}, not Idle; after a reflex call the service ~/recover, else release "
      "the stop",
      Name(state.robot_mode)));
}

run::MotionResult MoveByOwnController(run::Session& session, run::Motion motion) {
  motion.controller.type = kController;
  return session.Move(motion);
}

ArmCommander::ArmCommander(Parts parts)
    : parts_(std::move(parts)), thread_([this](const std::stop_token& stop) { Run(stop); }) {}

ArmCommander::~ArmCommander() {
  thread_.request_stop();
  const std::lock_guard lock(mutex_);
  interrupted_ = true;
}

void ArmCommander::Begin(std::shared_ptr<ArmWork> work) {
  std::shared_ptr<ArmWork> dropped;
  {
    const std::lock_guard lock(mutex_);
    dropped = std::exchange(next_, std::move(work));
    interrupted_ = true;
    wake_.notify_one();
  }
  if (dropped) dropped->End("a newer command took its place", true);
}

void ArmCommander::GiveUp(const ArmWork& work) {
  std::shared_ptr<ArmWork> dropped;
  {
    const std::lock_guard lock(mutex_);
    if (next_.get() == &work) dropped = std::exchange(next_, nullptr);
    if (current_.get() == &work) interrupted_ = true;
  }
  if (dropped) dropped->End("given up before it began", true);
}

bool ArmCommander::is_busy() const {
  const std::lock_guard lock(mutex_);
  return next_ || current_;
}

void ArmCommander::Run(const std::stop_token& stop) {
  while (true) {
    {
      std::unique_lock lock(mutex_);
      if (!wake_.wait(lock, stop, [this] { return next_ != nullptr; })) return;
      current_ = std::exchange(next_, nullptr);
      interrupted_ = stop.stop_requested();
    }
    Execute(current_);
    const std::lock_guard lock(mutex_);
    current_.reset();
  }
}

void ArmCommander::Execute(const std::shared_ptr<ArmWork>& work) {
  control::ControllerRegistry controllers = parts_.catalogue.controllers;
  controllers.Add(kController, [&work](const control::ControllerRequest& request) {
    return work->MakeController(request);
  });
  const run::Catalogue catalogue{parts_.catalogue.backends, controllers};
  run::RunHooks hooks;
  hooks.interrupted = &interrupted_;
  hooks.look = [&work] { work->Look(); };
  try {
    run::Session session(parts_.client, catalogue, parts_.files, nullptr, parts_.settings);
    session.Begin(hooks);
    work->Run(session, parts_.client);
  } catch (const std::exception& error) {
    return work->End(error.what(), interrupted_);
  }
  work->End("", interrupted_);
}

}  // namespace twin::ros2
