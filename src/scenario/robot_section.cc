
#include "scenario/sections.h"
#include "twin/core/error.h"
#include "twin/core/text.h"

// The sections robot, base, plant and onboard.
namespace twin::scenario {

using enum Dimension;

namespace {

constexpr double kMostThreshold = 1e6;  // N or Nm
constexpr double kMostLength = 10;      // m
constexpr double kMostInertia = 100;    // kg m^2
constexpr double kMostSpeed = 100;      // m/s, rad/s: a base saturates earlier

void RequireValid(const Setting& setting) {
  if (const auto bad = FindBadValue(setting)) throw InputError(Describe(*bad));
}

std::span<double, 3> FirstHalf(Vector6& whole) {
  return std::span<double, 6>(whole).first<3>();
}

std::span<double, 3> LastHalf(Vector6& whole) {
  return std::span<double, 6>(whole).last<3>();
}

Value Forces(Vector6& forces) {
  return Section([&forces](Map& map) {
    map.Add("force", Axes(FirstHalf(forces), kForce, 0, kMostThreshold),
            "Force along the axes of K.");
    map.Add("moment", Axes(LastHalf(forces), kTorque, 0, kMostThreshold),
            "Moment about the axes of K.");
  });
}

Value Torques(JointVector& torques) {
  return Joints(torques, kTorque);
}

/// Adds a threshold without suffix, which sets both thresholds.
template <typename Bind, typename Values>
void AddBoth(Map& map, const std::string& key, Bind bind, Values& acc, Values& nominal,
             std::string_view meaning) {
  map.Add(key, bind(acc), meaning).OmitIf(true).Then([&acc, &nominal](const YamlNode& /*node*/) {
    nominal = acc;
  });
}

template <typename Bind, typename Values>
void AddSets(Map& map, const std::string& what, Bind bind, Values& lower_acc, Values& upper_acc,
             Values& lower_nominal, Values& upper_nominal) {
  map.Add("lower_" + what + "_acc", bind(lower_acc), "Contact, while the reference accelerates.");
  map.Add("upper_" + what + "_acc", bind(upper_acc), "Reflex, while the reference accelerates.");
  map.Add("lower_" + what + "_nominal", bind(lower_nominal), "Contact, while it does not.");
  map.Add("upper_" + what + "_nominal", bind(upper_nominal), "Reflex, while it does not.");
}

}  // namespace

static void Describe(Map& map, setting::CollisionBehavior& b) {
  AddBoth(map, "lower_torque", Torques, b.lower_torque_acc, b.lower_torque_nominal,
          "Above these torques of the joints the robot reports a contact.");
  AddBoth(map, "upper_torque", Torques, b.upper_torque_acc, b.upper_torque_nominal,
          "Above these torques of the joints the robot stops with a reflex.");
  AddBoth(map, "lower_force", Forces, b.lower_force_acc, b.lower_force_nominal,
          "Above these forces in K the robot reports a contact.");
  AddBoth(map, "upper_force", Forces, b.upper_force_acc, b.upper_force_nominal,
          "Above these forces in K the robot stops with a reflex.");
  AddSets(map, "torque", Torques, b.lower_torque_acc, b.upper_torque_acc, b.lower_torque_nominal,
          b.upper_torque_nominal);
  AddSets(map, "force", Forces, b.lower_force_acc, b.upper_force_acc, b.lower_force_nominal,
          b.upper_force_nominal);
}

static void Describe(Map& map, setting::GuidingMode& mode) {
  static constexpr std::array<Spelling<std::size_t>, 6> kAxes{
      {{"x", 0}, {"y", 1}, {"z", 2}, {"R", 3}, {"P", 4}, {"Y", 5}}};
  std::vector<std::size_t> free;
  for (std::size_t i = 0; i < kAxes.size(); ++i) {
    if (mode.axes[i]) free.push_back(i);
  }
  const auto axis = [](std::size_t& index) {
    Value value = Choice(index, kAxes);
    value.write = [&index](int /*indent*/) { return YamlQuoted(kAxes[index].first); };
    return value;
  };
  map.Add("axes",
          Converted(
              free, [axis](auto& list) { return List(list, axis); },
              [&mode](const std::vector<std::size_t>& list) {
                mode.axes = {};
                for (const std::size_t i : list) mode.axes[i] = true;
              }),
          "Axes of the base along and about which the arm can be led.");
  map.Add("elbow", Bool(mode.elbow), "Whether the elbow can be led.");
}

static void Describe(Map& map, setting::Filters& filters) {
  map.Add("joint_position", Cutoff(filters.joint_position_hz), "Low-pass on joint positions.");
  map.Add("joint_velocity", Cutoff(filters.joint_velocity_hz), "Low-pass on joint velocities.");
  map.Add("cartesian_position", Cutoff(filters.cartesian_position_hz), "Low-pass on poses.");
  map.Add("cartesian_velocity", Cutoff(filters.cartesian_velocity_hz), "Low-pass on twists.");
  map.Add("controller", Cutoff(filters.controller_hz), "Low-pass on torques.");
}

/// @param frame  of the centre of mass, and of what its moments are, for people.
static void DescribeBody(Map& map, setting::Load& load, std::string_view position,
                         std::string_view inertia) {
  Matrix3& I = load.I_load;
  map.Require("mass", Quantity(load.m_load, kMass, 0, 100), "Mass of the body.");
  map.Add("position", Vector(load.F_x_Cload, kLength, -kMostLength, kMostLength), position);
  map.Add("inertia",
          Converted(
              Vector3{I[0], I[4], I[8]},
              [](Vector3& moments) { return Vector(moments, kInertia, 0, kMostInertia); },
              [&I](const Vector3& moments) {
                for (std::size_t i = 0; i < 3; ++i) I[4 * i] = moments[i];
              }),
          inertia);
  map.Add(
      "products_of_inertia",
      Converted(
          Vector3{I[3], I[6], I[7]},
          [](Vector3& products) { return Vector(products, kInertia, -kMostInertia, kMostInertia); },
          [&I](const Vector3& products) {
            const auto [xy, xz, yz] = products;
            I = {I[0], xy, xz, xy, I[4], yz, xz, yz, I[8]};
          }),
      "Products of inertia: xy, xz, yz.");
}

static void Describe(Map& map, setting::Load& load) {
  DescribeBody(
      map, load, "Centre of mass in the flange frame.",
      "Moments about the centre of mass: xx, yy, zz; of robot.load all zero: a steel ball's.");
}

static void Describe(Map& map, plant::ArmPose& pose) {
  map.Add("position", Vector(pose.position, kLength, -100, 100), "Of its origin.");
  map.Add("yaw", Quantity(pose.yaw, kAngle, -kTurn, kTurn), "Turn about z.");
}

static void Describe(Map& map, BasePose& pose) {
  map.Add("x", Quantity(pose.x, kLength, -100, 100), "Distance ahead.");
  map.Add("y", Quantity(pose.y, kLength, -100, 100), "Distance to the left.");
  map.Add("yaw", Quantity(pose.yaw, kAngle, -kTurn, kTurn), "Heading about z.");
}

void Describe(Map& map, FramePose& pose) {
  map.Add("position", Vector(pose.position, kLength, -kMostLength, kMostLength),
          "Origin of the frame.");
  map.Add("rpy", Vector(pose.rpy, kAngle, -kTurn, kTurn), "Roll, pitch, yaw about fixed axes.");
}

Value Cutoff(double& cutoff_hz) {
  return OrWord(
      "off", [&cutoff_hz] { return cutoff_hz == kLowPassOff; },
      [&cutoff_hz] { cutoff_hz = kLowPassOff; }, Quantity(cutoff_hz, kFrequency, 1, kLowPassOff));
}

Value Drift(double& ppm) {
  return Quantity(ppm, kDrift, -1000, 1000);
}

Value LoadOf(setting::Load& load) {
  return Defined("load", "A body on the flange.",
                 Validated(SectionOf(load), [&load] { RequireValid(load); }));
}

/// A key that ReadProfile() takes. It is not written: its consequences are.
static Value ReadBefore(Value value) {
  value.write = [](int /*indent*/) { return std::string(); };
  return value;
}

void DescribeRobot(Map& map, Scenario& scenario) {
  RobotSection& robot = scenario.robot;
  map.Add("model", Identifier(robot.model), "Folder below models/robots.")
      .At(scenario.places.robot);
  map.Add("profile", ReadBefore(Converted(std::string(), Text, [](auto& /*name*/) {})),
          "What was identified of the robot, for keys of plant, link and robot.load that the "
          "scenario leaves out: a file beside this one, in ../profiles, or absolute.");
  map.Add("profile_draw",
          ReadBefore(Converted(
              std::uint64_t{0}, [](auto& draw) { return Integer(draw, 0, 1'000'000'000); },
              [](auto /*draw*/) {})),
          "Above 0: number of a draw from the profile's covariance.");
  map.Add("pose", SectionOf(robot.pose), "Where the arm's base stands in the world.")
      .OmitIf(robot.pose == plant::ArmPose());
  map.Add("hand", Choice(robot.hand, kHandNames), "What is mounted on the flange.");
  map.Add("q_start", Optional(robot.q_start, [](JointVector& q) { return Joints(q, kAngle); }),
          "Where the arm starts; absent: at the first waypoint.");
  map.Add("clock_drift", Drift(robot.clock_drift_ppm),
          "How much faster the robot's clock runs than the run's.");
  map.Add("catch_up", TimeSpan(robot.catch_up, Duration::zero(), robot::kLongestCatchUp),
          "drive: realtime: for how long the host may stop the robot's thread so that INT makes up "
          "for the cycles, without commands; longer stops lengthen the run.");
  map.Add("load", LoadOf(robot.load),
          "A body that hangs on the flange; onboard.load is what the robot believes.");
}

void Describe(Map& map, BaseSection& base, Place& place) {
  map.Add("model", Identifier(base.model), "Folder below models/robots.").At(place);
  map.Add("start", SectionOf(base.start), "Where the middle of the base starts on the floor.");
  const auto event = [&base](DriveEvent& drive) {
    return Section([&base, &drive](Map& item) {
      const auto end = [](const DriveEvent& one) { return one.at + one.span; };
      item.Require("at",
                   TimeInOrder(base.drive, drive, end,
                               "comes before the end of the drive above it; give them one after "
                               "the other"),
                   "Time since the run began.");
      item.Require("for", TimeSpan(drive.span, kCycle, kDay), "Duration.");
      item.Add("v", Quantity(drive.twist.v, kVelocity, -kMostSpeed, kMostSpeed),
               "Velocity ahead; the base saturates it at its own limit.");
      item.Add("w", Quantity(drive.twist.w, kAngularVelocity, -kMostSpeed, kMostSpeed),
               "Velocity about z, to the left.");
    });
  };
  map.Add("drive", List(base.drive, event, Style::kBlock),
          "Commanded velocities, one after the other; zero in between.")
      .OmitIf(base.drive.empty());
}

static void Describe(Map& map, plant::BaseTilt& tilt) {
  map.Add("roll", Quantity(tilt.roll, kAngle, -0.2, 0.2), "Angle about x.");
  map.Add("pitch", Quantity(tilt.pitch, kAngle, -0.2, 0.2), "Angle about y.");
}

static void Describe(Map& map, plant::FrictionLaw& law) {
  map.Add("viscous", Joints(law.viscous, kAngularDamping), "Torque per velocity.");
  map.Add("coulomb", Joints(law.coulomb, kTorque), "Half the height of the sigmoid.");
  map.Add("offset", Joints(law.offset, kTorque), "Torque at rest.");
  map.Add("steepness", Joints(law.steepness, kSteepness), "Of the sigmoid.");
  map.Add("shift", Joints(law.shift, kAngularVelocity), "Of the sigmoid's middle.");
}

static Value FrictionOf(PlantSection& plant) {
  Value profile = Choice(plant.friction, kFrictionNames);
  profile.read = [&plant, read = profile.read](const YamlNode& node) {
    plant.arm.friction_law.reset();
    read(node);
  };
  const auto law = Optional(plant.arm.friction_law, [](auto& one) { return SectionOf(one); });
  return Either(profile, law, [&plant] { return !plant.arm.friction_law; });
}

static Value ArmatureOf(PlantSection& plant) {
  Value is_there = Bool(plant.armature);
  is_there.read = [&plant, read = is_there.read](const YamlNode& node) {
    plant.arm.armature.reset();
    read(node);
  };
  Value values = Optional(plant.arm.armature, [](JointVector& B) { return Joints(B, kInertia); });
  values.read = [&plant, read = values.read](const YamlNode& node) {
    plant.armature = true;
    read(node);
  };
  return Either(is_there, values, [&plant] { return !plant.armature || !plant.arm.armature; });
}

static Value ElasticityOf(PlantSection& plant) {
  Value kind = Choice(plant.elasticity, kElasticityNames);
  kind.read = [&plant, read = kind.read](const YamlNode& node) {
    plant.arm.stiffness = plant::kJointStiffness;
    read(node);
  };
  Value stiffness = Joints(plant.arm.stiffness, kStiffness);
  stiffness.read = [&plant, read = stiffness.read](const YamlNode& node) {
    plant.elasticity = plant::ElasticityProfile::kStatic;
    read(node);
  };
  return Either(kind, stiffness, [&plant] {
    return plant.elasticity == plant::ElasticityProfile::kRigid ||
           plant.arm.stiffness == plant::kJointStiffness;
  });
}

static Value LinkOf(setting::Load& link) {
  return Section([&link](Map& map) {
    DescribeBody(map, link, "Centre of mass in the frame of the link's joint.",
                 "Moments about the centre of mass: xx, yy, zz.");
  });
}

void Describe(Map& map, PlantSection& plant) {
  map.Add("kind", Choice(plant.kind, kPlantNames),
          "Physics by MuJoCo, or an arm that does exactly what is desired.");
  map.Add(
      "friction", FrictionOf(plant),
      "Friction of the joints, opposed to their velocity v; a map: viscous v + coulomb (2 / (1 + "
      "exp(-steepness (v + shift))) - 2 / (1 + exp(-steepness shift))) + offset.");
  map.Add("armature", ArmatureOf(plant), "Reflected inertia of the rotors; a map: their values.");
  map.Add(
      "elasticity", ElasticityOf(plant),
      "rigid: theta = q; static: theta = q + tau_J / k, k = 14250 Nm/rad; a map: each joint's k.");
  map.Add("delay", Section([&plant](Map& of) {
            of.Add("tau_J",
                   TimeSpan(plant.arm.torque_delay, Duration::zero(), plant::kLongestTorqueDelay),
                   "Of the torque sensors.");
          }),
          "By how much sensors are late.")
      .OmitIf(plant.arm.torque_delay == Duration::zero());
  map.Add("links", List(plant.arm.links, LinkOf, Style::kBlock),
          "Masses of links 1 to 7 in place of the URDF's: all seven.")
      .OmitIf(plant.arm.links.empty());
  map.Add("mass_scale", Number(plant.mass_scale, 0.5, 2),
          "Factor on the mass of every link of arm and hand; the robot's controller ignores it.")
      .OmitIf(plant.mass_scale == 1);
  map.Add("base_tilt", SectionOf(plant.base_tilt),
          "Base, and all beside it, out of level; the robot's controller ignores it.")
      .OmitIf(plant.base_tilt == plant::BaseTilt());
  const auto noise = [&plant](Map& of) {
    of.Add("q", Quantity(plant.noise_q, kAngle, 0, 1), "Noise of joint positions.");
    of.Add("dq", Quantity(plant.noise_dq, kAngularVelocity, 0, 10), "Noise of velocities.");
    of.Add("tau_J", Quantity(plant.noise_tau_J, kTorque, 0, 100), "Noise of torques.");
  };
  map.Add("noise", Section(noise), "Standard deviations of the sensors' white noise.");
}

void Describe(Map& map, OnboardSection& onboard) {
  map.Add("K_theta",
          Validated(Joints(onboard.K_theta, kStiffness),
                    [&] { RequireValid(setting::JointImpedance{onboard.K_theta}); }),
          "Stiffness under motion.controller: joint_impedance, each in [0, 14250] Nm/rad.");
  const auto K_x = [&onboard](Map& of) {
    of.Add("translation", Axes(FirstHalf(onboard.K_x), kLinearStiffness, 10, 3000),
           "Stiffness along the axes of K.");
    of.Add("rotation", Axes(LastHalf(onboard.K_x), kStiffness, 1, 300),
           "Stiffness about the axes of K.");
  };
  map.Add("K_x", Section(K_x), "Stiffness under motion.controller: cartesian_impedance.");
  setting::CollisionBehavior& behavior = onboard.collision_behavior;
  map.Add(
      "collision_behavior",
      OrWord(
          "off", [&behavior] { return behavior == NoCollisionBehavior(); },
          [&behavior] { behavior = NoCollisionBehavior(); },
          Validated(SectionOf(behavior, Style::kBlock), [&behavior] { RequireValid(behavior); })),
      "Thresholds of the forces that the robot estimates from outside.");
  map.Add("load", LoadOf(onboard.load), "What the robot believes to carry.");
  map.Add("EE_T_K", SectionOf(onboard.EE_T_K), "Stiffness frame K in the end effector's.");
  map.Add("NE_T_EE", SectionOf(onboard.NE_T_EE), "End effector in the nominal one.");
  map.Add("guiding_mode", SectionOf(onboard.guiding_mode), "What can be led while guiding.");
  map.Add("filters", SectionOf(onboard.filters),
          "Cut-off frequencies of the robot's low-passes; only controller goes with rejoining.");
  map.Add("damping_ratio", Number(onboard.damping_ratio, 1e-3, 2),
          "Damping ratio of both impedances.");
  map.Add("abort_after_lost", Integer(onboard.abort_after_lost, 1, 1'000'000),
          "Commands lost in a row at which the robot ends the motion.");
  map.Add("friction_compensation", Number(onboard.friction_compensation, 0, 1),
          "Share of the joints' friction that the robot makes up for.");
}

}  // namespace twin::scenario
