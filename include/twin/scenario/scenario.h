#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "twin/control/controller.h"
#include "twin/control/parameters.h"
#include "twin/core/error.h"
#include "twin/core/hand_command.h"
#include "twin/core/joint_vector.h"
#include "twin/core/mobile_base.h"
#include "twin/core/modes.h"
#include "twin/core/setting.h"
#include "twin/core/time.h"
#include "twin/loop/loop_config.h"
#include "twin/model/lab_limits.h"
#include "twin/onboard/onboard_config.h"
#include "twin/planning/planner.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/plant/perturbation.h"
#include "twin/reference/feed_forward.h"
#include "twin/reference/trajectory.h"
#include "twin/reference/viability_filter.h"
#include "twin/robot/robot_config.h"
#include "twin/scenario/link_section.h"
#include "twin/scenario/objects.h"
#include "twin/scenario/profile.h"
#include "twin/scenario/render_section.h"

namespace twin::teleop {
struct TeleoperatorConfig;
struct WireConfig;
}  // namespace twin::teleop

namespace twin::scenario {

/// Who advances the time of a simulated robot.
enum class Drive : std::uint8_t {
  kLockstep,  ///< a seeded event queue on a virtual clock: repeatable to the byte
  kRealtime,  ///< the wall clock: robot, communication and controller on threads of their own
};

/// The backend of a robot at the other end of a wire, which keeps its own time.
inline constexpr std::string_view kRemoteBackend = "fci";

/// @throws InputError for an unknown name, and for "remote" of former versions: says what to write.
[[nodiscard]] Drive DriveFromName(std::string_view name);
/// As scenarios spell it.
[[nodiscard]] std::string_view Name(Drive drive) noexcept;

struct RobotSection {
  std::string model = "panda";  ///< folder below models/robots
  plant::ArmPose pose;          ///< of the arm's base in the world
  plant::HandKind hand = plant::HandKind::kFrankaHand;
  std::optional<JointVector> q_start;  ///< rad; absent: the first waypoint; a plan needs it
  double clock_drift_ppm = 0;          ///< of INT's clock against the run's, in [-1000, 1000]
  Duration catch_up = 10 * kCycle;     ///< robot::RobotConfig::catch_up
  setting::Load load;  ///< really there; what INT is told of is the onboard section's
  bool operator==(const RobotSection&) const = default;
};

/// A velocity command to a mobile base, for a duration.
struct DriveEvent {
  Duration at{};    ///< since the run began
  Duration span{};  ///< > 0
  BaseTwist twist;  ///< saturated at the base's limits
  bool operator==(const DriveEvent&) const = default;
};

/// The mobile base that carries the arm. With it the world's frame lies on the floor.
struct BaseSection {
  std::string model = "husky";  ///< folder below models/robots
  BasePose start;               ///< on the floor, m and rad
  /// Commands one after the other; zero in between. None beside an application.
  std::vector<DriveEvent> drive;
  bool operator==(const BaseSection&) const = default;
};

struct PlantSection {
  robot::PlantKind kind = robot::PlantKind::kMujoco;
  plant::FrictionProfile friction = plant::FrictionProfile::kResidual;
  bool armature = true;
  plant::ElasticityProfile elasticity = plant::ElasticityProfile::kRigid;
  plant::ArmProperties arm;  ///< no law of friction, links or delay of the ideal plant
  double mass_scale = 1;     ///< of every link of arm and hand, in [0.5, 2]; not of the ideal plant
  plant::BaseTilt base_tilt;  ///< as plant::MujocoPlantOptions::base_tilt; not of the ideal plant
  double noise_q = 0;         ///< rad, standard deviation, >= 0
  double noise_dq = 0;        ///< rad/s
  double noise_tau_J = 0;     ///< Nm
  bool operator==(const PlantSection&) const = default;
};

/// Thresholds that no force reaches: the robot reports neither contacts nor collisions.
[[nodiscard]] setting::CollisionBehavior NoCollisionBehavior() noexcept;

struct OnboardSection {
  JointVector K_theta = setting::JointImpedance().K_theta;  ///< Nm/rad
  Vector6 K_x = setting::CartesianImpedance().K_x;          ///< N/m, Nm/rad
  setting::CollisionBehavior collision_behavior;
  setting::Load load;  ///< the load that INT assumes; robot.load is the real one
  FramePose EE_T_K;
  FramePose NE_T_EE;
  setting::GuidingMode guiding_mode;
  setting::Filters filters;
  double damping_ratio = onboard::OnboardConfig().damping_ratio;  ///< in (0, 2]
  std::uint32_t abort_after_lost = onboard::OnboardConfig().abort_after_lost;
  double friction_compensation = 0;  ///< share of the drives' friction INT makes up for, in [0, 1]
  bool operator==(const OnboardSection&) const = default;
};

struct TickSection {
  loop::Generator generator = loop::Generator::kRejoining;
  double lambda = 1e-3;  ///< in (0, 1]
  bool rate_matching = true;
  double finish_tolerance = loop::TickConfig().finish_tolerance_rad;  ///< rad, in [1e-9, 1e-2]
  /// In [0, 1 ms]; 0: every state is answered. The asynchronous loop's only: 0 in the others.
  Duration period_tolerance = loop::TickConfig().period_tolerance;
  Duration stall_time = loop::TickConfig().stall_time;  ///< in [1 ms, 10 s]
  double low_pass_hz = loop::TickConfig().low_pass_hz;  ///< in [1, 1000]; 1000: off
  bool limiter = false;
  /// Losses in a row under which the limits are kept at all times, in [0, 100]; absent: no filter,
  /// as of a scenario that says another generator and nothing here.
  std::optional<int> viability = reference::ViabilityFilter::kLostByDefault;
  Delay cost;
  bool operator==(const TickSection&) const = default;
};

/// The default on the torque interface: torques are sent as they are deposited, within the robot's
/// limit of their rate.
[[nodiscard]] inline TickSection TorqueTick() {
  TickSection tick;
  tick.generator = loop::Generator::kNone;
  tick.limiter = true;
  tick.viability.reset();
  return tick;
}

struct ControllerSection {
  /// A user's shared library that has the controller, absolute; empty: it is one of the program's.
  std::filesystem::path library;
  /// Name in the controller registry, or of the library's. Not said in a scenario:
  /// joint_trajectory_effort on the torque interface, joint_trajectory on the others.
  std::string type = "joint_trajectory";
  control::Parameters parameters;  ///< of the controller, understood by it alone
  double rate_hz = 1000;           ///< in [1, 1000]
  double clock_drift_ppm = 0;      ///< in [-1000, 1000]
  Duration phase{};                ///< >= 0
  Delay wake_delay;
  Delay cost;
  reference::FeedForwardTime feed_forward = reference::FeedForwardTime::kSource;
  /// Uniform in [-x, x] on every deposited value, in the unit of motion.interface; x in [0, 1].
  double target_noise = 0;
  bool operator==(const ControllerSection&) const = default;
};

/// One pose of a motion of poses, absolute or against the pose before it.
struct PoseStep {
  std::optional<Vector3> position;  ///< of EE in the base, m; absent: the last one's, plus `by`
  std::optional<Vector3> rpy;       ///< as FramePose::rpy, rad; absent: the last one's, turned
  Vector3 by{};                     ///< base axes, m
  Vector3 turn{};                   ///< as FramePose::rpy, about the base's axes, rad
  std::optional<Duration> at;       ///< since the motion began
  std::string where;                ///< where it was read; no part of the comparison
  bool operator==(const PoseStep& other) const;
};

/// A collision-free configuration, drawn within the joint limits, not near the start.
struct RandomGoal {
  bool operator==(const RandomGoal&) const = default;
};

/// A motion that is planned before the run: from robot.q_start around the scene. The planner
/// assumes that the bodies of the scene do not move and that the hand stays open.
struct PlanSection {
  /// A FramePose: of EE in the base. A JointVector: rad.
  std::variant<RandomGoal, JointVector, FramePose> goal;
  std::optional<std::uint64_t> seed;  ///< of goal and search; absent: the scenario's
  std::uint64_t budget = planning::PlannerOptions().most_checks;  ///< collision checks
  double clearance = planning::PlannerOptions().clearance;        ///< m, in [0.001, 0.1]
  double stretch = 1;  ///< the motion takes this many times as long as planned, in [1, 1000]
  std::string where;   ///< where it was read; no part of the comparison
  bool operator==(const PlanSection& other) const;
};

struct MotionSection {
  control::CommandInterface interface = control::CommandInterface::kJointPosition;
  /// INT's own, kJointImpedance or kCartesianImpedance; of no meaning on the torque interface.
  ControllerMode controller = ControllerMode::kJointImpedance;
  /// At least two; of a motion of poses one: where the arm begins; of a planned one none.
  std::vector<reference::Waypoint> waypoints;
  /// A motion of poses: those after the first, which is the arm's where it begins. Else empty.
  std::vector<PoseStep> poses;
  std::optional<PlanSection> plan;  ///< of a planned motion, which has no waypoints or poses
  /// Used when the waypoints or poses carry no times, and for what is planned.
  reference::Timing timing;
  /// Why the arm may touch something on its way; empty: it must not (run::RequireFree).
  std::string touches;
  /// Where the waypoints were read is no part of the comparison.
  bool operator==(const MotionSection& other) const;
};

/// An application, which makes several motions in place of one (application/application.h).
struct ApplicationSection {
  std::string type;                ///< name in the application registry
  control::Parameters parameters;  ///< understood by it alone
  bool operator==(const ApplicationSection&) const = default;
};

/// Device and wire of the operator in an application with teleoperation.
struct OperatorSection {
  std::string device;              ///< name in the device registry
  control::Parameters parameters;  ///< of the device, understood by it alone
  control::Parameters settings;    ///< of teleop::TeleoperatorConfig
  DirectionSection to_robot;       ///< operator to robot; messages are numbered by their sequence
  DirectionSection from_robot;     ///< robot to operator

  /// @throws InputError naming the field, where it was read, and the range.
  void Validate() const;
  bool operator==(const OperatorSection&) const = default;
};

/// The configuration of a teleoperator, from the key `settings`.
/// @throws InputError naming file, line and key.
[[nodiscard]] teleop::TeleoperatorConfig MakeTeleoperator(const OperatorSection& section);

/// The link between operator and robot. @throws InputError when a parameter is outside its range.
[[nodiscard]] teleop::WireConfig MakeWire(const OperatorSection& section);

/// Limits of the arm's deviation from its target (loop::Deviation) in a successful motion.
/// Infinite: no limit. Absent: the default, see run::LimitOf.
struct MaxDeviation {
  std::optional<double> joints;    ///< rad, of any joint
  std::optional<double> position;  ///< m, of the end effector on the interface of poses
  std::optional<double> angle;     ///< rad, of the same
  bool operator==(const MaxDeviation&) const = default;
};

/// A command to the hand, at a time of the run.
struct HandEvent {
  Duration at{};  ///< since the run began
  HandCommand command;
  bool operator==(const HandEvent&) const = default;
};

/// The place of a name in a file.
struct Place {
  std::string name;   ///< as read; a scenario with another name was changed since
  std::string where;  ///< "<file>:<line>"; empty when nothing was read
};

/// Calls `check`; adds the place of `name` to the text of its InputError.
template <typename Check>
auto At(const Place& place, const std::string& name, Check check) {
  try {
    return check();
  } catch (const InputError& error) {
    if (place.where.empty() || place.name != name) throw;
    throw InputError(place.where + ": " + error.what());
  }
}

/// Places of the names that only a run can check, for messages. Not compared.
struct Places {
  Place backend;
  Place scene;
  Place robot;
  Place base;
  Place controller;
  Place library;
  Place application;
  Place device;
  std::filesystem::path folder;    ///< of the file; empty when nothing was read
  std::optional<Profile> profile;  ///< of which plant, link and robot.load hold the keys
  bool operator==(const Places& /*other*/) const { return true; }
};

/// Everything that describes a run. Two equal scenarios, run by the same program, give the same
/// bytes in every log.
struct Scenario {
  std::string name;         ///< letters, digits, '_' and '-'; names the output folder
  std::string description;  ///< one or more sentences for people; may be empty
  std::uint64_t seed = 1;   ///< of every random number of the run
  std::string backend = "mujoco";
  Drive drive = Drive::kLockstep;  ///< without effect on a remote robot
  loop::LoopKind loop = loop::LoopKind::kAsynchronous;
  std::filesystem::path
      scene;  ///< MJCF of the world, in the models folder or absolute; empty: scenes/floor.xml
  std::vector<ObjectSection> objects;  ///< beside what the scene holds
  RobotSection robot;
  std::optional<BaseSection> base;  ///< absent: the arm stands on the world
  PlantSection plant;
  LinkSection link;
  OnboardSection onboard;
  TickSection tick;
  /// Beside an application: rate, clock, delay and cost of whatever controllers it uses.
  ControllerSection controller;
  MotionSection motion;  ///< empty beside an application
  std::optional<ApplicationSection> application;
  model::LabLimits limits;  ///< beside the robot's own
  MaxDeviation max_deviation;
  std::optional<OperatorSection> operator_section;  ///< `operator`; beside an application only
  std::vector<plant::Perturbation> perturbations;  ///< none on the ideal plant, which feels nothing
  std::vector<robot::PanelEvent> panel;            ///< in order of time
  std::vector<HandEvent> hand;                     ///< in order of time; none without a hand
  RenderSection render;
  bool record = true;  ///< write the log

  Places places;

  [[nodiscard]] bool is_remote() const noexcept { return backend == kRemoteBackend; }
  [[nodiscard]] bool is_lockstep() const noexcept {
    return !is_remote() && drive == Drive::kLockstep;
  }
  /// Who advances time, for summaries and logs: "lockstep", "realtime" or "remote".
  [[nodiscard]] std::string_view drive_name() const noexcept {
    return is_remote() ? "remote" : Name(drive);
  }

  /// Checks what can be checked without the robot's data.
  /// @throws InputError naming section, field, value and range.
  void Validate() const;

  bool operator==(const Scenario&) const = default;
};

/// Reads and validates a scenario and the waypoint file it names (relative to it).
/// @throws InputError "<file>:<line>: <key>: ..." for anything invalid.
[[nodiscard]] Scenario Load(const std::filesystem::path& path);

/// As Load, of a robot that clients move: motion and application may be missing. The arm then
/// stands at robot.q_start, which must be given.
[[nodiscard]] Scenario LoadServed(const std::filesystem::path& path);
/// As LoadServed, from text, as Parse().
[[nodiscard]] Scenario ParseServed(const std::string& text, const std::filesystem::path& file);

/// As Load, from text. @param file  its name in messages; a waypoint file is sought beside it.
[[nodiscard]] Scenario Parse(const std::string& text, const std::filesystem::path& file);

/// @param lab     a name, of a file in the folder `labs` of the models, or a file's path.
/// @param models  DataDirectory::models. @throws InputError listing the names there are.
[[nodiscard]] std::filesystem::path FindLab(std::string_view lab,
                                            const std::filesystem::path& models);

/// Applies a lab to a scenario: properties of a site, which replace those of the scenario. A method
/// that is tuned at neither of two labs must work at both. A lab is a YAML file with these keys and
/// no others:
///   description           for people
///   plant, link           as in scenarios
///   controller            of it wake_delay and cost: how fast the site's workstation is
///   load                  robot.load of scenarios: what hangs on the flange
///   limits                as in scenarios; added to the scenario's (model::LabLimits::Add)
/// @throws InputError "<file>:<line>: <key>: ..." for anything invalid, and for a scenario that
/// contradicts the lab.
void ApplyLab(const std::filesystem::path& file, Scenario& scenario);

/// Canonical text: every field, waypoints included, so that it stands alone. Parse(ToYaml(s)) == s.
[[nodiscard]] std::string ToYaml(const Scenario& scenario);

/// JSON Schema (draft 2020-12) of scenario files: keys, spellings, units, defaults, and ranges of
/// plain numbers. It refuses no file that Load() takes, except for the spelling of plain values (a
/// number in quotes, a text that reads as a number). Load() also refuses what a schema cannot say:
/// quantities out of range, and sections that contradict each other.
[[nodiscard]] std::string JsonSchema();

/// The table of all keys with units, ranges, defaults and meaning, as Markdown:
/// models/scenarios/KEYS.md.
[[nodiscard]] std::string KeyTable();

}  // namespace twin::scenario
