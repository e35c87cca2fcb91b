#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "application/performance.h"
#include "twin/core/random.h"
#include "twin/model/lab_limits.h"
#include "twin/planning/collision_world.h"
#include "twin/teleop/device_registry.h"

namespace twin::application::test {

/// What an operator leads besides the hand and the base.
enum class Turns : std::uint8_t { kNoJoint, kJoints };

/// An operator who holds random keys for random times, in all directions, coarse and fine, in axes
/// of base and hand, and leads the base too if there is one. One who turns joints does so two
/// thirds of the time.
class RandomOperator final : public teleop::Device {
 public:
  RandomOperator(std::uint64_t seed, Turns turns, bool has_base, Duration leads_for)
      : random_(seed, RandomStream::kTest),
        turns_(turns),
        has_base_(has_base),
        leads_for_(leads_for) {}

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time now) noexcept override {
    if (now >= next_) Press(now);
    ++sample_.sequence;
    sample_.at = now;
    sample_.end_presses = now.time_since_epoch() > leads_for_ ? 1 : 0;
    if (sample_.end_presses > 0) sample_.axes = {};
    return sample_;
  }
  void Feel(const teleop::OperatorFeedback& /*feedback*/) noexcept override {}
  [[nodiscard]] bool lost() const noexcept override { return false; }
  [[nodiscard]] std::string Describe() const override { return "a random operator"; }

 private:
  [[nodiscard]] double Draw() noexcept { return random_.Uniform(draws_++); }

  void Press(Time now) noexcept {
    const double longest = Draw() < 0.5 ? 1 : 6;  // s
    next_ = now + FromSeconds(0.1 + longest * Draw());
    sample_.axes = {};
    if (turns_ == Turns::kJoints && Turn()) return;
    const int keys = static_cast<int>(4 * Draw());
    for (int key = 0; key < keys; ++key) {
      const auto axis = static_cast<std::size_t>(6 * Draw());
      sample_.axes[std::min<std::size_t>(axis, 5)] = Draw() < 0.5 ? -1 : 1;
    }
    if (Draw() < 0.1) ++sample_.frame_presses;
    if (Draw() < 0.05) ++sample_.scale_presses;
    if (has_base_ && Draw() < 0.1) ++sample_.mode_presses;
  }

  /// @returns whether joints are turned, or a switch between them and the hand needs the keys up.
  bool Turn() noexcept {
    const bool was_hand = sample_.joint == 0;
    const bool is_hand = Draw() < 0.33;
    sample_.joint = is_hand ? std::uint8_t{0} : static_cast<std::uint8_t>(1 + 6.999 * Draw());
    if (is_hand != was_hand) return true;
    if (!is_hand) sample_.axes[0] = Draw() < 0.5 ? -1 : 1;
    if (!is_hand && Draw() < 0.05) ++sample_.scale_presses;
    return !is_hand;
  }

  const Random random_;
  const Turns turns_;
  const bool has_base_;
  const Duration leads_for_;
  std::uint64_t draws_ = 0;
  Time next_{};
  teleop::OperatorSample sample_;
};

/// What came of one operator.
struct Led {
  std::string failure;                                      ///< empty: neither error nor abort
  double margin = std::numeric_limits<double>::infinity();  ///< least of a joint, rad
  double room = std::numeric_limits<double>::infinity();    ///< least of a region, m
};

/// Keeps the least distance of a joint from the ends of its range.
class MarginWatch final : public record::RecordSink {
 public:
  explicit MarginWatch(Led& led) : led_(led) {}
  void Set(const JointLimits& limits, const model::LabLimits& lab) {
    limits_ = limits;
    lab_ = lab;
  }
  void Put(const record::CycleRecord& record) noexcept override {
    for (std::size_t i = 0; i < kJoints; ++i) {
      led_.margin = std::min({led_.margin, record.state.q[i] - limits_.q_min[i],
                              limits_.q_max[i] - record.state.q[i]});
    }
    const auto least = model::LeastMargin(lab_, {record.state.F_T_EE, true}, record.state.q);
    if (least) led_.room = std::min(led_.room, least->margin);
  }
  void Put(const record::TickRecord& /*record*/) noexcept override {}

 private:
  Led& led_;
  JointLimits limits_;
  model::LabLimits lab_;
};

/// A third of the operators begin at the usual start, the others anywhere the robot is free; every
/// second one is 100 ms away over a wire that loses 5 %; every fourth has a base.
inline scenario::Scenario DrawnFor(std::uint64_t seed) {
  const bool has_base = seed % 4 == 3;
  const bool is_far = seed % 2 == 1;
  scenario::Scenario scenario =
      scenario::Parse(fmt::format(R"(name: random_operator
seed: {}
scene: scenes/floor.xml
{}robot:
  q_start: {{unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}}
operator:
  device: random
{}application: {{type: teleoperation}}
)",
                                  seed, has_base ? "base: {model: husky}\n" : "",
                                  is_far ? "  to_robot_delay: 100 ms\n  to_robot_loss: 5 %\n"
                                           "  from_robot_delay: 100 ms\n  from_robot_loss: 5 %\n"
                                         : ""),
                      "random_operator.yaml");
  if (seed % 3 == 0) return scenario;
  const Random random(seed, RandomStream::kTest);
  const JointLimits limits =
      scenario::LoadRobotData(Models(), scenario.robot.model, scenario.robot.hand).limits;
  plant::MujocoPlantOptions options;
  options.urdf = Models() / "robots/panda/panda.urdf";
  options.scene = Models() / "scenes/floor.xml";
  if (has_base) options.base = plant::BaseOptions{Models() / "robots/husky/husky.urdf", {}};
  planning::CollisionWorld world(options);
  JointVector q{};
  std::uint32_t draw = 0;
  do {
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double share = 0.15 + 0.7 * random.Uniform(1, draw++);
      q[i] = limits.q_min[i] + share * (limits.q_max[i] - limits.q_min[i]);
    }
  } while (!world.IsFree(q, 0.05));
  scenario.robot.q_start = q;
  return scenario;
}

/// The hand stands 0.15 m above a box of 0.1 kg on a table, as in models/scenarios/grasp.yaml, and
/// is led as from the page of a served robot.
inline scenario::Scenario AboveABox(std::uint64_t seed) {
  return scenario::Parse(fmt::format(R"(name: above_a_box
seed: {}
scene: scenes/table_box.xml
robot: {{q_start: {{unit: rad, values: [0, -0.19371, 0, -1.90879, 0, 1.71508, -0.78540]}}}}
operator: {{device: random, settings: {{workspace: {{press: 20 mm}}}}}}
application: {{type: teleoperation}}
)",
                                     seed),
                         "above_a_box.yaml");
}

/// An operator who holds keys one after the other, each for a time.
class PlannedOperator final : public teleop::Device {
 public:
  struct Keys {
    Vector6 axes{};
    Duration held{};
  };
  explicit PlannedOperator(std::vector<Keys> plan) : plan_(std::move(plan)) {}

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time now) noexcept override {
    if (!begun_) begun_ = now;
    Duration left = now - *begun_;
    ++sample_.sequence;
    sample_.at = now;
    for (const Keys& keys : plan_) {
      sample_.axes = keys.axes;
      if (left < keys.held) return sample_;
      left -= keys.held;
    }
    sample_.axes = {};
    sample_.end_presses = 1;
    return sample_;
  }
  void Feel(const teleop::OperatorFeedback& /*feedback*/) noexcept override {}
  [[nodiscard]] bool lost() const noexcept override { return false; }
  [[nodiscard]] std::string Describe() const override { return "an operator with a plan"; }

 private:
  const std::vector<Keys> plan_;
  std::optional<Time> begun_;
  teleop::OperatorSample sample_;
};

/// Lets the operator of the device "random" lead in lockstep.
inline Led LetLead(const scenario::Scenario& scenario, const teleop::DeviceFactory& make) {
  Led led;
  teleop::DeviceRegistry devices;
  devices.Add("random", make);
  backend::Registry backends;
  control::ControllerRegistry controllers;
  plugins::RegisterMujoco(backends);
  controllers::RegisterControllers(controllers);
  MarginWatch watch(led);
  const MonotonicClock clock;
  ApplicationRun run(scenario, run::Catalogue{backends, controllers, &devices},
                     {.models = Models(), .mesh_package = {}, .cache = {}}, &watch, clock);
  watch.Set(run.robot().limits, scenario.limits);
  const TaskResult result = run.Execute({});
  led.failure = result.task.failure;
  if (led.failure.empty() && !result.robot_errors.empty()) led.failure = result.robot_errors[0];
  return led;
}

/// Lets one random operator lead for some time.
inline Led LetLead(std::uint64_t seed, Duration leads_for, Turns turns = Turns::kNoJoint) {
  const scenario::Scenario scenario = DrawnFor(seed);
  return LetLead(scenario, [&](const teleop::DeviceRequest&) {
    return std::make_unique<RandomOperator>(seed, turns, scenario.base.has_value(), leads_for);
  });
}

}  // namespace twin::application::test
