#include <string>
#include <utility>

#include <fmt/format.h>

#include "scenario/max_deviation.h"
#include "scenario/parameter_tree.h"
#include "scenario/quoted.h"
#include "scenario/section_writers.h"
#include "twin/core/quantity.h"
#include "twin/scenario/names.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {
namespace {

using Text = std::string;

template <typename... Arguments>
void Put(Text& out, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  out += fmt::format(format, std::forward<Arguments>(arguments)...);
}

/// "[a, b, c]", each value as `format` writes it.
template <typename Values, typename Format>
std::string List(const Values& values, Format format) {
  std::string list;
  for (const auto& value : values) list += (list.empty() ? "" : ", ") + format(value);
  return "[" + list + "]";
}

std::string LawText(const rt::ConstantDelay& law) {
  return FormatDuration(law.value);
}

std::string LawText(const rt::LogNormalDelay& law) {
  return fmt::format("{{log_normal: {{median: {}, sigma: {}, offset: {}}}}}",
                     FormatDuration(law.median), FormatNumber(law.sigma),
                     FormatDuration(law.offset));
}

std::string LawText(const rt::NormalDelay& law) {
  return fmt::format("{{normal: {{mean: {}, sigma: {}}}}}", FormatDuration(law.mean),
                     FormatDuration(law.sigma));
}

std::string LawText(const rt::GammaDelay& law) {
  return fmt::format("{{gamma: {{shape: {}, scale: {}, offset: {}}}}}", FormatNumber(law.shape),
                     FormatDuration(law.scale), FormatDuration(law.offset));
}

std::string LawText(const rt::EmpiricalDelay& law) {
  return fmt::format("{{histogram: {{edges: {}, weights: {}}}}}", List(law.edges, FormatDuration),
                     List(law.weights, FormatNumber));
}

std::string LawText(const IndependentLoss& law) {
  return FormatNumber(law.percent) + " %";
}

std::string LawText(const GilbertElliottLoss& law) {
  return fmt::format(
      "{{gilbert_elliott: {{good_to_bad: {} %, bad_to_good: {} %, loss_good: {} %, loss_bad: {} "
      "%}}}}",
      FormatNumber(law.good_to_bad), FormatNumber(law.bad_to_good), FormatNumber(law.loss_good),
      FormatNumber(law.loss_bad));
}

std::string LawText(const ScriptedLoss& law) {
  return fmt::format("{{scripted: {}}}", List(law.bursts, [](const ScriptedLoss::Burst& burst) {
                       return fmt::format("{{at: {}, count: {}}}", FormatDuration(burst.at),
                                          burst.count);
                     }));
}

/// @param model  a Delay or a Loss.
template <typename Model>
std::string TextOf(const Model& model) {
  return std::visit([](const auto& law) { return LawText(law); }, model.law);
}

/// "[x m, y m, z m]".
std::string VectorText(const Vector3& v, Dimension dimension) {
  return List(v,
              [&](double x) { return fmt::format("{} {}", FormatNumber(x), BaseUnit(dimension)); });
}

/// The first or the last three of six.
Vector3 Half(const Vector6& whole, std::size_t at) {
  return {whole[at], whole[at + 1], whole[at + 2]};
}

std::string LoadText(const setting::Load& load) {
  const Matrix3& I = load.I_load;
  return fmt::format("{{mass: {} kg, position: {}, inertia: {}, products_of_inertia: {}}}",
                     FormatNumber(load.m_load), VectorText(load.F_x_Cload, Dimension::kLength),
                     VectorText({I[0], I[4], I[8]}, Dimension::kInertia),
                     VectorText({I[3], I[6], I[7]}, Dimension::kInertia));
}

void PutRobotAndPlant(Text& out, const Scenario& s) {
  Put(out, "robot:\n  model: {}\n  hand: {}\n", Quoted(s.robot.model),
      NameOf(kHandNames, s.robot.hand));
  if (s.robot.q_start)
    Put(out, "  q_start: {{unit: rad, values: {}}}\n", List(*s.robot.q_start, FormatNumber));
  Put(out, "  clock_drift: {} ppm\n  load: {}\n", FormatNumber(s.robot.clock_drift_ppm),
      LoadText(s.robot.load));
  if (s.base) out += BaseText(*s.base);
  Put(out, "plant:\n  kind: {}\n  friction: {}\n  armature: {}\n  elasticity: {}\n",
      NameOf(kPlantNames, s.plant.kind), NameOf(kFrictionNames, s.plant.friction), s.plant.armature,
      NameOf(kElasticityNames, s.plant.elasticity));
  // A plant as it always was is written as it always was.
  if (s.plant.mass_scale != 1) Put(out, "  mass_scale: {}\n", FormatNumber(s.plant.mass_scale));
  if (!(s.plant.base_tilt == plant::BaseTilt())) {
    Put(out, "  base_tilt: {{roll: {} rad, pitch: {} rad}}\n", FormatNumber(s.plant.base_tilt.roll),
        FormatNumber(s.plant.base_tilt.pitch));
  }
  Put(out, "  noise: {{q: {} rad, dq: {} rad/s, tau_J: {} Nm}}\n", FormatNumber(s.plant.noise_q),
      FormatNumber(s.plant.noise_dq), FormatNumber(s.plant.noise_tau_J));
}

void PutDirection(Text& out, std::string_view name, const DirectionSection& direction) {
  Put(out, "  {}_delay: {}\n  {}_loss: {}\n", name, TextOf(direction.delay), name,
      TextOf(direction.loss));
  Put(out, "  {}_duplication: {{share: {} %, delay: {}}}\n", name,
      FormatNumber(direction.duplication.share_percent), TextOf(direction.duplication.delay));
  Put(out, "  {}_reordering: {{share: {} %, by: {}}}\n", name,
      FormatNumber(direction.reordering.share_percent), FormatDuration(direction.reordering.by));
}

void PutLink(Text& out, const Scenario& s) {
  Put(out, "link:\n");
  PutDirection(out, "state", s.link.state);
  PutDirection(out, "command", s.link.command);
  Put(out, "  d_INT: {}\n", FormatDuration(s.link.d_INT));
}

/// {unit: Nm, values: [...]}.
std::string JointText(const JointVector& values, Dimension dimension) {
  return fmt::format("{{unit: {}, values: {}}}", BaseUnit(dimension), List(values, FormatNumber));
}

std::string ForcesText(const Vector6& forces) {
  return fmt::format("{{force: {}, moment: {}}}", VectorText(Half(forces, 0), Dimension::kForce),
                     VectorText(Half(forces, 3), Dimension::kTorque));
}

void PutCollisionBehavior(Text& out, const setting::CollisionBehavior& b) {
  if (b == NoCollisionBehavior()) {
    Put(out, "  collision_behavior: off\n");
    return;
  }
  const auto torque = [&out](std::string_view key, const JointVector& values) {
    Put(out, "    {}: {}\n", key, JointText(values, Dimension::kTorque));
  };
  const auto force = [&out](std::string_view key, const Vector6& values) {
    Put(out, "    {}: {}\n", key, ForcesText(values));
  };
  Put(out, "  collision_behavior:\n");
  torque("lower_torque_acc", b.lower_torque_acc);
  torque("upper_torque_acc", b.upper_torque_acc);
  torque("lower_torque_nominal", b.lower_torque_nominal);
  torque("upper_torque_nominal", b.upper_torque_nominal);
  force("lower_force_acc", b.lower_force_acc);
  force("upper_force_acc", b.upper_force_acc);
  force("lower_force_nominal", b.lower_force_nominal);
  force("upper_force_nominal", b.upper_force_nominal);
}

void PutFrame(Text& out, std::string_view name, const FramePose& pose) {
  Put(out, "  {}: {{position: {}, rpy: {}}}\n", name, VectorText(pose.position, Dimension::kLength),
      VectorText(pose.rpy, Dimension::kAngle));
}

void PutGuidingMode(Text& out, const setting::GuidingMode& mode) {
  static constexpr std::array<std::string_view, 6> kAxes{"x", "y", "z", "R", "P", "Y"};
  std::vector<std::string> free;
  for (std::size_t i = 0; i < kAxes.size(); ++i) {
    if (mode.axes[i]) free.emplace_back(kAxes[i]);
  }
  Put(out, "  guiding_mode: {{axes: {}, elbow: {}}}\n",
      List(free, [](const std::string& axis) { return Quoted(axis); }), mode.elbow);
}

std::string CutoffText(double cutoff_hz) {
  return cutoff_hz == kLowPassOff ? "off" : FormatNumber(cutoff_hz) + " Hz";
}

void PutFilters(Text& out, const setting::Filters& filters) {
  Put(out,
      "  filters: {{joint_position: {}, joint_velocity: {}, cartesian_position: {}, "
      "cartesian_velocity: {}, controller: {}}}\n",
      CutoffText(filters.joint_position_hz), CutoffText(filters.joint_velocity_hz),
      CutoffText(filters.cartesian_position_hz), CutoffText(filters.cartesian_velocity_hz),
      CutoffText(filters.controller_hz));
}

void PutOnboard(Text& out, const OnboardSection& onboard) {
  Put(out, "onboard:\n  K_theta: {}\n", JointText(onboard.K_theta, Dimension::kStiffness));
  Put(out, "  K_x: {{translation: {}, rotation: {}}}\n",
      VectorText(Half(onboard.K_x, 0), Dimension::kLinearStiffness),
      VectorText(Half(onboard.K_x, 3), Dimension::kStiffness));
  PutCollisionBehavior(out, onboard.collision_behavior);
  Put(out, "  load: {}\n", LoadText(onboard.load));
  PutFrame(out, "EE_T_K", onboard.EE_T_K);
  PutFrame(out, "NE_T_EE", onboard.NE_T_EE);
  PutGuidingMode(out, onboard.guiding_mode);
  PutFilters(out, onboard.filters);
  Put(out, "  damping_ratio: {}\n  abort_after_lost: {}\n  friction_compensation: {}\n",
      FormatNumber(onboard.damping_ratio), onboard.abort_after_lost,
      FormatNumber(onboard.friction_compensation));
}

void PutTick(Text& out, const Scenario& s) {
  Put(out, "tick:\n  generator: {}\n  lambda: {}\n  rate_matching: {}\n",
      NameOf(kGeneratorNames, s.tick.generator), FormatNumber(s.tick.lambda), s.tick.rate_matching);
  Put(out, "  finish_tolerance: {} rad\n", FormatNumber(s.tick.finish_tolerance));
  if (s.loop == loop::LoopKind::kAsynchronous) {
    Put(out, "  period_tolerance: {}\n", FormatDuration(s.tick.period_tolerance));
  }
  Put(out, "  stall_time: {}\n  low_pass: {}\n  limiter: {}\n  viability: {}\n  cost: {}\n",
      FormatDuration(s.tick.stall_time), CutoffText(s.tick.low_pass_hz), s.tick.limiter,
      s.tick.viability ? std::to_string(*s.tick.viability) : "off", TextOf(s.tick.cost));
}

/// Which controller, and what it is told.
void PutLaw(Text& out, const ControllerSection& controller, control::CommandInterface interface) {
  if (!controller.library.empty()) Put(out, "  library: {}\n", Quoted(controller.library.string()));
  Put(out, "  type: {}\n", Quoted(controller.type));
  if (!controller.parameters.empty()) {
    Put(out, "  parameters: {}\n", ParametersText(controller.parameters));
  }
  Put(out, "  target_noise: {} {}\n", FormatNumber(controller.target_noise),
      BaseUnit(DimensionOf(interface)));
}

void PutController(Text& out, const Scenario& s) {
  const ControllerSection& controller = s.controller;
  Put(out, "controller:\n");
  if (!s.application) PutLaw(out, controller, s.motion.interface);
  Put(out, "  rate: {} Hz\n  clock_drift: {} ppm\n  phase: {}\n", FormatNumber(controller.rate_hz),
      FormatNumber(controller.clock_drift_ppm), FormatDuration(controller.phase));
  Put(out, "  wake_delay: {}\n  cost: {}\n  feed_forward: {}\n", TextOf(controller.wake_delay),
      TextOf(controller.cost), NameOf(kFeedForwardNames, controller.feed_forward));
}

void PutPoseStep(Text& out, const PoseStep& step) {
  const auto value = [&](std::string_view key, const Vector3& v, Dimension dimension) {
    return fmt::format("{}: {}", key, VectorText(v, dimension));
  };
  Put(out, "      - {{{}, {}",
      step.position ? value("position", *step.position, Dimension::kLength)
                    : value("by", step.by, Dimension::kLength),
      step.rpy ? value("rpy", *step.rpy, Dimension::kAngle)
               : value("turn", step.turn, Dimension::kAngle));
  if (step.at) Put(out, ", at: {}", FormatDuration(*step.at));
  Put(out, "}}\n");
}

std::string GoalText(const RandomGoal& /*goal*/) {
  return "random";
}

std::string GoalText(const JointVector& q) {
  return fmt::format("{{q: {}}}", JointText(q, Dimension::kAngle));
}

std::string GoalText(const FramePose& pose) {
  return fmt::format("{{pose: {{position: {}, rpy: {}}}}}",
                     VectorText(pose.position, Dimension::kLength),
                     VectorText(pose.rpy, Dimension::kAngle));
}

void PutPlan(Text& out, const PlanSection& plan) {
  Put(out, "  plan:\n    goal: {}\n",
      std::visit([](const auto& goal) { return GoalText(goal); }, plan.goal));
  if (plan.seed) Put(out, "    seed: {}\n", *plan.seed);
  Put(out, "    budget: {}\n    clearance: {} m\n    stretch: {}\n", plan.budget,
      FormatNumber(plan.clearance), FormatNumber(plan.stretch));
}

void PutMotion(Text& out, const MotionSection& motion) {
  Put(out, "motion:\n  interface: {}\n", NameOf(kInterfaceNames, motion.interface));
  if (motion.interface != control::CommandInterface::kTorque) {
    Put(out, "  controller: {}\n", NameOf(kControllerNames, motion.controller));
  }
  const bool of_poses = !motion.poses.empty();
  if (motion.plan) {
    PutPlan(out, *motion.plan);
  } else if (of_poses) {
    Put(out, "  poses:\n    start: {}\n", JointText(motion.waypoints.front().q, Dimension::kAngle));
  } else {
    Put(out, "  trajectory:\n    unit: rad\n");
  }
  if (motion.timing.duration) {
    Put(out, "    duration: {}\n", FormatDuration(*motion.timing.duration));
  }
  Put(out, "    velocity_scale: {}\n    acceleration_scale: {}\n    jerk_scale: {}\n",
      FormatNumber(motion.timing.velocity_scale), FormatNumber(motion.timing.acceleration_scale),
      FormatNumber(motion.timing.jerk_scale));
  if (motion.plan) return;
  Put(out, "    waypoints:\n");
  for (const PoseStep& step : motion.poses) PutPoseStep(out, step);
  if (of_poses) return;
  for (const reference::Waypoint& point : motion.waypoints) {
    Put(out, "      - {{q: {}", List(point.q, FormatNumber));
    if (point.at) Put(out, ", at: {}", FormatDuration(*point.at));
    if (point.stop) Put(out, ", stop: true");
    Put(out, "}}\n");
  }
}

void PutApplication(Text& out, const ApplicationSection& application) {
  Put(out, "application:\n  type: {}\n", Quoted(application.type));
  if (application.parameters.empty()) return;
  Put(out, "  parameters: {}\n", ParametersText(application.parameters));
}

void PutOperator(Text& out, const OperatorSection& section) {
  Put(out, "operator:\n  device: {}\n", Quoted(section.device));
  const auto parameters = [&out](std::string_view key, const control::Parameters& values) {
    if (!values.empty()) Put(out, "  {}: {}\n", key, ParametersText(values));
  };
  parameters("parameters", section.parameters);
  parameters("settings", section.settings);
  PutDirection(out, "to_robot", section.to_robot);
  PutDirection(out, "from_robot", section.from_robot);
}

template <typename Kind>
std::string WhereAndWhenText(const Kind& what) {
  return fmt::format(
      "body: {}, begin: {}, {}duration: {}", Quoted(what.body), FormatDuration(what.begin),
      what.motion ? fmt::format("motion: {}, ", *what.motion) : "", FormatDuration(what.duration));
}

void PutPerturbation(Text& out, const plant::Push& push) {
  Put(out, "  - push: {{{}, rise: {}, force: {}, torque: {}, point: {}, frame: {}}}\n",
      WhereAndWhenText(push), FormatDuration(push.rise), VectorText(push.force, Dimension::kForce),
      VectorText(push.torque, Dimension::kTorque), VectorText(push.point, Dimension::kLength),
      NameOf(kForceFrameNames, push.frame));
}

void PutPerturbation(Text& out, const plant::HandSpring& spring) {
  Put(out, "  - spring: {{{}, point: {}, ", WhereAndWhenText(spring),
      VectorText(spring.point, Dimension::kLength));
  if (spring.from) Put(out, "from: {}, ", VectorText(*spring.from, Dimension::kLength));
  Put(out, "by: {}, stiffness: {} N/m, damping: {} Ns/m, largest_force: {} N}}\n",
      VectorText(spring.by, Dimension::kLength), FormatNumber(spring.stiffness),
      FormatNumber(spring.damping), FormatNumber(spring.largest_force));
}

void PutPerturbationsAndPanel(Text& out, const Scenario& s) {
  Put(out, "perturbations:{}\n", s.perturbations.empty() ? " []" : "");
  for (const plant::Perturbation& perturbation : s.perturbations) {
    std::visit([&out](const auto& what) { PutPerturbation(out, what); }, perturbation);
  }
  Put(out, "panel:{}\n", s.panel.empty() ? " []" : "");
  for (const robot::PanelEvent& event : s.panel) {
    Put(out, "  - {{at: {}, action: {}}}\n", FormatDuration(event.at), Name(event.action));
  }
}

std::string HandText(const hand::Homing& /*homing*/) {
  return "homing: {}";
}

std::string HandText(const hand::Stop& /*stop*/) {
  return "stop: {}";
}

std::string HandText(const hand::Move& move) {
  return fmt::format("move: {{width: {} m, speed: {} m/s}}", FormatNumber(move.width),
                     FormatNumber(move.speed));
}

std::string HandText(const hand::Grasp& grasp) {
  return fmt::format(
      "grasp: {{width: {} m, speed: {} m/s, force: {} N, epsilon_inner: {} m, epsilon_outer: {} "
      "m}}",
      FormatNumber(grasp.width), FormatNumber(grasp.speed), FormatNumber(grasp.force),
      FormatNumber(grasp.epsilon_inner), FormatNumber(grasp.epsilon_outer));
}

void PutHand(Text& out, const std::vector<HandEvent>& hand) {
  Put(out, "hand:{}\n", hand.empty() ? " []" : "");
  for (const HandEvent& event : hand) {
    Put(out, "  - {{at: {}, {}}}\n", FormatDuration(event.at),
        std::visit([](const auto& command) { return HandText(command); }, event.command));
  }
}

}  // namespace

std::string ToYaml(const Scenario& scenario) {
  Text out;
  Put(out, "name: {}\ndescription: {}\nseed: {}\n", Quoted(scenario.name),
      Quoted(scenario.description), scenario.seed);
  Put(out, "backend: {}\ndrive: {}\nloop: {}\nscene: {}\n", Quoted(scenario.backend),
      Name(scenario.drive), NameOf(kLoopNames, scenario.loop), Quoted(scenario.scene.string()));
  out += ObjectsText(scenario.objects);
  PutRobotAndPlant(out, scenario);
  PutLink(out, scenario);
  PutOnboard(out, scenario.onboard);
  PutTick(out, scenario);
  PutController(out, scenario);
  if (scenario.application) {
    PutApplication(out, *scenario.application);
  } else {
    PutMotion(out, scenario.motion);
  }
  out += MaxDeviationText(scenario.max_deviation);
  if (scenario.operator_section) PutOperator(out, *scenario.operator_section);
  PutPerturbationsAndPanel(out, scenario);
  PutHand(out, scenario.hand);
  out += RenderText(scenario.render);
  Put(out, "record: {}\n", scenario.record);
  return out;
}

}  // namespace twin::scenario
