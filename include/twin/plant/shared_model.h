#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/plant/observers.h"

struct mjModel_;

namespace twin::plant {

/// One MuJoCo model of several arms, each of which is a plant of its own.
///
/// All arms take a step together, once the last of them has given its torque. An arm whose plant is
/// gone stays with closed brakes.
///
/// Arms that share a model may touch: contacts between them have forces, as any others. MuJoCo
/// solves the contacts of a model together, so a contact anywhere in it changes the last bits of
/// all its arms; arms that cannot touch get models of their own (Islands()).
///
/// Threads: one thread for the steps of all its plants, which others may make before the first step
/// and destroy after the last; or, without a way to let the others go on, one for each plant, of
/// which Step() waits for the others' steps, and the truth is to be read where no other thread can
/// take a step meanwhile: after Step(), before the next.
class SharedModel {
 public:
  virtual ~SharedModel() = default;

  /// Composes and compiles (or loads from the cache).
  /// @param arms  each with a prefix of its own, none with a mobile base. Scene, objects, meshes,
  /// cache and tilt are those of the first.
  /// @param others  lets the others go on; called, again and again, by an arm that waits for the
  /// step in its plant's Step(). Must not throw. Empty: each plant has a thread of its own.
  /// @throws as MujocoPlant::Create; InputError for a prefix given twice, and for a mobile base.
  [[nodiscard]] static std::shared_ptr<SharedModel> Create(std::span<const MujocoPlantOptions> arms,
                                                           std::function<void()> others);

  /// The plant of an arm, as its options were, once. MujocoPlant::Create calls it.
  /// Its Reset() sets only this arm back, and its Restore() takes all arms back.
  /// @throws InputError if no arm has that prefix, or its plant is taken.
  [[nodiscard]] virtual std::unique_ptr<MujocoPlant> Take(const std::string& prefix) = 0;

  /// The plant of an arm will not be taken: the arm stays with closed brakes, and the others wait
  /// for it no more. No effect once it is taken. Any thread.
  virtual void Forgo(const std::string& prefix) noexcept = 0;

  /// From now on no arm waits, nor moves: as if all stood by. Any thread.
  virtual void Release() noexcept = 0;
};

/// A model of several arms without state, for pictures. Arguments as of SharedModel::Create.
[[nodiscard]] std::shared_ptr<const mjModel_> CompileArms(std::span<const MujocoPlantOptions> arms);

/// The deepest overlap of a part that moves with an arm, with any other part.
/// @param q  by arm, rad; hands are open, all else is as the model begins. @throws as CompileArms.
[[nodiscard]] std::optional<ArmOverlap> ArmsOverlap(std::span<const MujocoPlantOptions> arms,
                                                    std::span<const JointVector> q);

/// Number of joints of a model.
[[nodiscard]] std::size_t JointsOf(const mjModel_& model) noexcept;

/// Generalised positions as a model begins.
[[nodiscard]] std::vector<double> InitialPositions(const mjModel_& model);

/// Where the positions of an arm's own model are among those of a model of several.
/// @param prefix  of this arm in `all`. @returns an index for each position of `one`.
/// @throws InputError for a body of the scene that moves without a name, or by several joints.
[[nodiscard]] std::vector<std::size_t> PlacesOf(const mjModel_& one, const std::string& prefix,
                                                const mjModel_& all);

/// What an arm, its hand included, can reach: a ball. It bounds the arm from above: the links
/// stretched out from joint 2 on.
struct Reach {
  Vector3 p_W{};      ///< its middle, m
  double radius = 0;  ///< m
};

/// @throws as MujocoPlant::Create.
[[nodiscard]] Reach ReachOf(const MujocoPlantOptions& arm);

}  // namespace twin::plant
