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
        noise_(options.noise),
        random_(options.seed, RandomStream::kSensorNoise),
        uses_meshes_(sources.uses_meshes),
        model_(std::move(built.model)),
        load_warnings_(std::move(built.warnings)),
        data_(mj_makeData(model_.get())),
        perturber_(*model_),
        joints_(FindJoints(*model_, sources.robot)),
        brakes_(*model_, joints_.dof, joints_.tau_max),
        elasticity_(options.elasticity) {
    TiltGravity(options.base_tilt, *model_);
    for (const Perturbation& perturbation : options.perturbations) perturber_.Add(perturbation);
    for (std::size_t i = 0; i < kJoints; ++i) armature_[i] = model_->dof_armature[joints_.dof[i]];
    if (options.hand == HandKind::kFrankaHand) hand_.emplace(*model_, sources.robot);
    if (options.base) base_.emplace(*model_, sources.robot);
  }

  void Reset(const JointVector& q) override;
  /// As in BaseJoints, for the state after Reset().
  void RequireStanding(const BasePose& start) const {
    base_->RequireStanding(start, *model_, *data_);
  }
  void Step(const JointDrive& drive) noexcept TWIN_REALTIME override;
  void BeginMotion() noexcept TWIN_REALTIME override { perturber_.BeginMotion(plant_time()); }
  [[nodiscard]] const JointSensors& sensors() const noexcept override { return sensors_; }
  [[nodiscard]] HandBody* hand() noexcept override { return hand_ ? &*hand_ : nullptr; }
  [[nodiscard]] BaseBody* base() noexcept override { return base_ ? &*base_ : nullptr; }

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
  void Perturb(const Perturbation& perturbation) override { perturber_.Add(perturbation); }
  void ClearPerturbations() override { perturber_.Clear(*data_); }
  [[nodiscard]] Duration plant_time() const noexcept override {
    return static_cast<std::int64_t>(tick_) * kCycle;
  }
  [[nodiscard]] std::uint64_t warning_count() const noexcept override {
    return load_warnings_.size() + step_warnings_;
  }
  [[nodiscard]] std::string DescribeWarnings() const override;

 private:
  /// Reads the joints into sensors_ and adds this tick's noise.
  void Sense(const JointVector& tau_J) noexcept TWIN_REALTIME;
  /// Collects the engine's warnings. @returns false for one that invalidates the motion.
  bool TakeWarnings() noexcept TWIN_REALTIME;

  const FrictionProfile friction_;
  const SensorNoise noise_;
  const Random random_;
  const bool uses_meshes_;
  ModelPointer model_;
  std::vector<std::string> load_warnings_;
  DataPointer data_;
  Perturber perturber_;
  DataPointer gravity_data_;  ///< created on first use
  const ArmJoints joints_;
  Brakes brakes_;
  std::optional<HandJoints> hand_;
  std::optional<BaseJoints> base_;
  JointVector armature_{};
  const ElasticityProfile elasticity_;
  JointVector tau_J_{};  ///< of the last step, without noise
  JointSensors sensors_;
  std::uint64_t tick_ = 0;  ///< steps since the last Reset(); key of the noise
  std::array<std::uint64_t, mjNWARNING> warnings_{};
  std::uint64_t faults_ = 0;  ///< steps with an engine fault
  std::uint64_t step_warnings_ = 0;
  bool halted_ = false;
};

void EnginePlant::Reset(const JointVector& q) {
  mj_resetData(model_.get(), data_.get());
  for (std::size_t i = 0; i < kJoints; ++i) data_->qpos[joints_.qpos[i]] = q[i];
  if (hand_) hand_->Reset(*data_);
  perturber_.Restart();
  brakes_.Reset(*model_);
  tick_ = 0;
  halted_ = false;
  try {
    if (base_) base_->Settle(*model_, *data_);
    mj_forward(model_.get(), data_.get());
  } catch (const EngineFault&) {
    ++faults_;
    ++step_warnings_;
    halted_ = true;
  }
  halted_ = !TakeWarnings() || halted_;
  // At rest the brakes or the controller carry the arm's weight, which the torque sensors show.
  JointVector tau_J{};
  for (std::size_t i = 0; i < kJoints; ++i) tau_J[i] = data_->qfrc_bias[joints_.dof[i]];
  tau_J_ = tau_J;
  Sense(tau_J);
  if (base_) base_->Sense(*data_);
}

void EnginePlant::Step(const JointDrive& drive) noexcept {
  if (halted_) {
    ++step_warnings_;
    return;
  }
  JointVector dq{};
  for (std::size_t i = 0; i < kJoints; ++i) dq[i] = data_->qvel[joints_.dof[i]];
  const JointVector friction =
      friction_ == FrictionProfile::kResidual ? ResidualFriction(dq) : JointVector{};
  perturber_.Apply(plant_time(), *data_);
  if (hand_) hand_->Apply(*data_);
  if (base_) base_->Apply(*model_, *data_);
  JointVector tau_J{};
  try {
    brakes_.Set(drive.brakes, *model_, *data_);
    for (std::size_t i = 0; i < kJoints; ++i) {
      data_->qfrc_applied[joints_.dof[i]] = drive.tau[i] + brakes_.carried()[i] - friction[i];
    }
    // This order of the halves leaves poses and contacts of the new state in data().
    mj_step2(model_.get(), data_.get());
    const JointVector tau_brake = brakes_.Take(*data_);
    if (base_) base_->Take(*model_, *data_);
    for (std::size_t i = 0; i < kJoints; ++i) {
      tau_J[i] = drive.tau[i] + tau_brake[i] - armature_[i] * data_->qacc[joints_.dof[i]];
    }
    mj_step1(model_.get(), data_.get());
  } catch (const EngineFault&) {
    ++faults_;
    ++step_warnings_;
    halted_ = true;
  }
  halted_ = !TakeWarnings() || halted_;
  if (halted_) {
    // No measurement from here on.
    constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
    for (JointVector* values :
         {&sensors_.q, &sensors_.dq, &sensors_.tau_J, &sensors_.theta, &sensors_.dtheta}) {
      values->fill(kNothing);
    }
    return;
  }
  ++tick_;
  Sense(tau_J);
  if (hand_) hand_->Sense(*data_);
  if (base_) base_->Sense(*data_);
}

void EnginePlant::Sense(const JointVector& tau_J) noexcept {
  sensors_.tau_J = tau_J;
  for (std::size_t i = 0; i < kJoints; ++i) {
    sensors_.q[i] = data_->qpos[joints_.qpos[i]];
    sensors_.dq[i] = data_->qvel[joints_.dof[i]];
  }
  const auto add = [this](double deviation, std::uint32_t first_draw, JointVector& values) {
    if (deviation == 0) return;
    for (std::uint32_t i = 0; i < kJoints; ++i) {
      values[i] += deviation * random_.Normal(tick_, first_draw + i);
    }
  };
  add(noise_.q_rad, 0, sensors_.q);
  add(noise_.dq_rad_per_s, kJoints, sensors_.dq);
  add(noise_.tau_J_Nm, 2 * kJoints, sensors_.tau_J);
  sensors_.theta = sensors_.q;
  sensors_.dtheta = sensors_.dq;
  if (elasticity_ == ElasticityProfile::kStatic) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      sensors_.theta[i] += tau_J[i] / kJointStiffness;
      sensors_.dtheta[i] += (tau_J[i] - tau_J_[i]) / (kCycleSeconds * kJointStiffness);
    }
  }
  tau_J_ = tau_J;
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
  if (halted_) text += "the arm is halted since: no step is taken until the next Reset\n";
  return text;
}

JointVector EnginePlant::GravityTorque(const JointVector& q) {
  if (!gravity_data_) gravity_data_.reset(mj_makeData(model_.get()));
  mjData* data = gravity_data_.get();
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
