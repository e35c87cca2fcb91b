#include "twin/plant/mujoco_plant.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "plant/base_joints.h"
#include "plant/brakes.h"
#include "plant/hand_joints.h"
#include "plant/joint_parameters.h"
#include "plant/model_builder.h"
#include "plant/model_sources.h"
#include "plant/perturber.h"
#include "plant/torque_delay.h"
#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/plant/engine.h"

namespace twin::plant {
namespace {

/// Indices of the arm's joints in the engine's vectors, and their torque limits.
struct ArmJoints {
  std::array<int, kJoints> qpos{};
  std::array<int, kJoints> dof{};
  JointVector tau_max{};  ///< Nm
};

ArmJoints FindJoints(const mjModel& model, const RobotDescription& robot) {
  ArmJoints found;
  std::size_t i = 0;
  for (const Link& link : robot.links) {
    if (link.joint_kind != JointKind::kRevolute) continue;
    const int joint = mj_name2id(&model, mjOBJ_JOINT, link.joint.c_str());
    found.qpos[i] = model.jnt_qposadr[joint];
    found.dof[i] = model.jnt_dofadr[joint];
    found.tau_max[i] = link.tau_max;
    ++i;
  }
  return found;
}

/// Tilts gravity instead of the base: g_O = R^T g_W. Level: unchanged.
void TiltGravity(const BaseTilt& tilt, mjModel& model) {
  if (tilt == BaseTilt()) return;
  const double g = -model.opt.gravity[2];
  model.opt.gravity[0] = g * std::sin(tilt.pitch);
  model.opt.gravity[1] = -g * std::cos(tilt.pitch) * std::sin(tilt.roll);
  model.opt.gravity[2] = -g * std::cos(tilt.pitch) * std::cos(tilt.roll);
}

class EnginePlant final : public MujocoPlant {
 public:
  EnginePlant(const MujocoPlantOptions& options, const ModelSources& sources, BuiltModel built)
      : friction_(options.friction),
        friction_law_(options.arm.friction_law),
        noise_(options.noise),
        random_(options.seed, RandomStream::kSensorNoise),
        uses_meshes_(sources.uses_meshes),
        model_(std::move(built.model)),
        load_warnings_(std::move(built.warnings)),
        data_(mj_makeData(model_.get())),
        joints_(FindJoints(*model_, sources.robot)),
        elasticity_(options.elasticity),
        stiffness_(options.arm.stiffness),
        live_{.perturber = Perturber(*model_),
              .brakes = Brakes(*model_, joints_.dof, joints_.tau_max),
              .tau_J_late = TorqueDelay(options.arm.torque_delay)} {
    TiltGravity(options.base_tilt, *model_);
    for (const Perturbation& perturbation : options.perturbations)
      live_.perturber.Add(perturbation);
    for (std::size_t i = 0; i < kJoints; ++i) armature_[i] = model_->dof_armature[joints_.dof[i]];
    if (options.hand == HandKind::kFrankaHand) live_.hand.emplace(*model_, sources.robot);
    if (options.base) live_.base.emplace(*model_, sources.robot);
  }

  void Reset(const JointVector& q) override;
  /// As in BaseJoints, for the state after Reset().
  void RequireStanding(const BasePose& start) const {
    live_.base->RequireStanding(start, *model_, *data_);
  }
  void Step(const JointDrive& drive) noexcept TWIN_REALTIME override;
  void BeginMotion() noexcept TWIN_REALTIME override { live_.perturber.BeginMotion(plant_time()); }
  std::optional<Overlap> Place(int body, const Transform& X_WB) noexcept TWIN_REALTIME override;
  [[nodiscard]] std::unique_ptr<const State> Save() const override;
  void Restore(const State& state) override;
  [[nodiscard]] const JointSensors& sensors() const noexcept override { return live_.sensors; }
  [[nodiscard]] HandBody* hand() noexcept override { return live_.hand ? &*live_.hand : nullptr; }
  [[nodiscard]] BaseBody* base() noexcept override { return live_.base ? &*live_.base : nullptr; }

  [[nodiscard]] const mjModel& model() const noexcept override { return *model_; }
  [[nodiscard]] const mjData& data() const noexcept override { return *data_; }
  [[nodiscard]] std::size_t qpos_size() const noexcept override {
    return static_cast<std::size_t>(model_->nq);
  }
  void CopyQpos(std::span<double> out) const noexcept override {
    std::copy_n(data_->qpos, out.size(), out.begin());
  }

  [[nodiscard]] bool uses_meshes() const noexcept override { return uses_meshes_; }
  [[nodiscard]] JointVector GravityTorque(const JointVector& q) override;
  void Perturb(const Perturbation& perturbation) override { live_.perturber.Add(perturbation); }
  void ClearPerturbations() override { live_.perturber.Clear(*data_); }
  void SetMass(int body, double mass) override;
  void SetFriction(int body, double friction) override;
  void Reseed(std::uint64_t seed) noexcept TWIN_REALTIME override {
    random_ = Random(seed, RandomStream::kSensorNoise);
  }
  [[nodiscard]] Duration plant_time() const noexcept override {
    return static_cast<std::int64_t>(live_.tick) * kCycle;
  }
  [[nodiscard]] std::uint64_t warning_count() const noexcept override {
    return load_warnings_.size() + step_warnings_;
  }
  [[nodiscard]] std::string DescribeWarnings() const override;

 private:
  /// All that changes beside the engine's data and the friction of closed brakes.
  struct Live {
    Perturber perturber;
    Brakes brakes;
    std::optional<HandJoints> hand{};
    std::optional<BaseJoints> base{};
    JointVector tau_J{};  ///< of the last step, without noise
    TorqueDelay tau_J_late;
    JointSensors sensors{};
    std::uint64_t tick = 0;  ///< steps since the last Reset(); key of the noise
    bool halted = false;
  };
  /// Hand and base stay where they are in memory when a Live is assigned: others refer to them.
  struct Saved final : State {
    Saved(const Live& saved, DataPointer copy, std::vector<mjtNum> friction)
        : live(saved), data(std::move(copy)), dof_frictionloss(std::move(friction)) {}
    Live live;
    DataPointer data;
    std::vector<mjtNum> dof_frictionloss;
  };

  /// Positions (7) and velocities (6) of a free joint.
  struct FreeMotion {
    std::array<mjtNum, 7> qpos{};
    std::array<mjtNum, 6> qvel{};
  };
  /// Sets the motion of a free joint, and computes from it. @returns the one before.
  FreeMotion Swap(int joint, const FreeMotion& motion) TWIN_REALTIME;
  /// The deepest contact of a body.
  [[nodiscard]] Overlap DeepestOf(int body) const noexcept TWIN_REALTIME;
  /// After an error of the engine.
  void Halt() noexcept TWIN_REALTIME;

  [[nodiscard]] JointVector FrictionAt(const JointVector& dq) const noexcept TWIN_REALTIME;
  /// Reads the joints into sensors and adds this tick's noise.
  void Sense(const JointVector& tau_J) noexcept TWIN_REALTIME;
  /// Collects the engine's warnings. @returns false for one that invalidates the motion.
  bool TakeWarnings() noexcept TWIN_REALTIME;

  const FrictionProfile friction_;
  const std::optional<FrictionLaw> friction_law_;
  const SensorNoise noise_;
  Random random_;
  const bool uses_meshes_;
  ModelPointer model_;
  std::vector<std::string> load_warnings_;
  DataPointer data_;
  /// For computations beside the motion; created on first use.
  [[nodiscard]] mjData& SideData();
  DataPointer side_data_;
  const ArmJoints joints_;
  JointVector armature_{};
  const ElasticityProfile elasticity_;
  const JointVector stiffness_;
  Live live_;
  // Counts since Create(), which no Restore() takes back.
  std::array<std::uint64_t, mjNWARNING> warnings_{};
  std::uint64_t faults_ = 0;  ///< steps with an engine fault
  std::uint64_t step_warnings_ = 0;
};

void EnginePlant::Reset(const JointVector& q) {
  mj_resetData(model_.get(), data_.get());
  for (std::size_t i = 0; i < kJoints; ++i) data_->qpos[joints_.qpos[i]] = q[i];
  if (live_.hand) live_.hand->Reset(*data_);
  live_.perturber.Restart();
  live_.brakes.Reset(*model_);
  live_.tick = 0;
  live_.halted = false;
  try {
    if (live_.base) live_.base->Settle(*model_, *data_);
    mj_forward(model_.get(), data_.get());
  } catch (const EngineFault&) {
    Halt();
  }
  live_.halted = !TakeWarnings() || live_.halted;
  // At rest the brakes or the controller carry the arm's weight, which the torque sensors show.
  JointVector tau_J{};
  for (std::size_t i = 0; i < kJoints; ++i) tau_J[i] = data_->qfrc_bias[joints_.dof[i]];
  live_.tau_J = tau_J;
  live_.tau_J_late.Fill(tau_J);
  Sense(tau_J);
  if (live_.base) live_.base->Sense(*data_);
}

JointVector EnginePlant::FrictionAt(const JointVector& dq) const noexcept {
  if (friction_law_) return Friction(*friction_law_, dq);
  return friction_ == FrictionProfile::kResidual ? ResidualFriction(dq) : JointVector{};
}

void EnginePlant::Step(const JointDrive& drive) noexcept {
  if (live_.halted) {
    ++step_warnings_;
    return;
  }
  JointVector dq{};
  for (std::size_t i = 0; i < kJoints; ++i) dq[i] = data_->qvel[joints_.dof[i]];
  const JointVector friction = FrictionAt(dq);
  live_.perturber.Apply(plant_time(), *data_);
  if (live_.hand) live_.hand->Apply(*data_);
  if (live_.base) live_.base->Apply(*model_, *data_);
  JointVector tau_J{};
  try {
    live_.brakes.Set(drive.brakes, *model_, *data_);
    for (std::size_t i = 0; i < kJoints; ++i) {
      data_->qfrc_applied[joints_.dof[i]] = drive.tau[i] + live_.brakes.carried()[i] - friction[i];
    }
    // This order of the halves leaves poses and contacts of the new state in data().
    mj_step2(model_.get(), data_.get());
    const JointVector tau_brake = live_.brakes.Take(*data_);
    if (live_.base) live_.base->Take(*model_, *data_);
    for (std::size_t i = 0; i < kJoints; ++i) {
      tau_J[i] = drive.tau[i] + tau_brake[i] - armature_[i] * data_->qacc[joints_.dof[i]];
    }
    mj_step1(model_.get(), data_.get());
  } catch (const EngineFault&) {
    Halt();
  }
  live_.halted = !TakeWarnings() || live_.halted;
  if (live_.halted) {
    // No measurement from here on.
    constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
    for (JointVector* values : {&live_.sensors.q, &live_.sensors.dq, &live_.sensors.tau_J,
                                &live_.sensors.theta, &live_.sensors.dtheta}) {
      values->fill(kNothing);
    }
    return;
  }
  ++live_.tick;
  Sense(tau_J);
  if (live_.hand) live_.hand->Sense(*data_);
  if (live_.base) live_.base->Sense(*data_);
}

void EnginePlant::Halt() noexcept {
  ++faults_;
  ++step_warnings_;
  live_.halted = true;
}

EnginePlant::FreeMotion EnginePlant::Swap(int joint, const FreeMotion& motion) {
  mjtNum* const qpos = data_->qpos + model_->jnt_qposadr[joint];
  mjtNum* const qvel = data_->qvel + model_->jnt_dofadr[joint];
  FreeMotion before;
  std::copy_n(qpos, before.qpos.size(), before.qpos.begin());
  std::copy_n(qvel, before.qvel.size(), before.qvel.begin());
  std::ranges::copy(motion.qpos, qpos);
  std::ranges::copy(motion.qvel, qvel);
  mj_step1(model_.get(), data_.get());  // as the end of Step()
  return before;
}

Overlap EnginePlant::DeepestOf(int body) const noexcept {
  Overlap deepest;
  for (int i = 0; i < data_->ncon; ++i) {
    const mjContact& contact = data_->contact[i];
    const bool is_first = model_->geom_bodyid[contact.geom1] == body;
    if (!is_first && model_->geom_bodyid[contact.geom2] != body) continue;
    if (-contact.dist <= deepest.depth) continue;
    deepest = {.geom = is_first ? contact.geom2 : contact.geom1, .depth = -contact.dist};
  }
  return deepest;
}

std::optional<Overlap> EnginePlant::Place(int body, const Transform& X_WB) noexcept {
  const int joint = model_->body_jntadr[body];
  FreeMotion motion;
  std::array<mjtNum, 9> rotation{};  // by rows
  for (std::size_t r = 0; r < 3; ++r) {
    motion.qpos[r] = X_WB[12 + r];
    for (std::size_t c = 0; c < 3; ++c) rotation[3 * r + c] = X_WB[4 * c + r];
  }
  mju_mat2Quat(motion.qpos.data() + 3, rotation.data());
  try {
    const FreeMotion before = Swap(joint, motion);
    const Overlap deepest = DeepestOf(body);
    if (deepest.depth > kMostOverlap) {
      Swap(joint, before);
      return deepest;
    }
    std::fill_n(data_->qacc_warmstart + model_->jnt_dofadr[joint], motion.qvel.size(), 0);
  } catch (const EngineFault&) {
    Halt();
  }
  return {};
}

std::unique_ptr<const Plant::State> EnginePlant::Save() const {
  return std::make_unique<Saved>(
      live_, DataPointer(mj_copyData(nullptr, model_.get(), data_.get())),
      std::vector<mjtNum>(model_->dof_frictionloss, model_->dof_frictionloss + model_->nv));
}

void EnginePlant::Restore(const State& state) {
  const auto& saved = static_cast<const Saved&>(state);
  mj_copyData(data_.get(), model_.get(), saved.data.get());
  std::ranges::copy(saved.dof_frictionloss, model_->dof_frictionloss);
  live_ = saved.live;
}

void EnginePlant::Sense(const JointVector& tau_J) noexcept {
  live_.sensors.tau_J = live_.tau_J_late.Pass(tau_J);
  for (std::size_t i = 0; i < kJoints; ++i) {
    live_.sensors.q[i] = data_->qpos[joints_.qpos[i]];
    live_.sensors.dq[i] = data_->qvel[joints_.dof[i]];
  }
  const auto add = [this](double deviation, std::uint32_t first_draw, JointVector& values) {
    if (deviation == 0) return;
    for (std::uint32_t i = 0; i < kJoints; ++i) {
      values[i] += deviation * random_.Normal(live_.tick, first_draw + i);
    }
  };
  add(noise_.q_rad, 0, live_.sensors.q);
  add(noise_.dq_rad_per_s, kJoints, live_.sensors.dq);
  add(noise_.tau_J_Nm, 2 * kJoints, live_.sensors.tau_J);
  live_.sensors.theta = live_.sensors.q;
  live_.sensors.dtheta = live_.sensors.dq;
  if (elasticity_ == ElasticityProfile::kStatic) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      live_.sensors.theta[i] += tau_J[i] / stiffness_[i];
      live_.sensors.dtheta[i] += (tau_J[i] - live_.tau_J[i]) / (kCycleSeconds * stiffness_[i]);
    }
  }
  live_.tau_J = tau_J;
}

bool EnginePlant::TakeWarnings() noexcept {
  for (int i = 0; i < mjNWARNING; ++i) {
    const int number = data_->warning[i].number;
    if (number == 0) continue;
    warnings_[i] += static_cast<std::uint64_t>(number);
    step_warnings_ += static_cast<std::uint64_t>(number);
    data_->warning[i].number = 0;
    // The engine reacts to these by a reset to its initial state.
    if (i == mjWARN_BADQPOS || i == mjWARN_BADQVEL || i == mjWARN_BADQACC) return false;
  }
  return true;
}

std::string EnginePlant::DescribeWarnings() const {
  std::string text;
  for (const std::string& warning : load_warnings_) text += warning + '\n';
  for (int i = 0; i < mjNWARNING; ++i) {
    if (warnings_[i] == 0) continue;
    text += fmt::format("{} (times: {})\n", mju_warningText(i, data_->warning[i].lastinfo),
                        warnings_[i]);
  }
  if (faults_ > 0) text += fmt::format("the engine failed in a step (times: {})\n", faults_);
  if (live_.halted) text += "the arm is halted since: no step is taken until the next Reset\n";
  return text;
}

mjData& EnginePlant::SideData() {
  if (!side_data_) side_data_.reset(mj_makeData(model_.get()));
  return *side_data_;
}

void EnginePlant::SetMass(int body, double mass) {
  RequireInRange("mass of a body, kg", mass, 0.001, 100);
  const double before = model_->body_mass[body];
  if (before <= 0) throw InputError("mass of a body: this body has none that could be changed");
  if (mass == before) return;
  model_->body_mass[body] = mass;
  for (int i = 0; i < 3; ++i) model_->body_inertia[3 * body + i] *= mass / before;
  // What the engine derives from masses.
  mj_resetData(model_.get(), &SideData());
  mj_setConst(model_.get(), &SideData());
}

void EnginePlant::SetFriction(int body, double friction) {
  RequireInRange("friction of a body", friction, 0, 10);
  const int first = model_->body_geomadr[body];
  for (int i = 0; i < model_->body_geomnum[body]; ++i) {
    model_->geom_friction[3 * (first + i)] = friction;
  }
}

JointVector EnginePlant::GravityTorque(const JointVector& q) {
  mjData* data = &SideData();
  for (std::size_t i = 0; i < kJoints; ++i) data->qpos[joints_.qpos[i]] = q[i];
  mj_kinematics(model_.get(), data);
  mj_comPos(model_.get(), data);
  mj_comVel(model_.get(), data);  // of velocity zero
  mj_rne(model_.get(), data, 0, data->qfrc_bias);
  JointVector g{};
  for (std::size_t i = 0; i < kJoints; ++i) g[i] = data->qfrc_bias[joints_.dof[i]];
  return g;
}

}  // namespace

std::unique_ptr<MujocoPlant> MujocoPlant::Create(const MujocoPlantOptions& options) {
  PrepareEngine();
  try {
    const ModelSources sources = ReadModelSources(options);
    auto plant = std::make_unique<EnginePlant>(options, sources, LoadOrBuild(options, sources));
    plant->Reset({0, -0.78539816339744831, 0, -2.3561944901923448, 0, 1.5707963267948966,
                  0.78539816339744831});
    if (options.base) plant->RequireStanding(options.base->start);
    return plant;
  } catch (const EngineFault& fault) {
    throw EnvironmentError(
        fmt::format("the engine failed while it set up the model: {}", fault.what()));
  }
}

}  // namespace twin::plant
