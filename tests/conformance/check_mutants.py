#!/usr/bin/env python3
"""Mutants of INT and the tests of this folder that must catch them.

    check_mutants.py --source ROOT --build DIR [--quick] [--only NAME] [--all]

How: tests/support/mutants.py.
"""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))

import mutants  # noqa: E402

# Program and arguments, cheapest first.
CATCHERS = [
    ("conformance_tests", ["conformance_error_table_test"]),
    ("random_streams", ["--streams", "1000", "--seed", "1"]),
    ("conformance_tests", ["conformance_modes_test"]),
]


def path_of(file):
    """Of a mutant's file, below the root."""
    return file if "/" in file else "src/onboard/" + file


def scaled(limits, factor):
    """C++ for the limits of all joints times a factor."""
    return f"[&] {{ JointVector v = {limits}; for (double& x : v) x *= {factor}; return v; }}()"


# name, file below src/onboard (or the root), text, its replacement
MUTANTS = [
    *[(f"joint {what} limit {how}", "limit_monitor.cc", f"next.{value}, limits.{limit}",
       f"next.{value}, {scaled(f'limits.{limit}', factor)}")
      for what, value, limit in [("acceleration", "ddq_d", "ddq_max"), ("jerk", "dddq_d", "dddq_max")]
      for how, factor in [("1 % wider", "1.01"), ("1 % narrower", "0.99"), ("without tolerance", "(1 - 1e-7)")]],
    *[(f"joint velocity limit {how}", "limit_monitor.cc", "IsWithin(std::abs(dq), limit)",
       f"IsWithin(std::abs(dq), limit * {factor})")
      for how, factor in [("1 % wider", "1.01"), ("1 % narrower", "0.99"), ("without tolerance", "(1 - 1e-7)")]],
    ("joint velocity limit of the position after the step", "limit_monitor.cc", "next.q_d[i] - dq * kCycleSeconds", "next.q_d[i]"),
    ("joint jerk unchecked", "limit_monitor.cc",
     "CheckJointMagnitudes(errors.jerk, next.dddq_d, limits.dddq_max, message_id, found);", ""),
    ("joint acceleration unchecked", "limit_monitor.cc",
     "CheckJointMagnitudes(errors.acceleration, next.ddq_d, limits.ddq_max, message_id, found);", ""),
    ("joint velocity unchecked", "limit_monitor.cc",
     "CheckVelocities(errors.velocity, next, limits, message_id, found);", ""),
    ("joint position unchecked", "limit_monitor.cc",
     "CheckJointRanges(errors.position, next.q_d, limits.q_min, limits.q_max, message_id, found);", ""),
    ("lower position limit unchecked", "limit_monitor.cc", "next.q_d, limits.q_min,",
     f"next.q_d, {scaled('limits.q_min', 1000)},"),
    ("envelope reported beside discontinuity", "limit_monitor.cc",
     "  if (!found.empty()) return found;\n  CheckVelocities(errors.velocity",
     "  CheckVelocities(errors.velocity"),
    ("torque rate 1 % wider", "limit_monitor.cc",
     "rate[i] = (tau_d[i] - tau_J_d[i]) / kCycleSeconds", "rate[i] = 0.99 * (tau_d[i] - tau_J_d[i]) / kCycleSeconds"),
    ("a loss holds velocity, not acceleration", "joint_reference.cc",
     "return AfterAcceleration(ddq_d);", "return AfterAcceleration(JointVector{});"),
    ("a loss holds the position", "joint_reference.cc", "return AfterAcceleration(ddq_d);", "return Rest(q_d);"),
    ("21 losses for 20", "onboard_cycle.cc",
     "losses_.lost_in_row() >= config_.abort_after_lost", "losses_.lost_in_row() > config_.abort_after_lost"),
    ("a finished command unchecked", "onboard_cycle.cc",
     "found = next.CheckStandingStill(message_id_ + 1);", ""),
    ("torque rate unchecked", "onboard_cycle.cc", "  found.Add(torque);", ""),
    ("StopMove's ramp unchecked", "onboard_cycle.cc", "  if (modes_.controller != ControllerMode::kExternalController) {", "  if (false) {"),
    ("what is measured unchecked", "onboard_cycle.cc",
     "sensing_.CheckMeasured(tau_J_d_, message_id_ + 1, IsCartesian(modes_.generator))", "Violations()"),
    ("collisions ignored", "onboard_cycle.cc", "violations_ = sensing_.Collisions(message_id_ + 1);", ""),
    ("reflex_reason not set", "onboard_cycle.cc", "if (phase_ != Phase::kNone) reflex_reason_ = errors_;", ""),
    ("the success rate counts losses as served", "onboard_cycle.cc", "losses_.CountLost();", "losses_.CountServed();"),
    ("recovery while the arm moves", "onboard_controller.cc",
     "case Verdict::kGrantedAtRest: return generator_.AtRest();", "case Verdict::kGrantedAtRest: return true;"),
    ("recovery keeps the errors", "onboard_controller.cc", "  errors_.reset();\n", ""),
    ("recovery keeps collisions latched", "onboard_controller.cc", "  sensing_.ClearCollisions();\n", ""),
    ("a new motion keeps reflex_reason", "onboard_controller.cc", "  reflex_reason_.reset();\n", ""),
    ("bad settings accepted", "onboard_controller.cc",
     "if (FindBadValue(setting)) return SetterStatus::kInvalidArgumentRejected;", ""),
    ("motions start at singular poses", "onboard_controller.cc",
     "if (IsCartesian(modes.generator) && generator_.IsSingular()) {", "if (false) {"),
    ("elbow sign unchecked", "motion_generator.cc",
     "return CheckElbowSign(command.elbow_c[1], model::ElbowOf(joints_.q_d)[1], message_id);", "return found;"),
    ("start elbow checked in the first cycle only", "motion_generator.cc", "  if (!has_elbow_) {", "  if (is_first) {"),
    ("start pose unchecked", "motion_generator.cc",
     "found = CheckStartPose(next.O_T_EE_c, cartesian_.O_T_EE_c, tolerance, message_id);", ""),
    ("frame unchecked", "motion_generator.cc",
     "const Violations found = CheckFrame(command.O_T_EE_c, message_id);", "const Violations found;"),
    ("inverse kinematics unchecked", "motion_generator.cc",
     "CheckStep(joints, limits_.joints, message_id, kInverseKinematicsErrors);\n  if (!found.empty()) return found;",
     "CheckStep(joints, limits_.joints, message_id, kInverseKinematicsErrors);\n  if (false) return found;"),
    ("joint side before Cartesian side", "motion_generator.cc", "if (!beyond.empty()) return beyond;",
     "if (beyond.items().size() > 1) return beyond;"),
    ("joint position filter off", "motion_generator.cc",
     "filters_.joint_position.Filter(command.q_c, joints_.q_d)", "command.q_c"),
    ("the elbow of a lost cycle stays", "motion_generator.cc",
     "AdvanceCartesian(cartesian_.AfterLoss(), has_elbow_, message_id)",
     "AdvanceCartesian(cartesian_.AfterLoss(), false, message_id)"),
    *[(f"limit of the {what} 1 % {how}", "cartesian_monitor.cc", f"!IsWithin({value}, {limit})",
       f"!IsWithin({value}, {factor} * {limit})")
      for what, value, limit in [("translation", "v", "v_max"), ("rotation", "w", "w_max"),
                                 ("elbow", "std::abs(values.elbow)", "elbow_max")]
      for how, factor in [("wider", "1.01"), ("narrower", "0.99")]],
    ("elbow motion unchecked", "cartesian_monitor.cc",
     "has_elbow && !IsWithin(std::abs(values.elbow), elbow_max)", "false"),
    ("elbow range unchecked", "cartesian_monitor.cc",
     "if (has_elbow) CheckElbowRange(next.elbow_c[0], joints, message_id, found);", ""),
    ("rotation unchecked", "cartesian_monitor.cc", "} else if (!IsWithin(w, w_max)) {", "} else if (false) {"),
    ("a Cartesian loss holds the velocity", "cartesian_reference.cc",
     "next.O_dP_EE_c[i] += kT * O_ddP_EE_c[i];", ""),
    ("braking without a limit of jerk", "joint_reference.cc",
     "std::clamp(against * x, ddq - d, ddq + d)", "(ddq != d ? against * x : 0.0)"),
    ("braking 1 % too hard", "joint_reference.cc", "std::min(InverseRampSum(std::abs(dq) / kT, d, a_max), a_max)",
     "std::min(InverseRampSum(std::abs(dq) / kT, d, 1.01 * a_max), 1.01 * a_max)"),
    ("braking at half the acceleration", "joint_reference.cc",
     "std::min(InverseRampSum(std::abs(dq) / kT, d, a_max), a_max)",
     "0.5 * std::min(InverseRampSum(std::abs(dq) / kT, d, a_max), a_max)"),
    ("power without gravity", "measured_monitor.cc", "(tau_J_d[i] + g[i])", "tau_J_d[i]"),
    ("measured speed 1 % wider", "measured_monitor.cc", "if (!IsWithin(v, v_max_))", "if (!IsWithin(v, 1.01 * v_max_))"),
    ("parts thinner by a tenth", "src/model/self_collision.cc", "kCapsules[k].radius + kCapsules[l].radius",
     "0.9 * (kCapsules[k].radius + kCapsules[l].radius)"),
    ("the hand meets no forearm", "src/model/self_collision.cc", "for (std::size_t l = kForearm; l <= kForearmTaper; ++l)",
     "for (std::size_t l = kForearm; l < kForearm; ++l)"),
    ("half the clearance", "measured_monitor.cc", "if (measured.self_distance < clearance_)", "if (measured.self_distance < 0.5 * clearance_)"),
    ("collision thresholds of the wrong phase", "contact_monitor.cc",
     "accelerates_ ? behavior_.upper_force_acc : behavior_.upper_force_nominal",
     "accelerates_ ? behavior_.upper_force_nominal : behavior_.upper_force_acc"),
    ("collisions not latched", "contact_monitor.cc", "if (IsAbove(values[i], upper[i])) collision[i] = 1;",
     "collision[i] = IsAbove(values[i], upper[i]) ? 1 : 0;"),
    ("external wrench of the wrong sign", "external_wrench.cc",
     "const Column6 at_EE = share * inverse.Times(", "const Column6 at_EE = -share * inverse.Times("),
    ("commands of any state count", "command_inbox.cc", "if (command.message_id < oldest_id || command.message_id > answered_id) {",
     "if (command.message_id > answered_id) {"),
    ("of several commands the oldest counts", "command_inbox.cc", "      chosen = &command;",
     "      if (chosen == nullptr) chosen = &command;"),
]

QUICK = ["joint acceleration limit 1 % wider", "a loss holds velocity, not acceleration", "elbow sign unchecked"]

if __name__ == "__main__":
    mutants.main(__doc__, "tests/conformance", CATCHERS, [(name, path_of(file), *change) for name, file, *change in MUTANTS],
                 QUICK)
