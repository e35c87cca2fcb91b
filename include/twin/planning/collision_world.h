#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::planning {

/// The arm, where it comes too near to itself by the reckoning of the robot's own guard.
inline constexpr std::string_view kGuardedArm = "the arm";
inline constexpr std::string_view kGuardedArmItself = "itself (by the robot's own guard)";

/// Two parts that touch, or come closer than was asked for. A part is a body of the model
/// ("panda_link5", "panda_hand", "box") or, of what is fixed to the world, one shape by its name
/// ("table"). The names live as long as the world.
struct Touch {
  std::string_view a;   ///< of the robot, or of what it holds; kGuardedArm
  std::string_view b;   ///< of the robot, of what it holds, or of the scene
  double distance = 0;  ///< m; negative where they overlap, but no measure of how deep: between two
                        ///< boxes MuJoCo 2.2.2 tells half of it
};

/// "panda_link5 and table overlap; box and crate are 4.0 mm apart"; for messages.
[[nodiscard]] std::string Describe(const std::vector<Touch>& touches);

/// Whether the robot, put at a configuration, touches itself or the scene. Works on the model that
/// the plant simulates (meshes or primitive shapes, Franka Hand or none), on data of its own.
///
/// Counted are pairs of shapes of which at least one moves with the arm, by the same rules by which
/// the engine makes contacts in a simulation: its masks, and the pairs of links the model excludes
/// (no more than two joints apart). Free bodies of the scene stand where the scene or Place() puts
/// them.
///
/// Besides, the robot stops itself when parts of its arm come too near to one another by its own
/// reckoning, with capsules a little larger than the links (model::SelfDistance); what its guard
/// would stop is not free either.
///
/// A check runs the engine's kinematics, then its narrow phase on the pairs whose bounds are near,
/// up to the first hit. It is a pure function of configuration, clearance and what was placed,
/// attached and allowed. Joint limits are not its business.
///
/// Threads: one. Not for real-time code. A check allocates nothing.
class CollisionWorld {
 public:
  /// @param options  of the plant; what of them makes no body counts for nothing.
  /// @throws InputError and EnvironmentError as plant::CompileModel().
  explicit CollisionWorld(const plant::MujocoPlantOptions& options);
  ~CollisionWorld();
  CollisionWorld(const CollisionWorld&) = delete;
  CollisionWorld& operator=(const CollisionWorld&) = delete;

  /// How far the hand is open from now on, between its fingers. At first it is open. Means nothing
  /// without a hand.
  /// @throws InputError when width is not in [0, 0.08] m.
  void SetHandWidth(double width);

  /// How near the robot lets parts of its arm come to one another, m: the figure INT guards
  /// (onboard::MeasuredBounds).
  static constexpr double kSelfGuard = 0.01;
  /// Sets another distance of the robot's guard; none: as if it had no guard. At first kSelfGuard.
  void SetSelfGuard(std::optional<double> distance);

  /// Puts a free body of the scene somewhere.
  /// @param body  one with a free joint. @param X_WB  its pose in the world.
  /// @throws InputError for another body (names those that can be moved), or a pose that is none.
  void Place(const std::string& body, const Transform& X_WB);

  /// Fixes a free body of the scene to the flange: it moves with the arm, and counts as part of it
  /// against the robot and the scene, but not against the fingers. Only one at a time; another one
  /// that was attached stands again where it was placed.
  /// @param F_T_B  pose of the body in the flange frame.
  /// @throws InputError as Place().
  void Attach(const std::string& body, const Transform& F_T_B);

  /// Takes the attached body away from the flange; it stands where it was placed. Nothing happens
  /// when there is none.
  void Detach();

  /// From now on these two parts may touch and overlap: "box" and "table" as long as the box stands
  /// on it. @throws InputError for an unknown part (names those there are).
  void Allow(const std::string& a, const std::string& b);
  /// Takes all Allow() back.
  void ForbidAll();

  /// @param q  rad, any finite values. @param clearance  m, >= 0: closer than this counts as
  /// touching.
  /// @returns whether nothing touches. One check.
  [[nodiscard]] bool IsFree(const JointVector& q, double clearance = 0);

  /// @returns all parts that touch, the deepest first; none when IsFree(). One check; allocates.
  [[nodiscard]] std::vector<Touch> Touches(const JointVector& q, double clearance = 0);

  /// Checks since construction.
  [[nodiscard]] std::uint64_t checks() const noexcept;

  /// How far any point of the robot and of what it holds moves at most on the straight way between
  /// two configurations, m:  sum_i r_i abs(a_i - b_i),  r_i the largest distance from axis i of
  /// what lies beyond it. So if a and b are free with a clearance of half of this, the whole way
  /// between them is free.
  [[nodiscard]] double Travel(const JointVector& a, const JointVector& b) const noexcept;
  /// r_i, m.
  [[nodiscard]] const JointVector& reach() const noexcept;

  /// @returns pose of a body in the world at the last check. @throws InputError for an unknown one.
  [[nodiscard]] Transform PoseOf(const std::string& body) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace twin::planning
