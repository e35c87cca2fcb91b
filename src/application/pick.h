#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "twin/application/application.h"
#include "twin/control/parameters.h"
#include "twin/core/clock.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/time.h"
#include "twin/planning/collision_world.h"
#include "twin/planning/pose_following.h"
#include "twin/plant/scene_object.h"
#include "twin/reference/pose_trajectory.h"
#include "twin/reference/trajectory.h"
#include "twin/scenario/objects.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

// Parts of the applications `pick_and_place` and `hand_over`: parameters, task, grips, planner,
// evaluation.
namespace twin::application {

/// Where on an object a hand takes it.
struct GripPlace {
  double off_centre = 0;  ///< m, from the object's middle, along the bar between the fingers
  Vector3 B_side{};       ///< only towards there, object's axes; zero: either way
};

/// The paths of a task, in their order.
enum Leg : std::size_t { kApproach, kGrasp, kLift, kTransfer, kPlace, kRetreat, kLegs };

struct LegTraits {
  std::string_view name;
  const char* caption;  ///< of its pictures; with the names {object}, {from} and {to}
  bool is_held;         ///< the hand holds the object
};
inline constexpr std::array<LegTraits, kLegs> kLegTraits{{
    {"approach", "Approach: above the {object}", false},
    {"grasp", "Grasp: down to the {object}, and hold it", false},
    {"lift", "Lift: the {object} off the {from}", true},
    {"transfer", "Transfer: above the {to}, turned on the way", true},
    {"place", "Place: down onto the {to}, and let go", true},
    {"retreat", "Retreat: straight away from it", false},
}};

/// An object and its goal. All poses and directions in the base O.
struct PickTask {
  Transform X_WO = kIdentityTransform;  ///< where the base stands in the world
  plant::SceneObject object;            ///< X_WB is its pose O_T_B before the task, as perceived
  Transform O_T_object = kIdentityTransform;  ///< the true one
  Transform O_T_goal = kIdentityTransform;
  std::string from{};        ///< part that supports it, and that it may touch when lifted; or empty
  std::string to{};          ///< part that supports it at the goal; empty: a robot takes it there
  Vector3 from_up{0, 0, 1};  ///< normal of the supporting face
  Vector3 to_up{0, 0, 1};
  double nominal_mass = 0;  ///< of the object without its random spread, kg: the robot's load
  GripPlace grip{};         ///< where the hand takes it
  Vector3 withdraw{};       ///< further way of the hand at the end of the retreat, m
  /// Puts other arms where they stand during a leg; empty: there are none.
  std::function<void(planning::CollisionWorld&, Leg)> around{};
};

/// Distances and speeds of the transport.
struct PickOptions {
  double above = 0.08;      ///< m, length of the straight path to and from the object
  double clearance = 0.01;  ///< m, from all parts, on the transfer paths
  double near = 0.002;      ///< m, from all parts, on the straight paths to object and goal
  double gap = 5e-4;        ///< m, between object and surface at the release
  double room = 0.016;      ///< m, width of the open hand minus that of the object
  reference::Timing pace{.duration = {},
                         .velocity_scale = 0.2,
                         .acceleration_scale = 0.06,
                         .jerk_scale = 0.02};  ///< of the end effector's limits
  /// Pace of the paths that end at object or goal, where a lag after lost messages is a pose error.
  reference::Timing down_pace{
      .duration = {}, .velocity_scale = 0.04, .acceleration_scale = 0.02, .jerk_scale = 0.02};
  planning::FollowOptions follow{};
  /// Collision checks for sampled paths, over all attempts of a plan; 0: none are sampled.
  std::uint64_t budget = 200'000;
};

/// How an object is picked: parameters, with their keys in brackets.
struct Handling {
  /// @throws InputError naming file, line and key.
  explicit Handling(control::ParameterReader& parameters);

  std::string object;  ///< object of the scenario [object]
  /// Half widths of uniform ranges of the perceived pose about the true one, in the object's frame
  /// [perception.spread].
  scenario::FramePose perception;
  double force = 0;      ///< of each finger, N [grasp.force]
  double speed = 0;      ///< of the closing hand, m/s [grasp.speed]
  double tolerance = 0;  ///< of the width of a held object, m [grasp.tolerance]
  int tries = 0;         ///< grasps, in all [grasp.tries]
  PickOptions options;
  std::string object_key;  ///< "<file>:<line>: application.parameters.object: "
};

/// Where an object is put down, likewise.
struct PutDown {
  explicit PutDown(control::ParameterReader& parameters);

  std::string on;  ///< supporting object at the goal [place.on]
  /// Position and rpy on that object's top [place.position, place.rpy].
  scenario::FramePose place;
  scenario::FramePose spread;  ///< half widths of uniform ranges of these [place.spread]
  std::string on_key;          ///< as object_key, for place.on
};

/// Position and rpy below a key, of two reaches at most. @throws InputError as ParameterReader.
[[nodiscard]] scenario::FramePose ReadPlace(control::ParameterReader& parameters,
                                            const std::string& key);

/// The object, as it is before the task; without a goal.
/// @throws InputError if the scenario lacks it (lists those it has), or it is fixed, or a ball,
/// which would roll away, or stands on nothing.
[[nodiscard]] PickTask ObjectOf(const scenario::Scenario& scenario, const Handling& handling);
/// Adds the goal drawn by the scenario's seed. @throws InputError if the scenario lacks its
/// surface.
void AddGoal(const scenario::Scenario& scenario, const PutDown& put_down, PickTask& task);
/// @throws InputError for a hand without fingers.
void RequireFingers(const scenario::Scenario& scenario);

/// Grasp pose of the hand on an object.
struct Grip {
  Transform B_T_NE = kIdentityTransform;  ///< between the fingertips, in the object's frame
  Vector3 B_up{0, 0, 1};                  ///< direction from which the hand comes, object's axes
  double width = 0;                       ///< of the object between the fingers, m
};

/// Clearances of a grip.
struct GripRoom {
  double palm = 0.01;     ///< m, between object and palm
  double below = 0.005;   ///< m, between the fingertips and the surface below the object
  double beside = 0.003;  ///< m, at each finger of the open hand
};

/// All grips from above, each in two orientations: on a box at either pair of upright faces, on an
/// upright cylinder at eighths of its circumference, on a lying one across its axis or at its ends.
/// The grip is at half the object's height, or higher where the palm would touch the object.
/// Off its middle a box or a lying cylinder is taken, where it is long enough for the fingers.
/// @param up  normal of the surface below the object, base.
/// @returns an empty list for an object that is too wide, too flat or too short.
[[nodiscard]] std::vector<Grip> GripsOf(const plant::SceneObject& object, const Vector3& up,
                                        const GripRoom& room, const GripPlace& place = {});

/// A result, or the reason of the failure.
template <typename T>
using OrReason = std::variant<T, std::string>;

/// A path of the end effector.
struct LegPlan {
  std::vector<Transform> poses{};             ///< from its start on
  std::vector<reference::Waypoint> joints{};  ///< instead, of a sampled path, with their times
  Duration duration{};
  JointVector q_start{};  ///< rad
  JointVector q_end{};
  std::vector<Vector3> path{};  ///< of the end effector, base frame, m, 2 cm apart

  [[nodiscard]] bool is_at_end() const noexcept { return poses.empty() && joints.empty(); }
};

struct PickPlan {
  Grip grip;
  std::array<LegPlan, kLegs> legs;  ///< legs before the first requested one are empty
  Duration duration{};              ///< of all legs
};

/// The path of a leg. @pre it has poses. @throws InputError as PoseTrajectory.
[[nodiscard]] reference::PoseTrajectory PathOf(const LegPlan& leg, const CartesianLimits& limits);

/// Plans the whole task before the first motion: a grip for which all paths up to the retreat are
/// free of collision and within the joints' position and velocity limits.
///
/// Tries all grips (GripsOf()), and for each several approach and transfer paths: straight, and
/// over points that are higher or nearer to the robot. Simulates the controller on each path
/// (planning::Follow), in a world in which the object stands, is held, or is at its goal. Returns
/// the fastest plan. If no grip leads to the goal so, it samples paths in joint space for approach
/// and transfer (planning::Planner), to any configuration from which the next paths lead on, and
/// returns the first plan.
///
/// Threads: the world's. Deterministic. Not for real-time code.
class PickPlanner {
 public:
  /// @param world, robot, clock  must outlive the planner. @param F_T_EE  end effector in the
  /// flange. @param seed  of sampled paths.
  PickPlanner(planning::CollisionWorld& world, const scenario::RobotData& robot, const Clock& clock,
              const Transform& F_T_EE, PickTask task, const PickOptions& options,
              std::uint64_t seed);

  /// Plans all legs. @param q  the arm's position, rad, at rest.
  /// @returns the plan, or the reason of the failure: the furthest leg, each way that was tried
  /// there and its obstacle, and the legs at which other grips failed.
  [[nodiscard]] OrReason<PickPlan> Plan(const JointVector& q);

  /// Plans the legs from `first` on, which begins at q. @param grip  of the first plan.
  [[nodiscard]] OrReason<PickPlan> PlanFrom(const JointVector& q, Leg first, const Grip& grip);

  /// Plans a straight path away from the object, with open fingers, before another attempt.
  [[nodiscard]] OrReason<LegPlan> BackOff(const JointVector& q, const Grip& grip);

  /// Width of the open hand around the object, m.
  [[nodiscard]] double OpeningFor(const Grip& grip) const noexcept;

 private:
  struct Route {
    std::string_view name;
    std::vector<Transform> poses;
  };
  /// What was tried with a grip at the furthest leg that it reached.
  struct Trial {
    Leg leg = kApproach;
    std::vector<std::pair<std::string_view, std::string>> failures{};  ///< of ways, each once
  };

  [[nodiscard]] std::vector<Route> RoutesOf(Leg leg, const Transform& here, const Grip& grip) const;
  void SetWorld(Leg leg, const Grip& grip);
  /// Times and follows a leg within the joint limits. @returns its joint positions, rad, a few
  /// milliseconds apart, or the reason of the failure. @throws InputError as PoseTrajectory.
  [[nodiscard]] OrReason<std::vector<JointVector>> Follow(LegPlan& leg, const JointVector& q,
                                                          const reference::Timing& pace) const;
  [[nodiscard]] OrReason<LegPlan> Try(const Route& route, const JointVector& q,
                                      const reference::Timing& pace, double clearance);
  /// Depth-first search. @returns true if it found all legs from this one on.
  bool Search(const JointVector& q, Leg leg, PickPlan& plan);
  /// Continues it by sampled paths of a leg. @param O_T_EE  the leg's end.
  bool SearchSampled(const JointVector& q, Leg leg, const Transform& O_T_EE, PickPlan& plan);
  [[nodiscard]] OrReason<LegPlan> Sample(const JointVector& q, const JointVector& goal);
  /// Notes the failure of a way of the grip that is being tried.
  void Note(Leg leg, std::string_view way, const std::string& why);
  /// Text about the grip of `trials_` that came furthest: "the way "grasp": straight: ...".
  [[nodiscard]] std::string Furthest() const;
  [[nodiscard]] Transform PoseAt(const JointVector& q) const noexcept;

  planning::CollisionWorld& world_;
  scenario::RobotData robot_;  ///< its speeds lowered to the world's caps
  const Transform F_T_EE_;
  const PickTask task_;
  const PickOptions options_;
  const Clock& clock_;
  const std::uint64_t seed_;
  bool samples_ = false;           ///< the fixed ways have failed
  std::uint64_t checks_left_ = 0;  ///< of the budget
  std::vector<Trial> trials_;      ///< one per grip
  std::size_t grip_ = 0;           ///< index of the grip that is being tried
};

/// Data of a run for its evaluation, from the robot's reports.
struct PickRecord {
  PickTask task;
  JointLimits limits;
  double width_grasped = 0;  ///< m
  double width_placed = 0;   ///< before the release, m
  bool is_placed = false;
  Transform O_T_EE_placed = kIdentityTransform;  ///< measured, before the release
  Transform B_T_EE = kIdentityTransform;         ///< as planned
  Duration moved{};                              ///< planned duration of all motions
  std::string partner{};  ///< robot that gives or takes the object: "right"; empty: none
  std::string support{};  ///< what bears the object before the partner gives it
  Time offered{};         ///< of the giver: when it held the object out
};

/// The demands of pick and place, further quantities and figures. Of a robot that gives the object,
/// the goal is where it holds it out, until the partner takes it; of one that takes it, also that
/// both hands have held it together.
[[nodiscard]] Evaluation EvaluatePick(const PickRecord& record, const TaskResult& task_result,
                                      const Evidence& evidence);

}  // namespace twin::application
