#include "twin/scenario/robot_data.h"

#include <cmath>

#include <fmt/format.h>

#include "scenario/robot_folders.h"
#include "scenario/schema.h"
#include "twin/core/error.h"
#include "twin/fci/protocol.h"
#include "twin/model/transform.h"
#include "twin/plant/arm_model_file.h"
#include "twin/scenario/robot_identity.h"

namespace twin::scenario {

using enum Dimension;

namespace {

/// Turned by `angle` about z, then moved by `z` along it.
Transform TurnedAndRaised(double angle, double z) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, 0, 0, z, 1};
}

/// Reads a file of the robot's data; its key `robot` is for people.
void ReadData(const std::filesystem::path& file, const std::function<void(Map&)>& describe) {
  Map map;
  map.Add("robot", Anything(), "Its name.");
  describe(map);
  map.Read(YamlNode::ParseFile(file.string()));
}

JointVector LoadRotorInertia(const std::filesystem::path& file) {
  JointVector inertia{};
  ReadData(file, [&inertia](Map& map) {
    map.Require("rotor_inertia", Joints(inertia, kInertia), "Seen at the link.")
        .Then([&inertia](const YamlNode& node) {
          for (const double value : inertia) {
            if (value >= 0) continue;
            node.Fail(fmt::format("{} kg m^2 is out of range; it must not be negative", value));
          }
        });
  });
  return inertia;
}

void ReadEndEffector(const std::filesystem::path& file, RobotData& robot) {
  Vector3 inertia{};
  double angle = 0;
  double z = 0;
  const auto tip = [&angle, &z](Map& of) {
    of.Require("angle", Quantity(angle, kAngle, -7, 7));
    of.Require("z", Quantity(z, kLength, -10, 10));
  };
  ReadData(file, [&](Map& map) {
    model::Payload& payload = robot.end_effector;
    map.Require("mass", Quantity(payload.m, kMass, 0, 100));
    map.Require("F_x_Cee", Vector(payload.F_x_C, kLength, -1, 1));
    map.Require("I_ee", Vector(inertia, kInertia, 0, 10));
    map.Require("F_T_NE", Section(tip));
  });
  for (std::size_t i = 0; i < inertia.size(); ++i) robot.end_effector.I[4 * i] = inertia[i];
  robot.F_T_NE = TurnedAndRaised(angle, z);
}

/// The dimensions of a component's velocity, acceleration and jerk.
struct Derivatives {
  Dimension dp, ddp, dddp;
};
constexpr Derivatives kLinear{kVelocity, kAcceleration, kJerk};
constexpr Derivatives kAngular{kAngularVelocity, kAngularAcceleration, kAngularJerk};

Value BoundOf(CartesianBound& bound, const Derivatives& dimensions) {
  constexpr double kLeast = 1e-9;
  constexpr double kMost = 1e9;
  return Section([&bound, dimensions](Map& map) {
    map.Add("dp_max", UnitAndValue(bound.dp_max, dimensions.dp, kLeast, kMost));
    map.Add("ddp_max", UnitAndValue(bound.ddp_max, dimensions.ddp, kLeast, kMost));
    map.Add("dddp_max", UnitAndValue(bound.dddp_max, dimensions.dddp, kLeast, kMost));
    map.RequireAll();
  });
}

void DescribeJoints(Map& map, JointLimits& limits) {
  map.Add("q_min", Joints(limits.q_min, kAngle));
  map.Add("q_max", Joints(limits.q_max, kAngle));
  map.Add("dq_max", Joints(limits.dq_max, kAngularVelocity));
  map.Add("ddq_max", Joints(limits.ddq_max, kAngularAcceleration));
  map.Add("dddq_max", Joints(limits.dddq_max, kAngularJerk));
  map.Add("tau_max", Joints(limits.tau_max, kTorque));
  map.Add("dtau_max", Joints(limits.dtau_max, kTorqueRate));
  map.RequireAll();
  map.Add("velocity_offset", Joints(limits.velocity_offset, kAngularVelocity));
  map.Add("deceleration", Joints(limits.deceleration, kAngularAcceleration));
}

constexpr double kLeastOfBase = 1e-3;
constexpr double kMostOfBase = 1e3;
constexpr const char* kBaseFile = "base.yaml";

Value Most(double& value, Dimension dimension) {
  return Quantity(value, dimension, kLeastOfBase, kMostOfBase);
}

Value AccelerationOf(onboard::BaseAcceleration& acceleration) {
  return Section([&acceleration](Map& map) {
    map.Require("v", Most(acceleration.dv, kAcceleration));
    map.Require("w", Most(acceleration.dw, kAngularAcceleration));
  });
}

void DescribeBase(Map& map, onboard::BaseConfig& config) {
  map.Add("base", Anything(), "Its name.");
  const auto wheels = [&config](Map& of) {
    of.Add("radius", Most(config.wheel_radius, kLength));
    of.Add("track", Most(config.track, kLength));
    of.Add("track_factor", Number(config.track_factor, 1, 10));
    of.Add("torque", Most(config.tau_max, kTorque));
    of.RequireAll();
  };
  const auto most = [&config](Map& of) {
    of.Require("v", Most(config.most.v, kVelocity));
    of.Require("w", Most(config.most.w, kAngularVelocity));
  };
  const auto acceleration = [&config](Map& of) {
    of.Add("ordinary", AccelerationOf(config.ordinary));
    of.Add("lost", AccelerationOf(config.lost));
    of.Add("emergency", AccelerationOf(config.emergency));
    of.RequireAll();
  };
  map.Require("wheels", Section(wheels));
  map.Require("most", Section(most));
  map.Require("acceleration", Section(acceleration));
  map.Require("watchdog", TimeSpan(config.watchdog, kCycle, std::chrono::seconds(10)));
}

onboard::BaseConfig ReadBaseConfig(const std::filesystem::path& file) {
  onboard::BaseConfig config;
  Map map;
  DescribeBase(map, config);
  map.Read(YamlNode::ParseFile(file.string()));
  return config;
}

}  // namespace

Transform RobotData::F_T_EE(const FramePose& NE_T_EE) const {
  return model::Multiply(F_T_NE, NE_T_EE.Matrix());
}

JointLimits LoadJointLimits(const std::filesystem::path& file) {
  JointLimits limits;
  const Value joints = Section([&limits](Map& map) { DescribeJoints(map, limits); });
  ReadData(file, [&](Map& map) {
    map.Require("joints", Validated(joints, [&limits] { limits.Validate(); }));
    map.Add("cartesian", Anything());
  });
  return limits;
}

CartesianLimits LoadCartesianLimits(const std::filesystem::path& file) {
  CartesianLimits limits;
  const auto describe = [&limits](Map& map) {
    map.Add("translation", BoundOf(limits.translation, kLinear));
    map.Add("rotation", BoundOf(limits.rotation, kAngular));
    map.Add("elbow", BoundOf(limits.elbow, kAngular));
    map.RequireAll();
  };
  ReadData(file, [&](Map& map) {
    map.Add("joints", Anything());
    map.Require("cartesian", Section(describe));
  });
  return limits;
}

RobotData LoadRobotData(const std::filesystem::path& models, std::string_view name,
                        plant::HandKind hand) {
  const std::filesystem::path robots = models / "robots";
  RequireFolder(robots, name, "limits.yaml", "robot.model:");
  const RobotIdentity identity = LoadRobotIdentity(models, name);
  RobotData robot;
  robot.protocol = identity.protocol;
  robot.name = name;
  robot.urdf = robots / name / (robot.name + ".urdf");
  if (!identity.has_library_model) robot.arm = plant::ArmModelOf(robot.urdf);
  robot.limits = LoadJointLimits(robots / name / "limits.yaml");
  if (robot.protocol == fci::VersionOf(fci::Protocol::k10) &&
      robot.limits.deceleration == JointVector{}) {
    throw InputError(fmt::format(
        "{}: joints: velocity_offset and deceleration are missing; clients of protocol 10 demand "
        "them, in {} too",
        (robots / name / "limits.yaml").string(), robot.urdf.filename().string()));
  }
  robot.cartesian = LoadCartesianLimits(robots / name / "limits.yaml");
  robot.rotor_inertia = LoadRotorInertia(robots / name / "drives.yaml");
  if (hand != plant::HandKind::kNone) {
    const char* const folder = hand == plant::HandKind::kFrankaHand ? "hand" : "cobot_pump";
    ReadEndEffector(robots / folder / "end_effector.yaml", robot);
  }
  return robot;
}

BaseData LoadBaseData(const std::filesystem::path& models, std::string_view name) {
  const std::filesystem::path robots = models / "robots";
  RequireFolder(robots, name, kBaseFile, "base.model:");
  const std::filesystem::path folder = robots / name;
  return {.urdf = folder / (std::string(name) + ".urdf"),
          .config = ReadBaseConfig(folder / kBaseFile)};
}

}  // namespace twin::scenario
