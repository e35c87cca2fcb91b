#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/mobile_base.h"
#include "twin/model/lab_limits.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::planning {

/// Name of the arm in a Touch with itself by the measure of the robot's own guard.
inline constexpr std::string_view kGuardedArm = "the arm";
inline constexpr std::string_view kGuardedArmItself = "itself (by the robot's own guard)";

/// Two parts that touch, or are closer than requested. A part is a body of the model
/// ("panda_link5", "panda_hand", "box") or a single shape fixed to the world ("table"). The names
/// live as long as the world. Of a limit: a is the part, b the limit's name.
struct Touch {
  std::string_view a;   ///< of the robot or a held object; kGuardedArm
  std::string_view b;   ///< of the robot, a held object, or the scene
  double distance = 0;  ///< m; negative if they overlap, but not the penetration depth: between two
                        ///< boxes MuJoCo 2.2.2 gives half of it
  bool is_limit = false;  ///< b is a region of SetLimits(), distance the margin
};

/// The least distance between two shapes, one of the arm and one fixed to the world or to the base.
struct Clearance {
  double distance = 0;     ///< m; as Touch::distance
  JointVector gradient{};  ///< of the distance by the joints, m/rad
};

/// "panda_link5 and table overlap; box and crate are 4.0 mm apart"; for messages.
[[nodiscard]] std::string Describe(const std::vector<Touch>& touches);

/// Checks whether the robot at a configuration touches itself or the scene. Uses the model that the
/// plant simulates (meshes or primitive shapes, with or without Franka Hand) with its own data.
///
/// Checks pairs of shapes of which at least one moves with the arm, by the engine's contact rules:
/// its masks, and the pairs of links that the model excludes (at most two joints apart). Free
/// bodies are where the scene or Place() puts them.
///
/// The robot also stops itself when parts of its arm come too close by its own measure, with
/// capsules a little larger than the links (model::SelfDistance). A configuration that this guard
/// would stop is not free either.
///
/// A check runs the engine's kinematics, then its narrow phase on pairs with close bounds, up to
/// the first hit. It is a pure function of the configuration, the clearance and the placed,
/// attached and allowed bodies. Joint limits are not checked.
///
/// Threads: one. Not for real-time code. A check does not allocate.
class CollisionWorld {
 public:
  /// @param options  of the plant; options without effect on bodies are ignored.
  /// @throws InputError and EnvironmentError as plant::CompileModel().
  explicit CollisionWorld(const plant::MujocoPlantOptions& options);
  /// One arm among others, which are obstacles that do not move by themselves. Their parts have
  /// their prefixes in front: "left/panda_hand". Until PlaceArm() they stand with zero joints.
  /// @param arms  as plant::SharedModel::Create's, or one alone. @param own  index of the arm that
  /// moves.
  CollisionWorld(std::span<const plant::MujocoPlantOptions> arms, std::size_t own);
  ~CollisionWorld();
  CollisionWorld(const CollisionWorld&) = delete;
  CollisionWorld& operator=(const CollisionWorld&) = delete;

  /// Sets the opening between the fingers; initially fully open. No effect without a hand.
  /// @throws InputError if width is not in [0, 0.08] m.
  void SetHandWidth(double width);

  /// Distance between parts of the arm at which the robot stops itself, m: INT's value
  /// (onboard::MeasuredBounds).
  static constexpr double kSelfGuard = 0.01;
  /// Sets the distance of the robot's guard; nullopt: no guard. Initially kSelfGuard.
  void SetSelfGuard(std::optional<double> distance);

  /// Sets regions that parts of the robot must not leave or enter: a configuration with a margin
  /// below the clearance is not free. Caps on speed bound the plans (Planner). Initially none.
  void SetLimits(const model::LabLimits& limits, const model::LimitedArm& arm);
  [[nodiscard]] const model::LabLimits& limits() const noexcept;
  [[nodiscard]] const model::LimitedArm& limited_arm() const noexcept;

  /// Places a free body of the scene.
  /// @param body  one with a free joint. @param X_WB  its pose in the world.
  /// @throws InputError listing the movable bodies for another body, and for a pose that is not
  /// rigid.
  void Place(const std::string& body, const Transform& X_WB);

  /// Puts another arm somewhere. @param arm  its index among those of the constructor, not the own
  /// one's. @param q  rad. @param width  between its fingers, m; no effect without a hand.
  /// @throws InputError if width is not in [0, 0.08] m.
  void PlaceArm(std::size_t arm, const JointVector& q, double width);

  /// Puts the other arms and the free bodies where they are in a model of the same arms and scene.
  /// @param qpos  of `model`, as a SceneRecord of all arms holds it.
  void ArrangeAs(const mjModel_& model, std::span<const double> qpos);

  /// Attaches a free body of the scene to the flange. It moves with the arm and is checked against
  /// the robot and the scene, but not against the fingers. Only one body at a time; one attached
  /// before returns to its place.
  /// @param F_T_B  pose of the body in the flange frame.
  /// @throws InputError as Place().
  void Attach(const std::string& body, const Transform& F_T_B);

  /// Detaches the attached body, which returns to its place. No effect without one.
  void Detach();

  /// Permits contact and overlap of two parts: "box" and "table" while the box stands on it.
  /// @throws InputError listing all parts if one is unknown.
  void Allow(const std::string& a, const std::string& b);
  /// Revokes all Allow().
  void ForbidAll();

  /// @param q  rad, any finite values. @param clearance  m, >= 0: closer parts count as touching.
  /// @returns true if no parts touch. Counts as one check.
  [[nodiscard]] bool IsFree(const JointVector& q, double clearance = 0);

  /// @returns all touching parts, the deepest first; empty if IsFree(). Counts as one check;
  /// allocates.
  [[nodiscard]] std::vector<Touch> Touches(const JointVector& q, double clearance = 0);

  /// Moves a mobile base. No effect without one.
  /// @param from_start  pose relative to where the scene puts it.
  void MoveBase(const BasePose& from_start) noexcept;

  static constexpr std::size_t kMostNear = 32;
  /// Finds shapes that are close to the arm and fixed to the world or to a mobile base. Gradients
  /// are those of MuJoCo's distance, by differences below 0.06 m and by contact normals above.
  /// Beside boxes, MuJoCo 2.2.2 may give half of the distance.
  /// @param q  rad. @param horizon  m, >= 0. @param near  receives one entry per pair of shapes
  /// closer than `horizon`: the closest ones, as many as it takes, at most kMostNear, in no
  /// particular order.
  /// @returns the number of entries. Counts as one check.
  [[nodiscard]] std::size_t NearFixed(const JointVector& q, double horizon,
                                      std::span<Clearance> near) noexcept;

  /// Number of checks since construction.
  [[nodiscard]] std::uint64_t checks() const noexcept;

  /// Upper bound of the displacement of any point of the robot and a held object on the straight
  /// line between two configurations, m:  sum_i r_i abs(a_i - b_i),  r_i the largest distance from
  /// axis i of the bodies beyond it. If a and b are free with a clearance of half this bound, the
  /// whole line between them is free.
  [[nodiscard]] double Travel(const JointVector& a, const JointVector& b) const noexcept;
  /// r_i, m.
  [[nodiscard]] const JointVector& reach() const noexcept;

  /// @returns pose of a body in the world at the last check. @throws InputError if it is unknown.
  [[nodiscard]] Transform PoseOf(const std::string& body) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace twin::planning
