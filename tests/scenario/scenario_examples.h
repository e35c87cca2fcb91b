#pragma once

#include <string>

namespace twin::scenario::test {

/// A small scenario in which every key is given; the tests break it in one place each.
inline std::string FullText() {
  return R"(name: full
description: Everything said once.
seed: 42
backend: mujoco
drive: lockstep
scene: scenes/floor.xml
robot:
  model: panda
  hand: none
  q_start: {unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}
plant:
  kind: ideal
  friction: breakaway
  armature: false
  noise: {q: 0.001 deg, dq: 0.002 rad/s, tau_J: 0.3 Nm}
link:
  state_delay: {log_normal: {median: 80 us, sigma: 0.3, offset: 20 us}}
  command_delay: {constant: 95.5 us}
  state_loss: 0.1 %
  command_loss: 2 %
  d_INT: 50 us
int:
  K_theta: {unit: Nm/rad, values: [3000, 3000, 3000, 2500, 2500, 2000, 1999.5]}
  damping_ratio: 0.7
  abort_after_lost: 19
tick:
  generator: none
  lambda: 0.01
  rate_matching: false
  cost: 13 us
controller:
  type: joint_trajectory
  rate: 125 Hz
  clock_drift: -20 ppm
  phase: 250 us
  wake_delay: {log_normal: {median: 20 us, sigma: 0.5}}
  cost: 100 us
  feed_forward: nominal
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
record: false
)";
}

/// @returns `text` with the first occurrence of `from` replaced. Fails the test when there is none.
inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

}  // namespace twin::scenario::test
