#include "application/compliance.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/quantity.h"
#include "twin/reference/pose_trajectory.h"

namespace twin::application::compliance {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Duration of the motion back.
constexpr Duration kBack = seconds(2);
/// Largest joint position in q0, rad, as in the controller.
constexpr double kFarthest = 10;

/// Reads two parameters of three axes each. The ranges are the controller's.
Vector6 ReadAxes(control::ParameterReader& p, const std::string& key, Dimension translation,
                 Dimension rotation, const Vector6& otherwise, double most_along,
                 double most_about) {
  const Vector3 along = p.Vector(key + ".translation", translation,
                                 {otherwise[0], otherwise[1], otherwise[2]}, 0, most_along);
  const Vector3 about = p.Vector(key + ".rotation", rotation,
                                 {otherwise[3], otherwise[4], otherwise[5]}, 0, most_about);
  return {along[0], along[1], along[2], about[0], about[1], about[2]};
}

void ReadGains(control::ParameterReader& p, const std::string& key, Gains& gains) {
  gains.K_P = ReadAxes(p, key + ".stiffness", Dimension::kLinearStiffness, Dimension::kStiffness,
                       gains.K_P, 5000, 500);
  gains.K_D = ReadAxes(p, key + ".damping", Dimension::kLinearDamping, Dimension::kAngularDamping,
                       gains.K_D, 1000, 100);
}

std::vector<std::string> Texts(const double* values, std::size_t count, std::string_view unit) {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < count; ++i) {
    texts.push_back(FormatNumber(values[i]) + (unit.empty() ? "" : fmt::format(" {}", unit)));
  }
  return texts;
}

/// The gains as parameters of the controller.
control::Parameters ParametersOf(const Gains& gains, const JointVector& q_0, const Config& config,
                                 std::string_view reference) {
  const auto list = [](std::string key, std::vector<std::string> values) {
    return control::Parameter{.key = std::move(key), .values = std::move(values), .is_list = true};
  };
  const auto one = [](std::string key, std::string value) {
    return control::Parameter{.key = std::move(key), .values = {std::move(value)}};
  };
  control::Parameters parameters{
      one("reference", std::string(reference)),
      list("stiffness.translation", Texts(gains.K_P.data(), 3, "N/m")),
      list("stiffness.rotation", Texts(gains.K_P.data() + 3, 3, "Nm/rad")),
      list("damping.translation", Texts(gains.K_D.data(), 3, "Ns/m")),
      list("damping.rotation", Texts(gains.K_D.data() + 3, 3, "Nms/rad")),
      one("k0", FormatNumber(config.k_0) + " Nm/rad"),
      one("q0.unit", "rad"),
      list("q0.values", Texts(q_0.data(), kJoints, "")),
      one("soft_start", FormatDuration(config.soft_start))};
  if (config.friction_compensation) {
    parameters.push_back(one("friction_compensation", FormatNumber(*config.friction_compensation)));
  }
  return parameters;
}

reference::PoseTrajectory PathFrom(const Transform& O_T_EE, const Config& config,
                                   const CartesianLimits& limits) {
  const auto moved = [](Transform pose, const Vector3& by) {
    for (std::size_t i = 0; i < by.size(); ++i) pose[12 + i] += by[i];
    return pose;
  };
  const Transform first = moved(O_T_EE, config.first);
  return reference::PoseTrajectory({{.O_T_EE = O_T_EE, .at = Duration::zero()},
                                    {.O_T_EE = first, .at = config.leg},
                                    {.O_T_EE = moved(first, config.second), .at = 2 * config.leg},
                                    {.O_T_EE = O_T_EE, .at = 3 * config.leg},
                                    {.O_T_EE = O_T_EE, .at = 3 * config.leg + config.rest}},
                                   {}, limits);
}

/// The push of a case. @throws InputError if it has none or several.
const plant::Push& PushOf(const Case& one, const scenario::Scenario& scenario) {
  const plant::Push* found = nullptr;
  for (const plant::Perturbation& perturbation : scenario.perturbations) {
    const auto* push = std::get_if<plant::Push>(&perturbation);
    if (push == nullptr || push->motion != one.motion) continue;
    if (found != nullptr) {
      throw InputError(fmt::format("perturbations: case {} has two pushes (motion: {}); it needs 1",
                                   one.id, one.motion));
    }
    found = push;
  }
  if (found != nullptr) return *found;
  throw InputError(
      fmt::format("perturbations: nobody pushes in case {} ({}); it needs a push: "
                  "{{..., motion: {}}}",
                  one.id, one.what, one.motion));
}

/// Refuses perturbations other than the pushes of cases.
void RefuseOthers(const scenario::Scenario& scenario) {
  for (const plant::Perturbation& perturbation : scenario.perturbations) {
    const auto* push = std::get_if<plant::Push>(&perturbation);
    const bool is_of_a_case =
        push != nullptr && std::ranges::any_of(kAllCases, [push](const Case& one) {
          return one.is_pushed && push->motion == one.motion;
        });
    if (is_of_a_case) continue;
    throw InputError(
        "perturbations: one is no push in a case that is pushed, motion: 1 (A), 3 (B), 7 (C) or 11 "
        "(D); leave it out");
  }
}

void RequireSame(const Case& one, const Case& other, const scenario::Scenario& scenario) {
  plant::Push push = PushOf(one, scenario);
  push.motion = other.motion;
  if (push == PushOf(other, scenario)) return;
  throw InputError(fmt::format(
      "perturbations: the pushes of cases {} and {} differ; they are compared, so make them equal",
      one.id, other.id));
}

void RequireMeasurable(const Case& one, const plant::Push& push, const Config& config) {
  const auto fail = [&one](const std::string& why) {
    throw InputError(fmt::format("perturbations: the push of case {}: {}", one.id, why));
  };
  if (push.frame != plant::ForceFrame::kWorld || push.force == Vector3{} ||
      push.torque != Vector3{}) {
    fail("it must be a force and no torque, in the world's axes");
  }
  if (push.begin < config.soft_start + kBefore) {
    fail(fmt::format("begin is {}; it must be at least {}, {} after the soft start",
                     FormatDuration(push.begin), FormatDuration(config.soft_start + kBefore),
                     FormatDuration(kBefore)));
  }
  if (push.duration - 2 * push.rise < 2 * kSteady) {
    fail(fmt::format("the force is constant for {}; it must be for at least {}, to settle",
                     FormatDuration(push.duration - 2 * push.rise), FormatDuration(2 * kSteady)));
  }
  if (push.begin + push.duration >= LengthOf(one, config)) {
    fail(fmt::format("it ends {} after the motion's begin; the motion takes {}",
                     FormatDuration(push.begin + push.duration),
                     FormatDuration(LengthOf(one, config))));
  }
}

}  // namespace

Config ReadConfig(control::ParameterReader& p) {
  Config s;
  ReadGains(p, "stiff", s.stiff);
  ReadGains(p, "compliant", s.compliant);
  s.k_0 = p.Quantity("k0", Dimension::kStiffness, s.k_0, 0, 100);
  s.q_0 = p.Joints("q0", Dimension::kAngle, s.q_0, -kFarthest, kFarthest);
  if (p.Has("friction_compensation")) {
    s.friction_compensation = p.Number("friction_compensation", 0, 0, 1);
  }
  s.soft_start = p.Time("soft_start", s.soft_start, Duration::zero(), seconds(10));
  s.standing = p.Time("standstill.duration", s.standing, seconds(1), seconds(600));
  s.first = p.Vector("trajectory.first", Dimension::kLength, s.first, -1, 1);
  s.second = p.Vector("trajectory.second", Dimension::kLength, s.second, -1, 1);
  s.leg = p.Time("trajectory.leg", s.leg, milliseconds(100), seconds(600));
  s.rest = p.Time("trajectory.rest", s.rest, milliseconds(100), seconds(600));
  s.elsewhere = p.Joints("null_space.q0", Dimension::kAngle, s.elsewhere, -kFarthest, kFarthest);
  s.wandering = p.Time("null_space.duration", s.wandering, seconds(1), seconds(600));
  if (s.wandering < s.soft_start + 2 * kSteady) {
    p.Refuse("null_space.duration",
             fmt::format("{} is too short; it must be at least {}, {} after the soft start",
                         FormatDuration(s.wandering), FormatDuration(s.soft_start + 2 * kSteady),
                         FormatDuration(2 * kSteady)));
  }
  return s;
}

const Gains& GainsOf(const Case& one, const Config& config) noexcept {
  return one.is_stiff ? config.stiff : config.compliant;
}

Duration LengthOf(const Case& one, const Config& config) noexcept {
  switch (one.kind) {
    case Kind::kStandstill: return config.standing;
    case Kind::kTrajectory: return 3 * config.leg + config.rest;
    case Kind::kNullSpace: break;
  }
  return config.wandering;
}

run::Motion MotionOf(const Case& one, const Config& config, const Stage& stage,
                     const RobotState& state) {
  const bool moves = one.kind == Kind::kTrajectory;
  run::Motion motion = run::MotionOn(
      stage.scenario, fmt::format("{}: {}", one.id, one.what), control::CommandInterface::kTorque,
      run::StandingFor(state.q, LengthOf(one, config), stage.session.robot().limits));
  if (moves) motion.poses = PathFrom(state.O_T_EE, config, stage.session.robot().cartesian);
  motion.controller.type = "compliance";
  motion.controller.parameters = ParametersOf(
      GainsOf(one, config), one.kind == Kind::kNullSpace ? config.elsewhere : config.q_0, config,
      moves ? "path" : "hold");
  return motion;
}

run::Motion MotionBack(const Case& from, const Stage& stage, const RobotState& state) {
  return run::MotionOn(
      stage.scenario, fmt::format("back from {}", from.id), control::CommandInterface::kTorque,
      reference::Trajectory({{.q = state.q, .at = Duration::zero()},
                             {.q = stage.scenario.robot.q_start.value(), .at = kBack}},
                            {}, stage.session.robot().limits));
}

Pushes PushesOf(const scenario::Scenario& scenario, const Config& config) {
  RefuseOthers(scenario);
  RequireSame(kAllCases[kA], kAllCases[kB], scenario);
  RequireSame(kAllCases[kC], kAllCases[kD], scenario);
  Pushes pushes{PushOf(kAllCases[kA], scenario), PushOf(kAllCases[kC], scenario)};
  RequireMeasurable(kAllCases[kA], pushes.standing, config);
  RequireMeasurable(kAllCases[kC], pushes.moving, config);
  return pushes;
}

}  // namespace twin::application::compliance
