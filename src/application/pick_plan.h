#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "application/grips.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/time.h"
#include "twin/planning/collision_world.h"
#include "twin/planning/pose_following.h"
#include "twin/plant/scene_object.h"
#include "twin/reference/pose_trajectory.h"

namespace twin::application {

/// What is to be carried where. All poses in the base, which is the world.
struct PickTask {
  plant::SceneObject object;  ///< as it stands: X_WB is its pose
  Transform O_T_goal = kIdentityTransform;
  std::string from{};        ///< part on which it stands, and which it touches as it is lifted
  std::string to{};          ///< part on which it is put
  Vector3 from_up{0, 0, 1};  ///< normal of the face on which it stands
  Vector3 to_up{0, 0, 1};
};

/// How it is carried.
struct PickOptions {
  double above = 0.08;      ///< m: how far from the object's place the hand comes straight
  double clearance = 0.01;  ///< m, from everything, while it is carried across
  double near = 0.002;      ///< m, from everything, on the straight way to object and place
  double gap = 5e-4;        ///< m, between object and place when it is let go
  double room = 0.016;      ///< m, by which the hand is open wider than the object
  reference::Timing pace{.duration = {},
                         .velocity_scale = 0.2,
                         .acceleration_scale = 0.06,
                         .jerk_scale = 0.02};  ///< of the end effector's limits
  /// Of the ways that end at object and place: what lags behind lost messages is a distance there.
  reference::Timing down_pace{
      .duration = {}, .velocity_scale = 0.04, .acceleration_scale = 0.02, .jerk_scale = 0.02};
  planning::FollowOptions follow{};
};

/// The ways of a task, in their order.
enum class Leg : std::uint8_t { kApproach, kGrasp, kLift, kTransfer, kPlace, kRetreat };
inline constexpr std::size_t kLegs = 6;
/// "approach", ...
[[nodiscard]] std::string_view Name(Leg leg) noexcept;

/// A way that the end effector follows.
struct LegPlan {
  std::vector<Transform> poses{};  ///< the first is where it begins; empty: there is none to go
  Duration duration{};
  JointVector q_start{};  ///< rad
  JointVector q_end{};
  std::vector<Vector3> way{};  ///< of the end effector, base frame, m, 2 cm apart
};

struct PickPlan {
  Grip grip;
  std::array<LegPlan, kLegs> legs;  ///< those before the first that was asked for are empty
  Duration duration{};              ///< of all ways
};

/// The path of a leg that has poses. @throws InputError as PoseTrajectory.
[[nodiscard]] reference::PoseTrajectory PathOf(const LegPlan& leg, const CartesianLimits& limits);

/// What of the robot a planner needs. References must outlive it.
struct PickRobot {
  const JointLimits& limits;
  const CartesianLimits& cartesian;
  Transform F_T_NE;  ///< between the fingertips
  Transform F_T_EE;
};

/// Plans a whole task before anything moves: how to grip the object so that every way from here to
/// the retreat is free, inside the joint limits, and slow enough for the joints.
///
/// Tried are all grips from above that the object's shape allows (a box by either pair of faces, a
/// cylinder all around), both ways round; for each a few ways across: straight, and over points
/// that are higher or nearer to the robot. Each is followed as the controller will follow it
/// (planning::Follow), in a world in which the object stands, is held, or is where it was put. The
/// grip that takes the least time is taken.
///
/// Threads: the world's. Deterministic. Not for real-time code.
class PickPlanner {
 public:
  /// @param world  must outlive the planner.
  PickPlanner(planning::CollisionWorld& world, const PickRobot& robot, PickTask task,
              const PickOptions& options);

  /// Everything from the approach on. @param q  rad, where the arm stands, at rest.
  /// @returns the plan, or why there is none: the way that could not be gone, and what is there.
  [[nodiscard]] std::variant<PickPlan, std::string> Plan(const JointVector& q);

  /// What is left, from a way on that begins where the arm is. @param grip  as before.
  [[nodiscard]] std::variant<PickPlan, std::string> PlanFrom(const JointVector& q, Leg first,
                                                             const Grip& grip);

  /// Straight away from the object's place, with open fingers around it: to try once more.
  [[nodiscard]] std::variant<LegPlan, std::string> BackOff(const JointVector& q, const Grip& grip);

  /// All grips the shape allows.
  [[nodiscard]] std::vector<Grip> Grips() const;

  /// The opening of the hand at which it goes to the object, m.
  [[nodiscard]] double OpeningFor(const Grip& grip) const noexcept;

 private:
  using Route = std::vector<Transform>;

  [[nodiscard]] std::vector<Route> RoutesOf(Leg leg, const Transform& here, const Grip& grip) const;
  void SetWorld(Leg leg, const Grip& grip);
  /// A leg and where the joints come to on it, a few milliseconds apart.
  struct Way {
    LegPlan leg;
    std::vector<JointVector> q;
  };
  /// Timed so that no joint is too fast. @throws InputError as PoseTrajectory.
  [[nodiscard]] std::variant<Way, std::string> Followed(LegPlan leg, const JointVector& q,
                                                        const reference::Timing& pace) const;
  [[nodiscard]] std::variant<PickPlan, std::string> PlanWith(const JointVector& q, Leg first,
                                                             const Grip& grip);
  [[nodiscard]] std::variant<LegPlan, std::string> Try(const Route& route, const JointVector& q,
                                                       const reference::Timing& pace,
                                                       double clearance);
  /// Depth first. @returns whether all legs from this one on are found.
  bool Search(const JointVector& q, std::size_t leg, PickPlan& plan);
  [[nodiscard]] Transform PoseAt(const JointVector& q) const noexcept;

  planning::CollisionWorld& world_;
  const PickRobot robot_;
  const PickTask task_;
  const PickOptions options_;
  std::size_t furthest_ = 0;  ///< leg at which the best try failed
  std::string failure_;       ///< of that
};

}  // namespace twin::application
