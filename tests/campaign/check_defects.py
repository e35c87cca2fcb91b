#!/usr/bin/env python3
"""Seeds defects, one at a time, and tells which world of the campaign first finds each. Fails when none does.

    check_defects.py SOURCE BUILD [NAME]      NAME: only defects whose name contains it

How: tests/support/mutants.py.
"""

import pathlib
import re
import subprocess
import sys
import tempfile

TESTS = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTS / "support"), str(TESTS / "conformance")]

import check_mutants  # noqa: E402
import mutants  # noqa: E402

FOLDER = TESTS / "campaign/found"
PROGRAM = "panda-twin-campaign"
WORLDS = 20000

# Defects of INT, by their names in tests/conformance/check_mutants.py.
OF_INT = (
    "a loss holds velocity, not acceleration",
    "21 losses for 20",
    "joint acceleration unchecked",
    "joint jerk unchecked",
    "the success rate counts losses as served",
    "reflex_reason not set",
    "commands of any state count",
    "braking without a limit of jerk",
    "a Cartesian loss holds the velocity",
    "joint position filter off",
    "torque rate unchecked",
)

# All others: name, file, text, its replacement.
OTHERS = (
    ("an old command is written again", "src/loop/communication_loop.cc",
     "command_ = Compute(state_, ReadAt(state_, read), cost_);",
     "if (const RobotCommand* next = Compute(state_, ReadAt(state_, read), cost_)) command_ = next;"),
    ("an anomalous state is answered", "src/loop/control_tick.cc", "  if (anomalous_) {", "  if (false) {"),
    ("lost states are no cycles of the chain", "src/loop/control_tick.cc", "cycles_ += record_.skipped_states + 1;", "cycles_ += 1;"),
    ("the last command finishes one tick early", "src/loop/command_chain.cc",
     "if (keeps_limits && !Rests(state)) return false;", ""),
    ("a stall is noticed one cycle late", "src/loop/command_chain.cc",
     "waited_ = fresh ? 0 : waited_ + cycles;", "waited_ = fresh ? 0 : waited_ + cycles - (waited_ == 0 ? 1 : 0);"),
    ("the controller's clock drifts the other way", "src/loop/wake_grid.cc",
     "ToSeconds(now.time_since_epoch()) * speed_", "ToSeconds(now.time_since_epoch()) / speed_"),
    ("the rate matcher averages one cycle too many", "src/reference/moving_average.cc",
     "std::ceil(kCycleRateHz / source_rate_hz - kHair)", "std::ceil(kCycleRateHz / source_rate_hz + kHair)"),
    ("the generator corrects away from the target", "src/reference/reference_generator.cc",
     "lambda_ * (target.q[j] - q_d[j])", "lambda_ * (q_d[j] - target.q[j])"),
    ("rejoining adds the source's acceleration", "src/reference/rejoining_generator.cc", "Scalar(ddq_d[i] - a)", "Scalar(ddq_d[i] + a)"),
    ("of several arms only the first is pushed", "src/plant/engine_world.cc",
     "for (EngineArm& arm : arms_) arm.Apply(time(), *model_, *data_);", "arms_.front().Apply(time(), *model_, *data_);"),
    ("a step of several arms does not wait for the last", "src/plant/engine_world.cc", "if (here_ < PresentArms()) {", "if (here_ + 1 < PresentArms()) {"),
    ("a stalled source goes on", "src/reference/resampler.cc",
     "if (stopped_ || count_ == 1) return knots_[count_ - 1].x;", "if (count_ == 1) return knots_[count_ - 1].x;"),
    ("the viability filter leaves joint 7 out", "src/reference/viability_filter.cc",
     "const auto instead = Instead(i, x, ViableAxis::JerkToPosition(x, q_c[i]));",
     "const auto instead = i == 6 ? std::nullopt : Instead(i, x, ViableAxis::JerkToPosition(x, q_c[i]));"),
    ("the viability filter is made for one loss fewer", "src/reference/viability_filter.cc",
     "axes_.emplace_back(BoundsOf(limits, i), lost,", "axes_.emplace_back(BoundsOf(limits, i), lost > 0 ? lost - 1 : 0,"),
    ("an FR3's viability filter takes its velocity limits for constant", "src/reference/viability_filter.cc",
     ".deceleration = limits.deceleration[joint]", ".deceleration = 0 * limits.deceleration[joint]"),
    ("torques are not limited", "src/reference/rate_limiter.cc",
     "std::clamp(rate, -limits.dtau_max[j], limits.dtau_max[j]) * kT", "rate * kT"),
    ("a state that came is taken again", "src/robot/link.cc",
     "if (state.message_id <= newest_.message_id) return;", "if (state.message_id < newest_.message_id) return;"),
    ("INT's clock drifts the other way", "src/robot/robot.cc", "std::llround(own / clock_speed_)", "std::llround(own * clock_speed_)"),
    ("commands count until the cycle", "src/robot/robot.cc", "now - d_INT_", "now"),
    ("buttons are one cycle late", "src/robot/robot.cc",
     "config_.panel[live_.next_panel_event].at <= now", "config_.panel[live_.next_panel_event].at < now"),
    ("a burst is one longer", "src/faults/loss_model.cc",
     "number - std::prev(after)->first < std::prev(after)->count", "number - std::prev(after)->first <= std::prev(after)->count"),
    ("losses know no seed", "src/faults/loss_model.cc", "loss_(seed, loss)", "loss_(1, loss)"),
    ("a copy comes before the message", "src/faults/message_fate.cc",
     "fate.duplicate_delay = fate.delay + config_", "fate.duplicate_delay = config_"),
    ("the least delay is left out", "src/faults/delay_model.cc",
     "return log_normal.offset + FromSeconds(", "return FromSeconds("),
    ("a command to the hand is lost while one runs", "src/run/scripts.cc",
     "++next_) Begin(next_, now);", "++next_) if (!running_) Begin(next_, now);"),
    ("the longest loss is the last", "src/run/cycle_summary.cc",
     "longest_loss = std::max<std::uint64_t>(longest_loss, record.lost_in_row);", "longest_loss = record.lost_in_row;"),
    ("skipped states are counted as ticks", "src/loop/communication_loop.cc",
     "timings_.skipped_states += record.skipped_states;", "timings_.skipped_states += record.skipped_states != 0 ? 1 : 0;"),
    ("the log's last records are not written", "src/record/recorder.cc", "    if (Drain() > 0) continue;\n    if (last) return;",
     "    if (last) return;\n    if (Drain() > 0) continue;"),
    ("the log has no stalls", "src/record/log_encoder.cc", "  tick_.set_stalled(record.stalled);\n", ""),
    ("a served FR3 numbers its answers as a Panda", "src/fci/answers.cc",
     "return protocol == Protocol::k10 && status < numbers.size() ? numbers[status] : status;", "return numbers.empty() || protocol == Protocol::k5 ? status : status;"),
    ("an FR3 has no motion of torques alone", "src/onboard/onboard_controller.cc",
     "return is_external && !modes.asynchronous;", "return is_external && modes.asynchronous.has_value();"),
    ("each motion's end is a success", "src/fci/arm_session.cc",
     "Answer(ArmCommand::kMove, *std::exchange(move_, {}), progress.last_end);",
     "Answer(ArmCommand::kMove, *std::exchange(move_, {}), MoveStatus::kSuccess);"),
    ("a client's end leaves its motion", "src/fci/arm_session.cc", "if (move_) service_.StopMove();", ""),
    ("an idle robot's states are refused", "src/fci/datagrams.cc",
     "static_cast<std::uint8_t>(ControllerMode::kOther)", "static_cast<std::uint8_t>(ControllerMode::kExternalController)"),
    ("a deviation that is no number is taken", "src/server/arm_request_handler.cc",
     "std::isfinite(most) && most >= 0", "!(most < 0)"),
    ("a recovery is answered before it ends", "src/server/control_request.cc", " || verb == ControlVerb::kRecover", ""),
    ("a step is one cycle longer", "src/robot/answer_paced_robot.cc",
     "compare_exchange_strong(paused, cycles, std", "compare_exchange_strong(paused, cycles + 1, std"),
    ("a grasp of nothing is a success", "src/onboard/gripper.cc",
     "End(InsideBand() ? HandResult::kSuccess : HandResult::kUnsuccessful)", "End(HandResult::kSuccess)"),
    ("a suction of nothing is a success", "src/onboard/vacuum_pump.cc", "End(HandResult::kUnsuccessful);", "End(HandResult::kSuccess);"),
    ("an FR3's own motions use the limits of commands", "src/onboard/motion_generator.cc",
     "*asynchronous_, own_limits())", "*asynchronous_, limits_.joints)"),
    ("a goal beyond a joint's range is taken", "src/onboard/motion_generator.cc",
     "  if (!found.empty()) return found;\n  goal_ = q_c;", "  goal_ = q_c;"),
    ("the guard looks at commands alone", "src/onboard/onboard_guard.cc",
     "  if (found.empty()) found = CheckStopOf(next);\n", ""),
    ("the workstation's guard sees nothing", "src/loop/limit_guard.cc", "if (!breach_) breach_ = Check(state, command);", ""),
    ("a plan takes boxes for half as large", "src/planning/shape_pairs.cc",
     "std::abs(along) - half[k]", "std::abs(along) - half[k] / 2"),
    ("a late command is not counted", "src/onboard/command_inbox.cc", "      ++dropped_;\n    } else {", "    } else {"),
    ("who asks last operates", "src/page/operator_server.cc", "} else if (operator_ == 0) {", "} else if (operator_ < client.number) {"),
    ("a silent operator keeps control", "src/page/operator_server.cc", "now - heard_ > config_.silence", "now - heard_ > 10 * config_.silence"),
    ("states go to who shows no token", "src/page/operator_server.cc",
     "if (client.is_authenticated && client.connection->waiting() < kBehind)\n      client.connection->Send(state);", "client.connection->Send(state);"),
    ("a motion's start is not noted", "src/server/arm_request_handler.cc", "      in_motion_ = true;\n", ""),
    ("no motion finishes", "src/loop/command_chain.cc", "  return arrived;\n", "  return arrived && state.q[0] > 100;\n"),
    ("the joints are a tenth as stiff", "src/onboard/joint_impedance.cc",
     "K_theta_[i] * (reference.q_d[i] - q[i])", "K_theta_[i] / 10 * (reference.q_d[i] - q[i])"),
    ("the log has no accelerometers", "src/record/log_encoder.cc",
     "  Encode(state.accelerometer_top, state.accelerometer_bottom, cycle_);\n", ""),
)

# Those that the campaign found, put back: name, the scenarios in found/ that show it, and changes: file, text, its replacement.
FOUND = (
    ("cartesian_pose stops too late, and INT's ramp leaves a joint's range", ("world_18842",),
     ("controllers/cartesian_pose.cc", "if (!IsInRange(j, at_rest))", "if (false)"),
     ("src/onboard/onboard_cycle.cc", "    if (!violations_.empty()) return;\n  }\n  generator_ = next;", "    violations_ = {};\n  }\n  generator_ = next;")),
    # Once one has finished, a count beyond any motion's makes all others finish.
    ("a command that is lost finishes those after it", ("world_92718", "world_97131"),
     ("src/loop/control_tick.cc", "chain_.Finish(state, finished_for_ > kSourceRests, record_.command);",
      "(finished_for_ > 1000000 || (chain_.Finish(state, finished_for_ > kSourceRests, record_.command) && (finished_for_ += 1000000) != 0));")),
    ("an emergency stop in a session's first sample is none", ("world_22376",),
     ("src/teleop/mapping.cc", "  const bool turns_joints = JointOf(sample) != 0;\n",
      "  if (last_.sequence == 0) last_ = sample;\n  const bool turns_joints = JointOf(sample) != 0;\n")),
    ("poses along joints' waypoints keep no limit of the end effector", ("world_426851", "world_429961"),
     ("src/run/resolve.cc", "  if (stretch == 1) return trajectory;", "  if (stretch > 0) return trajectory;"),
     ("src/run/prepared_motion.cc", "  RequireEndEffectorWithinLimits(robot.cartesian, F_T_EE_, motion_);\n", "")),
    ("the last command is a step", ("world_167652",),
     ("src/loop/command_chain.cc", "  if (arrived && keeps_limits) stages_->Settle(state, command);\n", "")),
    ("a tick that sends nothing records a command", ("world_593",),
     ("src/loop/control_tick.cc", "    if (chain_.sends()) return &record_.command;\n    record_.command = RobotCommand();\n    return nullptr;",
      "    return chain_.sends() ? &record_.command : nullptr;")),
)


def first_finding(program):
    """(seed of the world, name of the invariant); None: no world found anything."""
    done = subprocess.run([program, "--worlds", str(WORLDS), "--first", "--patience", "100", "--out", program.parent], capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return None
    found = re.search(r"^world (\d+) violates the invariant ([a-z]+)", done.stdout, re.MULTILINE)
    if not found:
        raise RuntimeError(f"{program} ended with {done.returncode}: {done.stderr}")
    return found.groups()


def shows(program, name):
    """Whether a scenario in found/ violates the invariant that its description names."""
    scenario = FOLDER / f"{name}.yaml"
    invariant = re.search(r"violates the invariant ([a-z]+)", scenario.read_text())[1]
    done = subprocess.run([program, scenario, "--patience", "100"], capture_output=True, text=True, check=False)
    return f" violates the invariant {invariant}:" in done.stdout


def main():
    source, build = map(pathlib.Path, sys.argv[1:3])
    only = sys.argv[3] if len(sys.argv) > 3 else ""
    built = mutants.Build(source, build, "tests/campaign")

    def with_changes(find, *changes):
        with tempfile.TemporaryDirectory() as folder:
            scratch = pathlib.Path(folder)
            objects = []
            for number, (file, old, new) in enumerate(changes):
                (scratch / str(number)).mkdir()
                objects.append(str(built.compile(file, built.read(file, old).replace(old, new), scratch / str(number))))
            return find(built.link(PROGRAM, changes[0][0], " ".join(objects), scratch))

    mutants_of_int = {name: (check_mutants.path_of(file), old, new) for name, file, old, new in check_mutants.MUTANTS}
    seeded = {name: mutants_of_int[name] for name in OF_INT} | {name: change for name, *change in OTHERS}
    if not any(only in name for name in [*seeded, *(name for name, *_ in FOUND)]):
        raise SystemExit(f"no defect has a name with {only!r}")
    missed = 0
    for name, change in seeded.items():
        if only in name:
            found = with_changes(first_finding, change)
            print(f"{name}: " + ("world {}, by {}".format(*found) if found else "NOT FOUND"), flush=True)
            missed += not found
    for name, scenarios, *changed in FOUND:
        if only in name:
            found = with_changes(lambda program, names=scenarios: all(shows(program, each) for each in names), *changed)
            print(f"{name}: " + ("shown by " if found else "NOT SHOWN by ") + ", ".join(scenarios), flush=True)
            missed += not found
    if {path.stem for path in FOLDER.glob("*.yaml")} != {each for _, scenarios, *_ in FOUND for each in scenarios}:
        print("found/ and the list of what the campaign found name other scenarios")
        missed += 1
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
