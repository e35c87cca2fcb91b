#pragma once

#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "twin/core/error.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario::test {

/// A small scenario in which every key is given but those of TouchedText(); the tests break it in
/// one place each.
inline std::string FullText() {
  return R"(name: full
description: Everything said once.
seed: 42
backend: mujoco
drive: lockstep
loop: asynchronous
scene: scenes/floor.xml
robot:
  model: panda
  hand: none
  q_start: {unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}
  clock_drift: 5 ppm
plant:
  kind: ideal
  friction: breakaway
  armature: false
  noise: {q: 0.001 deg, dq: 0.002 rad/s, tau_J: 0.3 Nm}
link:
  state_delay: {log_normal: {median: 80 us, sigma: 0.3, offset: 20 us}}
  command_delay: {constant: 95.5 us}
  state_loss: 0.1 %
  command_loss: {gilbert_elliott: {good_to_bad: 0.1 %, bad_to_good: 25 %, loss_good: 0.01 %, loss_bad: 90 %}}
  state_duplication: {share: 1 %, delay: {gamma: {shape: 2, scale: 30 us, offset: 20 us}}}
  command_duplication: {share: 0.5 %, delay: 200 us}
  state_reordering: {share: 0.3 %, by: 1.5 ms}
  command_reordering: {share: 0.2 %, by: 2.5 ms}
  d_INT: 50 us
onboard:
  K_theta: {unit: Nm/rad, values: [3000, 3000, 3000, 2500, 2500, 2000, 1999.5]}
  damping_ratio: 0.7
  abort_after_lost: 19
  friction_compensation: 0.8
tick:
  generator: none
  lambda: 0.01
  rate_matching: false
  finish_tolerance: 0.0002 rad
  period_tolerance: 300 us
  low_pass: 100 Hz
  limiter: true
  viability: 12
  cost: 13 us
controller:
  type: joint_trajectory
  rate: 125 Hz
  clock_drift: -20 ppm
  phase: 250 us
  wake_delay: {log_normal: {median: 20 us, sigma: 0.5}}
  cost: 100 us
  feed_forward: nominal
  target_noise: 0.0005 rad/s
motion:
  interface: joint_velocity
  trajectory:
    unit: deg
    duration: 4.5 s
    velocity_scale: 0.5
    acceleration_scale: 0.3
    jerk_scale: 0.2
    waypoints:
      - {q: [0, -45, 0, -135, 0, 90, 45]}
      - {q: [10, -40, 5, -130, 0, 95, 40], stop: true}
      - {q: [0, -45, 0, -135, 0, 90, 45]}
render:
  enabled: false
  width: 320
  height: 240
  fps: 30 Hz
  camera:
    azimuth: 90 deg
    elevation: -20 deg
    distance: 2 m
    lookat: [0.1 m, 0 m, 400 mm]
    track: panda_hand
    turn: 10 deg/s
  overlays: [limits, trace]
  insets:
    - {camera: gripper, corner: bottom_left, share: 25 %}
    - {camera: {azimuth: 90 deg}}
record: false
)";
}

/// A scenario of what the other does not say: the synchronous loop in real time, torques, and the
/// other forms of delays and losses.
inline std::string OtherText() {
  return R"(name: other
drive: realtime
loop: synchronous
link:
  state_delay: {normal: {mean: 80 us, sigma: 4 us}}
  command_delay: {histogram: {edges: [0 us, 50 us, 100 us], weights: [3, 0.5]}}
  state_loss: {scripted: [{at: 0 s, count: 1}, {at: 2 s, count: 20}]}
  command_loss: 2 %
tick:
  low_pass: off
  stall_time: 35 ms
controller:
  clock_drift: 54.6 ppm
  wake_delay: {normal: {mean: 0 s, sigma: 2.5 us}}
  target_noise: 0.2 Nm
motion:
  interface: torque
  trajectory:
    unit: rad
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
)";
}

/// A scenario of what touches the robot and how it takes it, and of what it grasps: loads,
/// settings, perturbations, panel, hand.
inline std::string TouchedText() {
  return R"(name: touched
robot:
  load: {mass: 1.5 kg, position: [10 mm, 0 m, 0.08 m], inertia: [0.01 kg m^2, 0.02 kg m^2, 0.025 kg m^2], products_of_inertia: [0.001 kg m^2, 0 kg m^2, -0.002 kg m^2]}
plant:
  elasticity: static
onboard:
  K_x: {translation: 200 N/m, rotation: [10 Nm/rad, 20 Nm/rad, 30 Nm/rad]}
  collision_behavior:
    upper_torque: {unit: Nm, values: [40, 40, 40, 40, 40, 40, 40]}
    lower_torque_acc: {unit: Nm, values: [25, 25, 22, 20, 19, 17, 14]}
    upper_force: {force: 60 N, moment: [30 Nm, 31 Nm, 32 Nm]}
    lower_force_nominal: {force: [10 N, 11 N, 12 N]}
  load: {mass: 500 g}
  EE_T_K: {position: [0 m, 0 m, 50 mm], rpy: [0 deg, 90 deg, 0 deg]}
  NE_T_EE: {position: [0 m, 10 mm, 0.1 m]}
  guiding_mode: {axes: [x, z, Y], elbow: false}
  filters: {joint_position: 100 Hz, cartesian_velocity: 50 Hz, controller: off}
base:
  model: husky
  start: {x: 0.5 m, y: -250 mm, yaw: 45 deg}
  drive:
    - {at: 100 ms, for: 400 ms, v: 0.3 m/s, w: -0.2 rad/s}
motion:
  interface: cartesian_pose
  controller: cartesian_impedance
  trajectory:
    unit: rad
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
perturbations:
  - push: {body: panda_hand, begin: 1 s, duration: 400 ms, rise: 50 ms, force: [0 N, 30 N, 0 N], torque: [0 Nm, 0 Nm, 1 Nm], point: [0 m, 0 m, 100 mm], frame: body}
  - spring: {body: panda_link4, begin: 2 s, duration: 1 s, point: [1 mm, 0 m, 0 m], from: [0.1 m, 0.2 m, 0.3 m], by: [0 m, 50 mm, 0 m], stiffness: 500 N/m, damping: 20 Ns/m, largest_force: 25 N}
  - push: {body: panda_link5, begin: 4 s, torque: [1 Nm, 0 Nm, 0 Nm]}
  - spring: {body: panda_hand, begin: 5 s}
  - push: {body: panda_link6, begin: 0 s, motion: 3, force: [1 N, 0 N, 0 N]}
  - spring: {body: panda_hand, begin: 6 s, motion: 1}
panel:
  - {at: 3 s, action: press_user_stop}
  - {at: 3.5 s, action: release_user_stop}
hand:
  - {at: 0 s, homing: {}}
  - {at: 20 ms, move: {width: 70 mm, speed: 0.1 m/s}}
  - {at: 30 ms, grasp: {width: 50 mm, speed: 20 mm/s, force: 40 N, epsilon_inner: 2 mm}}
  - {at: 40 ms, stop: {}}
tick: {generator: none}
)";
}

/// A scenario of a motion of poses, by a controller of a user's library with parameters.
inline std::string PosesText() {
  return R"(name: poses
controller:
  library: build/my_law.so
  type: my_law
  parameters:
    reference: hold
    stiffness: {translation: 1000 N/m, rotation: [10 Nm/rad, 20 Nm/rad, 30 Nm/rad]}
    q0: {unit: deg, values: [0, 0, 0, -90, 0, 107, 0]}
    deep: {er: {still: true}}
    none: []
motion:
  interface: torque
  poses:
    start: {unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}
    jerk_scale: 0.2
    waypoints:
      - {by: [0 m, 100 mm, 0 m], at: 2 s}
      - {position: [0.4 m, 0.1 m, 0.5 m], turn: [0 deg, 0 deg, 45 deg], at: 4 s}
      - {rpy: [180 deg, 0 deg, 0 deg], at: 5 s}
)";
}

/// A scenario of a motion that is planned.
inline std::string PlanText() {
  return R"(name: plan
scene: scenes/clutter.xml
robot:
  q_start: {unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}
motion:
  interface: torque
  plan:
    goal: {pose: {position: [0.4 m, 0.3 m, 500 mm], rpy: [180 deg, 0 deg, 45 deg]}}
    seed: 7
    budget: 20000
    clearance: 20 mm
    stretch: 1.5
    velocity_scale: 0.4
    acceleration_scale: 0.15
    jerk_scale: 0.05
)";
}

/// @returns `text` with the first occurrence of `from` replaced. Fails the test when there is none.
inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

/// The message of the error that comes of reading `text`, as s.yaml, with one place changed. Empty
/// when there is none.
inline std::string Spoiled(std::string_view text, std::string_view from, std::string_view to) {
  try {
    (void)Parse(Replaced(std::string(text), std::string(from), std::string(to)), "s.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace twin::scenario::test
