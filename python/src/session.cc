#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "arrays.h"
#include "bindings.h"
#include "state.h"
#include "twin/core/error_catalogue.h"
#include "twin/core/hash.h"
#include "twin/scenario/robot_data.h"
#include "twin_session.h"

namespace twin::python {
namespace {

const nb::call_guard<GilReleased> kReleased;

double SecondsAt(Time time) {
  return ToSeconds(time.time_since_epoch());
}

std::vector<reference::Waypoint> WaypointsFrom(nb::handle rows,
                                               const std::optional<std::vector<double>>& times) {
  std::vector<reference::Waypoint> waypoints;
  for (const nb::handle row : nb::iter(rows)) {
    const std::size_t i = waypoints.size();
    const std::string where = fmt::format("waypoint {}", i + 1);
    reference::Waypoint& point = waypoints.emplace_back();
    point.q = JointsFrom(row, where + ": q, rad");
    if (times && i < times->size()) point.at = SecondsFrom((*times)[i], where + ": time, s,");
  }
  if (times && times->size() != waypoints.size()) {
    throw nb::value_error(fmt::format("times: there are {} for {} waypoints; give one for each",
                                      times->size(), waypoints.size())
                              .c_str());
  }
  return waypoints;
}

void AddTrajectory(nb::module_& module) {
  using reference::Trajectory;
  nb::class_<Trajectory>(module, "Trajectory", "See panda_twin.Trajectory.")
      .def(
          "__init__",
          [](Trajectory* self, const ArrayLike& waypoints,
             const std::optional<std::vector<double>>& times, std::optional<double> duration,
             double velocity, double acceleration, double jerk) {
            reference::Timing timing{
                .velocity_scale = velocity, .acceleration_scale = acceleration, .jerk_scale = jerk};
            if (duration) timing.duration = SecondsFrom(*duration, "duration, s,");
            const JointLimits limits =
                scenario::LoadRobotData(Files().models, "panda", plant::HandKind::kFrankaHand)
                    .limits;
            new (self) Trajectory(WaypointsFrom(waypoints, times), timing, limits);
          },
          nb::arg("waypoints"), nb::arg("times").none(), nb::arg("duration").none(),
          nb::arg("velocity_scale"), nb::arg("acceleration_scale"), nb::arg("jerk_scale"))
      .def_prop_ro("duration", [](const Trajectory& self) { return ToSeconds(self.duration()); })
      .def_prop_ro("start", [](const Trajectory& self) { return ArrayOf(self.start()); })
      .def_prop_ro("goal", [](const Trajectory& self) { return ArrayOf(self.goal()); })
      .def(
          "sample",
          [](const Trajectory& self, double time) {
            const reference::JointTarget target = self.Sample(SecondsFrom(time, "time, s,", -kDay));
            return nb::typed<nb::tuple, Array, Array, Array>(
                nb::make_tuple(ArrayOf(target.q), ArrayOf(target.dq), ArrayOf(target.ddq)));
          },
          nb::arg("time"));
}

void AddMotionResult(nb::module_& module) {
  nb::class_<Violation>(module, "Violation", "An error with the value that broke a limit.")
      .def_prop_ro("error", [](const Violation& self) { return std::string(Name(self.error)); })
      .def_prop_ro(
          "joint",
          [](const Violation& self) {
            const bool is_joint = EntryOf(self).axis == AxisKind::kJoint && self.axis >= 0;
            return is_joint ? std::optional<int>(self.axis + 1) : std::nullopt;
          },
          "1 to 7; None: the error is not one of a joint.")
      .def_prop_ro(
          "axis", [](const Violation& self) { return AxisName(self); },
          "\"joint 2\", \"rotation\", \"z of K\", or \"\".")
      .def_ro("value", &Violation::value, "In `unit`.")
      .def_ro("limit", &Violation::limit, "The bound it broke, signed like the value.")
      .def_prop_ro("unit", [](const Violation& self) { return std::string(UnitOf(self)); })
      .def_ro("cycle", &Violation::message_id, "message_id of the state of the cycle.")
      .def("__str__", [](const Violation& self) { return Describe(self); });
  using run::MotionResult;
  nb::class_<MotionResult>(module, "MotionResult", "How a motion went.")
      .def_ro("name", &MotionResult::name)
      .def_prop_ro(
          "begun", [](const MotionResult& self) { return SecondsAt(self.begun); },
          "Time of the session, s.")
      .def_prop_ro(
          "ended", [](const MotionResult& self) { return ToSeconds(self.report.simulated); },
          "Time of the session at which the arm rested, s.")
      .def_prop_ro(
          "planned", [](const MotionResult& self) { return ToSeconds(self.planned); },
          "Duration of the planned motion, s.")
      .def_prop_ro("succeeded", [](const MotionResult& self) { return self.report.succeeded(); })
      .def_prop_ro(
          "end", [](const MotionResult& self) { return std::string(NameOf(self.report.end)); },
          "\"success\", \"aborted\", \"preempted\", \"user_stopped\" or \"none\".")
      .def_prop_ro(
          "failure", [](const MotionResult& self) { return self.report.failure; },
          "Why it failed; \"\": it did not.")
      .def_prop_ro(
          "errors", [](const MotionResult& self) { return NamesOf(self.report.errors); },
          "Names of the errors that ended it.")
      .def_prop_ro("violations", [](const MotionResult& self) { return self.report.violations; })
      .def_prop_ro(
          "q_final", [](const MotionResult& self) { return ArrayOf(self.report.q_final); },
          "(7,): measured joint positions at the end, rad.")
      .def_prop_ro(
          "goal", [](const MotionResult& self) { return ArrayOf(self.goal); },
          "(7,): the last waypoint, rad; of control(): where it began.")
      .def_ro("final_error", &MotionResult::final_error,
              "Largest distance of a joint from the goal at the end, rad.")
      .def_prop_ro(
          "cycles_served", [](const MotionResult& self) { return self.counts.served; },
          "Cycles with a command in time.")
      .def_prop_ro(
          "cycles_held", [](const MotionResult& self) { return self.counts.held; },
          "Cycles without one.")
      .def_prop_ro(
          "longest_loss", [](const MotionResult& self) { return self.counts.longest_loss; },
          "Most held cycles in a row.")
      .def("__repr__", [](const MotionResult& self) {
        const bool succeeded = self.report.succeeded();
        return fmt::format(
            "<MotionResult {}{}{}: {:.3f} to {:.3f} s, final_error {:.2g} rad>", self.name,
            self.name.empty() ? "" : " ", succeeded ? "success" : "failed: " + self.report.failure,
            SecondsAt(self.begun), ToSeconds(self.report.simulated), self.final_error);
      });
}

void AddSessionResult(nb::module_& module) {
  using run::SessionResult;
  nb::class_<SessionResult>(module, "SessionResult", "How a session went.")
      .def_ro("motions", &SessionResult::motions, "Motions that were begun.")
      .def_prop_ro("cycles_served", [](const SessionResult& self) { return self.counts.served; })
      .def_prop_ro("cycles_held", [](const SessionResult& self) { return self.counts.held; })
      .def_prop_ro("commands_dropped",
                   [](const SessionResult& self) { return self.counts.dropped; })
      .def_prop_ro(
          "states_hash", [](const SessionResult& self) { return FormatHash(self.states_hash); },
          "Fingerprint of all states, as `panda-twin run` prints it.")
      .def_ro("unsound", &SessionResult::unsound, "Warnings of the simulation; \"\": none.")
      .def("__repr__", [](const SessionResult& self) {
        return fmt::format("<SessionResult: {} motions, {} cycles served, {} held, {}>",
                           self.motions, self.counts.served, self.counts.held,
                           FormatHash(self.states_hash));
      });
}

std::optional<int> VacuumOf(const std::optional<VacuumState>& pump) {
  return pump ? std::optional(pump->vacuum) : std::nullopt;
}

void AddHand(nb::module_& module) {
  using run::HandOutcome;
  nb::class_<HandOutcome>(module, "HandOutcome", "How a command to the hand ended.")
      .def_prop_ro("succeeded",
                   [](const HandOutcome& self) { return self.result == HandResult::kSuccess; })
      .def_prop_ro(
          "result",
          [](const HandOutcome& self) {
            return self.result ? std::string(Name(*self.result)) : std::string();
          },
          "\"success\", \"fail\", \"unsuccessful\" or \"aborted\"; \"\" when it was refused.")
      .def_ro("width", &HandOutcome::width, "Between the fingers as it ended, m.")
      .def_ro("is_grasped", &HandOutcome::is_grasped, "An object was held as it ended.")
      .def_prop_ro(
          "vacuum", [](const HandOutcome& self) { return VacuumOf(self.pump); },
          "Of a cobot pump as it ended, mbar; None of a hand with fingers.")
      .def_ro("failure", &HandOutcome::failure, "Why the hand refused it, or it was stopped.")
      .def("__repr__", [](const HandOutcome& self) {
        return fmt::format("<HandOutcome {}: width {:.4f} m{}>",
                           self.result ? Name(*self.result) : self.failure, self.width,
                           self.is_grasped ? ", grasped" : "");
      });
  nb::class_<HandState>(module, "HandState", "State of the hand.")
      .def_ro("width", &HandState::width, "Between the fingers, m.")
      .def_ro("max_width", &HandState::max_width, "From the last homing, m; 0 before.")
      .def_ro("is_grasped", &HandState::is_grasped, "An object is held.")
      .def_ro("temperature", &HandState::temperature, "Of the drive, degrees Celsius.")
      .def_prop_ro(
          "vacuum", [](const HandState& self) { return VacuumOf(self.pump); },
          "Of a cobot pump, mbar; None of a hand with fingers.")
      .def("__repr__", [](const HandState& self) {
        return fmt::format("<HandState: width {:.4f} of {:.4f} m{}>", self.width, self.max_width,
                           self.is_grasped ? ", grasped" : "");
      });
}

void AddMotions(nb::class_<TwinSession>& session) {
  session.def("move_own", &TwinSession::MoveOwn, kReleased)
      .def("move", &TwinSession::Move, nb::arg("trajectory"), nb::arg("interface"),
           nb::arg("impedance"), nb::arg("name"), kReleased)
      .def(
          "move_to",
          [](TwinSession& self, const ArrayLike& q, const std::string& interface, double velocity,
             double acceleration, double jerk, double clearance) {
            const JointVector goal = JointsFrom(q, "move_to: q, rad");
            const GilReleased released;
            return self.MoveTo(goal, interface,
                               {.velocity_scale = velocity,
                                .acceleration_scale = acceleration,
                                .jerk_scale = jerk},
                               clearance);
          },
          nb::arg("q"), nb::arg("interface"), nb::arg("velocity_scale"),
          nb::arg("acceleration_scale"), nb::arg("jerk_scale"), nb::arg("clearance"))
      .def(
          "control",
          [](TwinSession& self, nb::object law, std::optional<double> until,
             const std::string& impedance, const std::optional<std::string>& tick) {
            return self.Control(std::move(law), {until, impedance, tick});
          },
          nb::arg("law"), nb::arg("until").none(), nb::arg("impedance"), nb::arg("tick").none());
}

void AddHandCommands(nb::class_<TwinSession>& session) {
  session
      .def(
          "homing", [](TwinSession& self) { return self.Command(hand::Homing()); }, kReleased)
      .def(
          "move_hand",
          [](TwinSession& self, double width, double speed) {
            return self.Command(hand::Move{width, speed});
          },
          nb::arg("width"), nb::arg("speed"), kReleased)
      .def(
          "grasp",
          [](TwinSession& self, double width, double speed, double force, double inner,
             double outer) {
            return self.Command(hand::Grasp{width, speed, force, inner, outer});
          },
          nb::arg("width"), nb::arg("speed"), nb::arg("force"), nb::arg("epsilon_inner"),
          nb::arg("epsilon_outer"), kReleased)
      .def(
          "vacuum",
          [](TwinSession& self, std::uint8_t set_point, std::uint8_t profile,
             std::int64_t timeout_ms) {
            return self.Command(hand::Vacuum{set_point, profile, timeout_ms});
          },
          nb::arg("set_point"), nb::arg("profile"), nb::arg("timeout_ms"), kReleased)
      .def(
          "drop_off",
          [](TwinSession& self, std::int64_t timeout_ms) {
            return self.Command(hand::DropOff{timeout_ms});
          },
          nb::arg("timeout_ms"), kReleased)
      .def(
          "stop_hand", [](TwinSession& self) { return self.Command(hand::Stop()); }, kReleased)
      .def("hand_state", &TwinSession::ReadHand, kReleased);
}

void AddRest(nb::class_<TwinSession>& session) {
  session.def("wait", &TwinSession::Wait, nb::arg("seconds"), kReleased)
      .def("recover", &TwinSession::Recover, kReleased)
      .def(
          "reset",
          [](TwinSession& self, const ArrayLike& q) {
            const std::optional<JointVector> start =
                q.is_none() ? std::nullopt : std::optional(JointsFrom(q, "reset: q, rad"));
            const GilReleased released;
            self.Reset(start);
          },
          nb::arg("q").none())
      .def("user_stop", &TwinSession::PressUserStop, nb::arg("pressed"), kReleased)
      .def("bodies",
           [](TwinSession& self) {
             const auto bodies = [&self] {
               const GilReleased released;
               return self.Bodies();
             }();
             nb::typed<nb::dict, nb::str, Array> poses;
             for (const auto& [name, X_WB] : bodies) poses[name.c_str()] = ArrayOf(X_WB);
             return poses;
           })
      .def(
          "place",
          [](TwinSession& self, const std::string& body, const ArrayLike& pose) {
            const Transform X_WB = PoseFrom(pose, fmt::format("pose of \"{}\"", body));
            const GilReleased released;
            self.Place(body, X_WB);
          },
          nb::arg("body"), nb::arg("pose"))
      .def("save", &TwinSession::Save, kReleased)
      .def("restore", &TwinSession::Restore, nb::arg("snapshot"), kReleased)
      .def("close", &TwinSession::Close, kReleased)
      .def_prop_ro("closed", &TwinSession::is_closed)
      .def_prop_ro("result", &TwinSession::Result);
}

}  // namespace

void AddSession(nb::module_& module) {
  AddTrajectory(module);
  AddMotionResult(module);
  AddSessionResult(module);
  AddHand(module);
  nb::class_<Snapshot>(module, "Snapshot", "A copy of a session's whole twin; see Session.");
  nb::class_<TwinSession> session(module, "TwinSession", "See panda_twin.Session.");
  session.def(
      "__init__",
      [](TwinSession* self, std::optional<std::string> text, std::filesystem::path file,
         std::optional<std::uint64_t> seed, std::optional<std::string> lab,
         std::optional<std::filesystem::path> log) {
        new (self)
            TwinSession({std::move(text), std::move(file), seed, std::move(lab), std::move(log)});
      },
      nb::arg("text").none(), nb::arg("file"), nb::arg("seed").none(), nb::arg("lab").none(),
      nb::arg("log").none(), kReleased);
  session.def_prop_ro("name", &TwinSession::name);
  session.def("state", &TwinSession::State, kReleased).def("now", &TwinSession::Now, kReleased);
  AddMotions(session);
  AddHandCommands(session);
  AddRest(session);
}

}  // namespace twin::python
