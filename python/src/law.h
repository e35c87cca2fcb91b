#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <optional>

#include "bindings.h"
#include "twin/control/controller.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"

namespace twin::python {

/// A user's function `law(state, dt)` as a controller of the bare loop, called once a cycle with
/// the GIL, which nothing else of a motion needs.
///
/// Its first call comes before the motion, with the robot's present state and dt = 0: the type of
/// what it returns decides on the interface, and its value answers the motion's first state. Each
/// later call has dt = 1 ms times the cycles since the last. A command that is finished, or the
/// last one before `until`, is held, a velocity at zero, until the motion ends.
///
/// What the law raises, and a value that is no command of the interface, stops the motion;
/// Rethrow() raises it.
///
/// Threads: one, the session's; it must outlive its controllers.
class Law {
 public:
  /// @param law  callable. @param until  of the motion; nullopt: until the law has finished.
  Law(nb::object law, std::optional<Duration> until) : law_(std::move(law)), until_(until) {}

  /// The first call. @pre the GIL is held. @throws what the law raises; nb::type_error when it
  /// returns no command.
  control::CommandInterface Begin(const RobotState& state);

  /// @pre after Begin().
  [[nodiscard]] std::unique_ptr<control::Controller> MakeController();

  /// Throws what has stopped the motion; nothing otherwise.
  void Rethrow() const {
    if (raised_) std::rethrow_exception(raised_);
  }
  /// Calls of the law so far.
  [[nodiscard]] std::uint64_t calls() const noexcept { return calls_; }

 private:
  class LawController;

  /// @throws as Begin(), nb::type_error for another interface than before.
  void Call(const RobotState& state, double dt);
  void Take(nb::handle command);

  const nb::object law_;
  const std::optional<Duration> until_;
  control::CommandInterface interface_{};
  nb::handle type_;  ///< of the commands; null before the first
  control::ControllerOutput output_;
  Vector6 twist_{};  ///< of CartesianVelocities
  bool is_twist_ = false;
  std::uint64_t calls_ = 0;
  std::exception_ptr raised_;
};

}  // namespace twin::python
