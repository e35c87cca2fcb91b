#include "law.h"

#include <string>
#include <utility>

#include <fmt/format.h>
#include <nanobind/stl/string.h>

#include "commands.h"
#include "twin/model/transform.h"

namespace twin::python {

using control::CommandInterface;

namespace {

template <typename Command>
const Command* As(nb::handle command) {
  return nb::isinstance<Command>(command) ? nb::inst_ptr<Command>(command) : nullptr;
}

std::string TypeOf(nb::handle value) {
  return nb::cast<std::string>(nb::handle(value.type()).attr("__name__"));
}

}  // namespace

void Law::Take(nb::handle command) {
  const auto is = [this](CommandInterface interface, const auto& typed) {
    interface_ = interface;
    output_.finished = typed.finished;
  };
  is_twist_ = false;
  if (const auto* torques = As<Torques>(command)) {
    is(CommandInterface::kTorque, *torques);
    output_.target.tau_J_d = torques->tau_J;
  } else if (const auto* positions = As<JointPositions>(command)) {
    is(CommandInterface::kJointPosition, *positions);
    output_.target.joint.q = positions->q;
  } else if (const auto* velocities = As<JointVelocities>(command)) {
    is(CommandInterface::kJointVelocity, *velocities);
    output_.target.joint.dq = velocities->finished ? JointVector{} : velocities->dq;
    output_.has_velocity = true;
  } else if (const auto* pose = As<CartesianPose>(command)) {
    is(CommandInterface::kCartesianPose, *pose);
    output_.target.pose.O_T_EE = pose->O_T_EE;
  } else if (const auto* twist = As<CartesianVelocities>(command)) {
    is(CommandInterface::kCartesianPose, *twist);
    is_twist_ = true;
    twist_ = twist->finished ? Vector6{} : twist->O_dP_EE;
    output_.target.pose.O_dP_EE = twist_;
    output_.has_velocity = true;
  } else {
    throw nb::type_error(
        fmt::format("the law returned {}; let it return panda_twin.Torques, JointPositions, "
                    "JointVelocities, CartesianPose or CartesianVelocities",
                    TypeOf(command))
            .c_str());
  }
}

void Law::Call(const RobotState& state, double dt) {
  ++calls_;
  const nb::object command = law_(state, dt);
  if (type_.is_valid() && !command.type().is(type_)) {
    throw nb::type_error(fmt::format("the law returned {} after {}; one motion has one interface",
                                     TypeOf(command), nb::cast<std::string>(type_.attr("__name__")))
                             .c_str());
  }
  Take(command);
  type_ = command.type();
}

CommandInterface Law::Begin(const RobotState& state) {
  Call(state, 0);
  return interface_;
}

class Law::LawController final : public control::Controller {
 public:
  explicit LawController(Law& law) : law_(law) {}

  [[nodiscard]] CommandInterface command_interface() const noexcept override {
    return law_.interface_;
  }
  void Activate(const RobotState& /*state*/, Time /*now*/) override {}
  void Deactivate() noexcept override {}

  void Update(const RobotState& state, Time /*now*/,
              control::ControllerOutput& output) noexcept override {
    if (first_ == 0) {
      first_ = last_ = state.message_id;
      law_.output_.target.pose.O_T_EE =
          law_.is_twist_ ? state.O_T_EE_c : law_.output_.target.pose.O_T_EE;
    } else if (!law_.output_.finished && !law_.raised_) {
      Call(state);
    }
    last_ = state.message_id;
    output = law_.output_;
    output.failed = law_.raised_ != nullptr;
  }

  [[nodiscard]] std::string Explain() const override {
    return law_.raised_ ? "the law raised an exception, or returned no command of its interface"
                        : std::string();
  }

 private:
  void Call(const RobotState& state) noexcept {
    const double dt = kCycleSeconds * static_cast<double>(state.message_id - last_);
    try {
      if (InterpreterEnds()) ThrowInterpreterEnds();
      const nb::gil_scoped_acquire gil;
      try {
        law_.Call(state, dt);
      } catch (...) {
        law_.raised_ = std::current_exception();
        return;
      }
    } catch (...) {  // the GIL's own, at the interpreter's end
      law_.raised_ = std::current_exception();
      return;
    }
    control::ControllerOutput& output = law_.output_;
    if (law_.until_ &&
        kCycle * static_cast<std::int64_t>(state.message_id - first_) >= *law_.until_) {
      output.finished = true;
      output.target.joint.dq = {};
      law_.twist_ = {};
    }
    if (!law_.is_twist_) return;
    Transform& X = output.target.pose.O_T_EE;
    output.target.pose.O_dP_EE = law_.twist_;
    X = model::Turned(X, dt * model::Angular(law_.twist_),
                      model::Position(X) + dt * model::Linear(law_.twist_));
  }

  Law& law_;
  std::uint64_t first_ = 0;  ///< message_id of the motion's first state
  std::uint64_t last_ = 0;
};

std::unique_ptr<control::Controller> Law::MakeController() {
  return std::make_unique<LawController>(*this);
}

}  // namespace twin::python
