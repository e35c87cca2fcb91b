#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "loaded_scenario.h"
#include "twin/core/error.h"
#include "twin/core/robot_errors.h"
#include "twin/model/arm_model.h"
#include "twin/onboard/arm_setup.h"
#include "twin/onboard/external_torque_observer.h"
#include "twin/onboard/external_wrench.h"
#include "twin/run/command_replay.h"
#include "twin/run/robot_config.h"
#include "twin/scenario/robot_data.h"

// A log's commands through INT and plant, and its measurements through INT's observer; row by row
// into arrays that the Python layer allocates.
namespace twin::python {
namespace {

template <typename T, Py_ssize_t... kShape>
using BlockOf = nb::ndarray<T, nb::shape<-1, kShape...>, nb::c_contig, nb::device::cpu>;

/// What is asked of the robot before a cycle.
enum class Asked : std::uint8_t { kNothing, kStart, kStop, kRecover };

/// Columns of a row's command: q_c, dq_c, tau_J_d, O_T_EE_c, O_dP_EE_c, elbow_c, and 1 for a valid
/// elbow and for a finished motion.
constexpr Py_ssize_t kCommandSize = 7 + 7 + 7 + 16 + 6 + 2 + 1 + 1;
/// Of a state: q, dq, tau_J, q_d, dq_d, tau_ext_hat_filtered, O_F_ext_hat_K.
constexpr Py_ssize_t kStateSize = 7 * 6 + 6;
/// Of its codes: message_id, errors as bits, robot_mode, fate.
constexpr Py_ssize_t kCodes = 4;

RobotCommand CommandOf(const double* from) noexcept {
  RobotCommand command;
  const auto take = [&from](auto& values) {
    std::copy_n(from, values.size(), values.begin());
    from += values.size();
  };
  take(command.q_c);
  take(command.dq_c);
  take(command.tau_J_d);
  take(command.O_T_EE_c);
  take(command.O_dP_EE_c);
  take(command.elbow_c);
  command.valid_elbow = *from++ != 0;
  command.motion_generation_finished = *from != 0;
  return command;
}

void PutState(const record::CycleRecord& record, double* out, std::uint64_t* codes) noexcept {
  const RobotState& state = record.state;
  for (const JointVector* values :
       {&state.q, &state.dq, &state.tau_J, &state.q_d, &state.dq_d, &state.tau_ext_hat_filtered}) {
    out = std::ranges::copy(*values, out).out;
  }
  std::ranges::copy(state.O_F_ext_hat_K, out);
  codes[0] = state.message_id;
  codes[1] = state.errors.to_ullong();
  codes[2] = static_cast<std::uint64_t>(state.robot_mode);
  codes[3] = static_cast<std::uint64_t>(record.fate);
}

void Ask(run::CommandReplay& replay, const std::uint8_t* request) noexcept {
  // The robot may refuse; its state then tells.
  switch (static_cast<Asked>(request[0])) {
    case Asked::kNothing: break;
    case Asked::kStart:
      static_cast<void>(replay.Start(
          {static_cast<ControllerMode>(request[2]), static_cast<MotionGeneratorMode>(request[1])}));
      break;
    case Asked::kStop: replay.Stop(); break;
    case Asked::kRecover: static_cast<void>(replay.Recover()); break;
  }
}

/// @param requests  a row's Asked, MotionGeneratorMode and ControllerMode.
void Advance(run::CommandReplay& replay, const BlockOf<const std::uint8_t, 3>& requests,
             const BlockOf<const bool>& present,
             const BlockOf<const double, kCommandSize>& commands,
             const BlockOf<double, kStateSize>& states,
             const BlockOf<std::uint64_t, kCodes>& codes) {
  const std::size_t rows = present.shape(0);
  if (requests.shape(0) != rows || commands.shape(0) != rows || states.shape(0) != rows ||
      codes.shape(0) != rows) {
    throw InputError("advance: all arrays must have the same number of rows");
  }
  const GilReleased release;
  for (std::size_t i = 0; i < rows; ++i) {
    Ask(replay, requests.data() + 3 * i);
    const RobotCommand command = CommandOf(commands.data() + kCommandSize * i);
    const record::CycleRecord& record = replay.Cycle(present.data()[i] ? &command : nullptr);
    PutState(record, states.data() + kStateSize * i, codes.data() + kCodes * i);
  }
}

/// INT's estimates from measured rows of 1 kHz, with end effector, load and frames of a scenario.
class ExternalTorque {
 public:
  static constexpr Py_ssize_t kSize = 7 + 6;  ///< tau_ext_hat_filtered, O_F_ext_hat_K

  explicit ExternalTorque(const LoadedScenario& loaded)
      : ExternalTorque(run::MakeRobotConfig(
                           loaded.scenario,
                           scenario::LoadRobotData(Files().models, loaded.scenario.robot.model,
                                                   loaded.scenario.robot.hand),
                           Files())
                           .onboard) {}

  /// Rows that follow those of the last call. @param anew  rows at which the estimate begins at
  /// zero, as after a gap.
  void Advance(const BlockOf<const double, 7>& q, const BlockOf<const double, 7>& dq,
               const BlockOf<const double, 7>& tau_J, const BlockOf<const bool>& anew,
               const BlockOf<double, kSize>& out) {
    const std::size_t rows = q.shape(0);
    if (dq.shape(0) != rows || tau_J.shape(0) != rows || anew.shape(0) != rows ||
        out.shape(0) != rows) {
      throw InputError("external torque: all arrays must have the same number of rows");
    }
    const GilReleased release;
    for (std::size_t i = 0; i < rows; ++i) {
      JointSensors sensors;
      std::copy_n(q.data() + kJoints * i, kJoints, sensors.q.begin());
      std::copy_n(dq.data() + kJoints * i, kJoints, sensors.dq.begin());
      std::copy_n(tau_J.data() + kJoints * i, kJoints, sensors.tau_J.begin());
      Add(sensors, anew.data()[i], out.data() + kSize * i);
    }
  }

 private:
  explicit ExternalTorque(const onboard::OnboardConfig& config)
      : setup_(onboard::SetupOf(config)),
        gain_max_(config.sensing.wrench_gain_max),
        arm_(config.arm),
        observer_(config.arm, config.sensing.observer_gain) {}

  void Add(const JointSensors& sensors, bool anew, double* out) noexcept {
    const onboard::MeasuredArm arm(arm_, sensors.q, setup_);
    if (anew || is_new_) observer_.Reset(sensors, arm.q);
    is_new_ = false;
    observer_.Update(sensors, arm.q, setup_.payload);
    const JointVector& tau = observer_.tau_ext_hat();
    const onboard::ExternalWrench wrench =
        onboard::EstimateWrench(tau, arm.EE.J, arm.EE.O_T_frame, setup_.EE_T_K, gain_max_);
    std::ranges::copy(wrench.O_F_ext_hat_K, std::ranges::copy(tau, out).out);
  }

  onboard::ArmSetup setup_;
  double gain_max_;
  model::ArmModel arm_;
  onboard::ExternalTorqueObserver observer_;
  bool is_new_ = true;
};

}  // namespace

void AddReplay(nb::module_& module) {
  nb::class_<run::CommandReplay>(module, "CommandReplay")
      .def(
          "__init__",
          [](run::CommandReplay* self, const LoadedScenario& loaded, std::uint64_t seed,
             const std::optional<JointVector>& q_start) {
            scenario::Scenario scenario = loaded.scenario;
            scenario.seed = seed;
            const GilReleased release;
            new (self) run::CommandReplay(scenario, Files(), q_start);
          },
          nb::arg("scenario"), nb::arg("seed"), nb::arg("q_start") = nb::none())
      .def("advance", &Advance, nb::arg("requests"), nb::arg("present"), nb::arg("commands"),
           nb::arg("states"), nb::arg("codes"));
  nb::class_<ExternalTorque>(module, "ExternalTorque")
      .def(nb::init<const LoadedScenario&>(), nb::arg("scenario"))
      .def("advance", &ExternalTorque::Advance, nb::arg("q"), nb::arg("dq"), nb::arg("tau_J"),
           nb::arg("anew"), nb::arg("out"));
  module.def("error_names", [] {
    std::vector<std::string> names;  // of bits 0, 1, 2, ...
    for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
      names.emplace_back(Name(static_cast<RobotError>(i)));
    }
    return names;
  });
}

}  // namespace twin::python
