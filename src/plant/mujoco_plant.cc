#include "twin/plant/mujoco_plant.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "plant/engine_world.h"
#include "plant/model_builder.h"
#include "plant/model_sources.h"
#include "plant/part_names.h"
#include "twin/core/error.h"
#include "twin/plant/compiled_model.h"
#include "twin/plant/engine.h"
#include "twin/plant/shared_model.h"

namespace twin::plant {
namespace {

/// Where a plant starts until its first Reset(): the robot's pose of readiness, rad.
constexpr JointVector kReady{
    0, -0.78539816339744831, 0, -2.3561944901923448, 0, 1.5707963267948966, 0.78539816339744831};

/// Runs `build`; a fault of the engine becomes an EnvironmentError.
template <typename Build>
auto WithEngine(Build build) {
  PrepareEngine();
  try {
    return build();
  } catch (const EngineFault& fault) {
    throw EnvironmentError(
        fmt::format("the engine failed while it set up the model: {}", fault.what()));
  }
}

/// Number of positions of a joint.
std::size_t PositionsOf(int type) noexcept {
  if (type == mjJNT_FREE) return 7;
  return type == mjJNT_BALL ? 4 : 1;
}

/// All arms of a world, as one of them shows them.
class WholeTruth final : public TruthProbe {
 public:
  WholeTruth(const EngineWorld& world, const TruthProbe& arm) : world_(world), arm_(arm) {}

  [[nodiscard]] const mjModel& model() const noexcept override { return world_.model(); }
  [[nodiscard]] const mjData& data() const noexcept override { return world_.data(); }
  [[nodiscard]] std::size_t qpos_size() const noexcept override {
    return static_cast<std::size_t>(model().nq);
  }
  void CopyQpos(std::span<double> out) const noexcept override {
    std::copy_n(data().qpos, out.size(), out.begin());
  }
  [[nodiscard]] const std::string& prefix() const noexcept override { return arm_.prefix(); }

 private:
  const EngineWorld& world_;
  const TruthProbe& arm_;
};

/// One arm of a world, as a plant.
class EnginePlant final : public MujocoPlant {
 public:
  /// @param arm  in the world.
  EnginePlant(std::shared_ptr<EngineWorld> world, std::size_t arm, std::string prefix,
              bool uses_meshes)
      : world_(std::move(world)),
        arm_(world_->arm(arm)),
        index_(arm),
        prefix_(std::move(prefix)),
        uses_meshes_(uses_meshes) {
    const mjModel& model = world_->model();
    for (int joint = 0; joint < model.njnt; ++joint) {
      const bool is_anothers = [&] {
        for (std::size_t i = 0; i < world_->size(); ++i) {
          if (i != index_ && world_->arm(i).Has(joint)) return true;
        }
        return false;
      }();
      if (is_anothers) continue;
      const int positions = static_cast<int>(PositionsOf(model.jnt_type[joint]));
      for (int k = 0; k < positions; ++k) qpos_.push_back(model.jnt_qposadr[joint] + k);
    }
  }
  ~EnginePlant() override { world_->Leave(index_); }
  EnginePlant(const EnginePlant&) = delete;
  EnginePlant& operator=(const EnginePlant&) = delete;

  void Reset(const JointVector& q) override {
    const auto lock = world_->Lock();
    world_->Reset(index_, q);
  }
  void Step(const JointDrive& drive) noexcept TWIN_REALTIME override {
    arm_.live().drive = drive;
    world_->Meet();
  }
  void BeginMotion() noexcept TWIN_REALTIME override { world_->BeginMotion(index_); }
  void StandBy() noexcept TWIN_REALTIME override { world_->StandBy(index_); }
  [[nodiscard]] bool is_awaited() const noexcept TWIN_REALTIME override {
    return world_->is_awaited();
  }
  std::optional<Overlap> Place(int body, const Transform& X_WB) noexcept TWIN_REALTIME override {
    const auto lock = world_->Lock();
    return world_->Place(body, X_WB);
  }
  [[nodiscard]] std::unique_ptr<const State> Save() const override {
    const auto lock = world_->Lock();
    return world_->Save();
  }
  void Restore(const State& state) override {
    const auto lock = world_->Lock();
    world_->Restore(state);
  }
  [[nodiscard]] const JointSensors& sensors() const noexcept override {
    return arm_.live().sensors;
  }
  [[nodiscard]] HandBody* hand() noexcept override {
    auto& hand = arm_.live().hand;
    return hand ? &*hand : nullptr;
  }
  [[nodiscard]] SuctionBody* suction() noexcept override {
    auto& suction = arm_.live().suction;
    return suction ? &*suction : nullptr;
  }
  [[nodiscard]] BaseBody* base() noexcept override {
    auto& base = arm_.live().base;
    return base ? &*base : nullptr;
  }

  [[nodiscard]] const mjModel& model() const noexcept override { return world_->model(); }
  [[nodiscard]] const mjData& data() const noexcept override { return world_->data(); }
  [[nodiscard]] std::size_t qpos_size() const noexcept override { return qpos_.size(); }
  void CopyQpos(std::span<double> out) const noexcept override {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = world_->data().qpos[qpos_[i]];
  }
  [[nodiscard]] const std::string& prefix() const noexcept override { return prefix_; }
  [[nodiscard]] const TruthProbe& whole() const noexcept override { return whole_; }

  [[nodiscard]] bool uses_meshes() const noexcept override { return uses_meshes_; }
  [[nodiscard]] JointVector GravityTorque(const JointVector& q) override;
  void Perturb(const Perturbation& perturbation) override {
    arm_.live().perturber.Add(perturbation);
  }
  void ClearPerturbations() override { arm_.live().perturber.Clear(world_->data()); }
  void SetMass(int body, double mass) override;
  void SetFriction(int body, double friction) override;
  void Reseed(std::uint64_t seed) noexcept TWIN_REALTIME override { arm_.Reseed(seed); }
  [[nodiscard]] Duration plant_time() const noexcept override { return world_->time(); }
  [[nodiscard]] std::uint64_t warning_count() const noexcept override {
    return world_->warning_count();
  }
  [[nodiscard]] std::string DescribeWarnings() const override { return world_->DescribeWarnings(); }

 private:
  const std::shared_ptr<EngineWorld> world_;
  EngineArm& arm_;
  const std::size_t index_;
  const std::string prefix_;
  const bool uses_meshes_;
  const WholeTruth whole_{*world_, *this};
  std::vector<int> qpos_;  ///< of the model, without the other arms'
};

void EnginePlant::SetMass(int body, double mass) {
  mjModel& model = world_->model();
  RequireInRange("mass of a body, kg", mass, 0.001, 100);
  const double before = model.body_mass[body];
  if (before <= 0) throw InputError("mass of a body: this body has none that could be changed");
  if (mass == before) return;
  model.body_mass[body] = mass;
  for (int i = 0; i < 3; ++i) model.body_inertia[3 * body + i] *= mass / before;
  // What the engine derives from masses.
  mj_resetData(&model, &world_->SideData());
  mj_setConst(&model, &world_->SideData());
}

void EnginePlant::SetFriction(int body, double friction) {
  mjModel& model = world_->model();
  RequireInRange("friction of a body", friction, 0, 10);
  const int first = model.body_geomadr[body];
  for (int i = 0; i < model.body_geomnum[body]; ++i) {
    model.geom_friction[3 * (first + i)] = friction;
  }
}

JointVector EnginePlant::GravityTorque(const JointVector& q) {
  const mjModel& model = world_->model();
  mjData* data = &world_->SideData();
  arm_.SetJoints(q, *data);
  mj_kinematics(&model, data);
  mj_comPos(&model, data);
  mj_comVel(&model, data);  // of velocity zero
  mj_rne(&model, data, 0, data->qfrc_bias);
  return arm_.BiasIn(*data);
}

class EngineArms final : public SharedModel {
 public:
  EngineArms(std::span<const MujocoPlantOptions> arms, const ModelSources& sources,
             std::function<void()> others)
      : world_(std::make_shared<EngineWorld>(arms, sources, LoadOrBuild(arms.front(), sources),
                                             std::move(others))),
        uses_meshes_(sources.uses_meshes) {
    for (const MujocoPlantOptions& arm : arms) free_.push_back(arm.prefix);
    for (std::size_t i = 0; i < arms.size(); ++i) world_->Reset(i, kReady);
  }

  [[nodiscard]] std::unique_ptr<MujocoPlant> Take(const std::string& prefix) override {
    if (const auto i = FindFree(prefix)) {
      return std::make_unique<EnginePlant>(world_, *i, prefix, uses_meshes_);
    }
    throw InputError(fmt::format("the shared model has no free arm \"{}\"", prefix));
  }
  void Forgo(const std::string& prefix) noexcept override {
    if (const auto i = FindFree(prefix)) world_->Leave(*i);
  }
  void Release() noexcept override {
    for (std::size_t i = 0; i < world_->size(); ++i) world_->StandBy(i);
  }

 private:
  /// The index of a free arm, which is so no longer; nullopt: there is none of that prefix.
  std::optional<std::size_t> FindFree(const std::string& prefix) noexcept {
    const std::lock_guard lock(mutex_);
    const auto found = std::ranges::find(free_, prefix);
    if (found == free_.end()) return std::nullopt;
    found->reset();
    return static_cast<std::size_t>(found - free_.begin());
  }

  std::shared_ptr<EngineWorld> world_;
  const bool uses_meshes_;
  std::mutex mutex_;
  std::vector<std::optional<std::string>> free_;  ///< prefixes of arms that are not taken
};

void RequireApart(std::span<const MujocoPlantOptions> arms) {
  std::set<std::string> prefixes;
  for (const MujocoPlantOptions& arm : arms) {
    if (arm.base) throw InputError("a mobile base carries an arm that is alone in its model");
    if (prefixes.insert(arm.prefix).second) continue;
    throw InputError(fmt::format("two arms of a model have the prefix \"{}\"", arm.prefix));
  }
}

}  // namespace

Transform ArmPose::Matrix() const noexcept {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return {c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, position[0], position[1], position[2], 1};
}

std::unique_ptr<MujocoPlant> MujocoPlant::Create(const MujocoPlantOptions& options) {
  if (options.shared) return options.shared->Take(options.prefix);
  return WithEngine([&] {
    const ModelSources sources = ReadModelSources({&options, 1});
    auto world = std::make_shared<EngineWorld>(std::span(&options, 1), sources,
                                               LoadOrBuild(options, sources), nullptr);
    world->Reset(0, kReady);
    if (options.base) world->RequireStanding(options.base->start);
    return std::make_unique<EnginePlant>(std::move(world), 0, options.prefix, sources.uses_meshes);
  });
}

std::shared_ptr<SharedModel> SharedModel::Create(std::span<const MujocoPlantOptions> arms,
                                                 std::function<void()> others) {
  RequireApart(arms);
  return WithEngine([&] {
    return std::make_shared<EngineArms>(arms, ReadModelSources(arms), std::move(others));
  });
}

std::shared_ptr<const mjModel> CompileArms(std::span<const MujocoPlantOptions> arms) {
  RequireApart(arms);
  return WithEngine([&]() -> std::shared_ptr<const mjModel> {
    return LoadOrBuild(arms.front(), ReadModelSources(arms)).model;
  });
}

std::optional<ArmOverlap> ArmsOverlap(std::span<const MujocoPlantOptions> arms,
                                      std::span<const JointVector> q) {
  RequireApart(arms);
  return WithEngine([&]() -> std::optional<ArmOverlap> {
    const ModelSources sources = ReadModelSources(arms);
    EngineWorld world(arms, sources, LoadOrBuild(arms.front(), sources), {});
    for (std::size_t i = 0; i < arms.size(); ++i) world.Reset(i, q[i]);
    std::vector<bool> moves(static_cast<std::size_t>(world.model().nbody));
    for (const MujocoPlantOptions& arm : arms) {
      const std::vector<bool> with_it = MovingBodies(world.model(), arm.prefix);
      for (std::size_t i = 0; i < moves.size(); ++i) moves[i] = moves[i] || with_it[i];
    }
    return DeepestOverlap(world.model(), world.data(), moves);
  });
}

std::size_t JointsOf(const mjModel& model) noexcept {
  return static_cast<std::size_t>(model.njnt);
}

std::vector<double> InitialPositions(const mjModel& model) {
  return {model.qpos0, model.qpos0 + model.nq};
}

std::vector<std::size_t> PlacesOf(const mjModel& one, const std::string& prefix,
                                  const mjModel& all) {
  std::vector<std::size_t> places(static_cast<std::size_t>(one.nq));
  for (int joint = 0; joint < one.njnt; ++joint) {
    // A joint is known by its body, which has no other.
    const char* const known = mj_id2name(&one, mjOBJ_BODY, one.jnt_bodyid[joint]);
    const std::string name = known == nullptr ? "" : known;
    int body = mj_name2id(&all, mjOBJ_BODY, (prefix + name).c_str());
    if (body < 0) body = mj_name2id(&all, mjOBJ_BODY, name.c_str());
    if (body < 0 || all.body_jntnum[body] != 1) {
      throw InputError(fmt::format(
          "the scene has a body \"{}\" that moves and that cannot be drawn beside several robots; "
          "give it a name, and one joint",
          name));
    }
    const auto from = static_cast<std::size_t>(one.jnt_qposadr[joint]);
    const auto to = static_cast<std::size_t>(all.jnt_qposadr[all.body_jntadr[body]]);
    const std::size_t positions = PositionsOf(one.jnt_type[joint]);
    for (std::size_t k = 0; k < positions; ++k) places[from + k] = to + k;
  }
  return places;
}

Reach ReachOf(const MujocoPlantOptions& arm) {
  const CompiledModel compiled = CompileModel(arm);
  const mjModel& model = *compiled.model;
  const DataPointer data(mj_makeData(&model));
  mj_kinematics(&model, data.get());
  const int middle = model.jnt_bodyid[compiled.arm[1]];
  Reach reach;
  std::copy_n(data->xpos + std::ptrdiff_t{3} * middle, 3, reach.p_W.begin());
  // From joint 2 to the origin of each link behind it, all links in line.
  std::vector<double> far(static_cast<std::size_t>(model.nbody), -1);
  far[static_cast<std::size_t>(middle)] = 0;
  for (int body = middle; body < model.nbody; ++body) {
    const auto at = static_cast<std::size_t>(body);
    const double before = far[static_cast<std::size_t>(model.body_parentid[body])];
    if (body != middle) {
      if (before < 0) continue;
      far[at] = before + mju_norm3(model.body_pos + std::ptrdiff_t{3} * body);
      if (std::ranges::find(compiled.fingers, model.body_jntadr[body]) != compiled.fingers.end()) {
        far[at] += compiled.open;
      }
    }
    for (int k = 0; k < model.body_geomnum[body]; ++k) {
      const int geom = model.body_geomadr[body] + k;
      if (model.geom_contype[geom] == 0 && model.geom_conaffinity[geom] == 0) continue;
      reach.radius =
          std::max(reach.radius, far[at] + mju_norm3(model.geom_pos + std::ptrdiff_t{3} * geom) +
                                     model.geom_rbound[geom]);
    }
  }
  return reach;
}

}  // namespace twin::plant
