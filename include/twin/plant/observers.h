#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/plant/plant.h"
#include "twin/plant/truth_probe.h"
#include "twin/record/scene_record.h"

namespace twin::plant {

/// Pose of a body of the plant: ground truth, for observers.
///
/// Threads: the plant's. Real-time: Pose() is noexcept, O(1), allocates nothing.
class BodyView {
 public:
  /// @param truth  must outlive the view. @throws InputError if no body has that name.
  BodyView(const TruthProbe& truth, const std::string& body);

  /// Pose of the body's frame in the world after the last step.
  [[nodiscard]] Transform Pose() const noexcept TWIN_REALTIME;
  /// Its twist [v; w] in world axes, v of its frame's origin.
  [[nodiscard]] Vector6 Twist() const noexcept TWIN_REALTIME;

 private:
  const TruthProbe& truth_;
  int body_ = 0;
};

/// What the arm with its hand exerts on everything else by contact: ground truth, for observers.
///
/// Threads: the plant's. Real-time: Wrench() is noexcept, O(contacts), allocates nothing.
class ContactWrench {
 public:
  /// @param truth  must outlive the object.
  explicit ContactWrench(const TruthProbe& truth);

  /// The sum of the contact forces of the last step, and their moment about a point, world axes.
  /// Positive: the arm pushes on its surroundings, as O_F_ext_hat_K of the robot's state.
  [[nodiscard]] Vector6 About(const Vector3& p_W) const noexcept TWIN_REALTIME;

 private:
  const TruthProbe& truth_;
  std::vector<bool> moves_;  ///< by geom: moves with the arm
};

/// Names and poses in the world (X_WB) of the scene's free bodies: all that are not part of the
/// robot. A body without a name is called "body N", as in planning::CollisionWorld.
/// @param qpos  of the model, as a SceneRecord holds it. Threads: any. Not real-time.
[[nodiscard]] std::vector<std::pair<std::string, Transform>> FreeBodies(
    const mjModel_& model, std::span<const double> qpos);
/// As they are after the last step; of several arms that share a model too. Threads: the plant's.
[[nodiscard]] std::vector<std::pair<std::string, Transform>> FreeBodies(const TruthProbe& truth);

/// Generalised positions after the last step. Threads: the plant's.
[[nodiscard]] std::span<const double> PositionsOf(const TruthProbe& truth);

/// @returns the body of that name, for MujocoPlant::SetMass(). @throws InputError if there is none.
/// Threads: any. Not real-time.
[[nodiscard]] int BodyNamed(const mjModel_& model, const std::string& name);

/// @returns the free body of that name, for Plant::Place().
/// @throws InputError if there is none, or if it does not move freely, with the names of those that
/// do. Threads: any. Not real-time.
[[nodiscard]] int FreeBodyNamed(const mjModel_& model, const std::string& name);

/// Name of the body that a shape belongs to, or of a shape that is fixed to the world, as in
/// ContactPair. Threads: any. Not real-time.
[[nodiscard]] std::string PartOfShape(const mjModel_& model, int geom);

/// Why Plant::Place() refused to put `body` somewhere, for users.
[[nodiscard]] std::string DescribeOverlap(const mjModel_& model, const std::string& body,
                                          const Overlap& overlap);
/// The deepest overlap of a part that moves with the arm.
struct ArmOverlap {
  std::string part;
  std::string other;
  double depth = 0;  ///< m
};

/// With the arm at `q` (rad) and all else as the model begins; nullopt: it touches nothing, or
/// stands on a mobile base, whose start the model does not have. Threads: any. Not real-time.
[[nodiscard]] std::optional<ArmOverlap> ArmOverlapAt(const mjModel_& model, const JointVector& q);
/// @throws InputError if it is deeper than Plant::kMostOverlap. @param what  is the cause, for it.
void RequireShallow(const std::optional<ArmOverlap>& overlap, std::string_view what);
/// The same of a robot where it has been put to start; not of one of a cell, whose others may not
/// have been (run::RequireApartAtStart). Threads: the plant's. @throws InputError likewise.
void RequireFreeStart(const TruthProbe& truth);

/// Captures poses and forces: contacts with a force, in the engine's order, and pushes on bodies,
/// each as one force on the line that gives its moment about the body's centre of mass (a pure
/// torque is omitted).
///
/// Threads: the plant's. Real-time: noexcept, O(contacts + bodies), allocates nothing.
/// @pre truth.qpos_size() <= record::SceneRecord::kMostPositions.
void CaptureScene(Time now, const TruthProbe& truth,
                  record::SceneRecord& scene) noexcept TWIN_REALTIME;

}  // namespace twin::plant
