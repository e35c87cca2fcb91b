#include "plant/engine_world.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "twin/plant/engine.h"

namespace twin::plant {
namespace {

/// Tilts gravity instead of the base: g_O = R^T g_W. Level: unchanged.
void TiltGravity(const BaseTilt& tilt, mjModel& model) {
  if (tilt == BaseTilt()) return;
  const double g = -model.opt.gravity[2];
  model.opt.gravity[0] = g * std::sin(tilt.pitch);
  model.opt.gravity[1] = -g * std::cos(tilt.pitch) * std::sin(tilt.roll);
  model.opt.gravity[2] = -g * std::cos(tilt.pitch) * std::cos(tilt.roll);
}

}  // namespace

EngineWorld::EngineWorld(std::span<const MujocoPlantOptions> arms, const ModelSources& sources,
                         BuiltModel built, std::function<void()> others)
    : model_(std::move(built.model)),
      load_warnings_(std::move(built.warnings)),
      data_(mj_makeData(model_.get())),
      others_(std::move(others)),
      gate_(arms.size() > 1 && !others_ ? std::make_unique<Gate>() : nullptr),
      presence_(arms.size(), Presence::kMoving) {
  TiltGravity(arms.front().base_tilt, *model_);
  arms_.reserve(arms.size());
  for (std::size_t i = 0; i < arms.size(); ++i) {
    arms_.emplace_back(arms[i], sources.arms[i].robot, *model_);
  }
}

void EngineWorld::Reset(std::size_t arm, const JointVector& q) {
  EngineArm& one = arms_[arm];
  if (arms_.size() == 1) {
    mj_resetData(model_.get(), data_.get());
    tick_ = 0;
  }
  one.Reset(q, *model_, *data_);
  halted_ = false;
  try {
    if (one.live().base) one.live().base->Settle(*model_, *data_);
    mj_forward(model_.get(), data_.get());
  } catch (const EngineFault&) {
    Halt();
  }
  halted_ = !TakeWarnings() || halted_;
  one.SenseAtRest(*data_);
}

void EngineWorld::Step() noexcept {
  if (halted_) {
    ++step_warnings_;
    return;
  }
  for (EngineArm& arm : arms_) arm.ClearForces(*data_);
  for (EngineArm& arm : arms_) arm.Apply(time(), *model_, *data_);
  try {
    for (EngineArm& arm : arms_) arm.Drive(*model_, *data_);
    // This order of the halves leaves poses and contacts of the new state in data().
    mj_step2(model_.get(), data_.get());
    for (EngineArm& arm : arms_) arm.Take(*model_, *data_);
    mj_step1(model_.get(), data_.get());
  } catch (const EngineFault&) {
    Halt();
  }
  halted_ = !TakeWarnings() || halted_;
  if (halted_) {
    // No measurement from here on.
    for (EngineArm& arm : arms_) arm.Lose();
    return;
  }
  ++tick_;
  for (EngineArm& arm : arms_) arm.Sense(*data_, tick_);
}

std::size_t EngineWorld::PresentArms() const noexcept {
  return presence_.size() -
         static_cast<std::size_t>(std::ranges::count(presence_, Presence::kGone));
}

bool EngineWorld::is_awaited() const noexcept {
  const auto lock = Lock();
  return IsAwaitedLocked();
}

bool EngineWorld::IsAwaitedLocked() const noexcept {
  return presence_.size() > 1 && std::ranges::count(presence_, Presence::kMoving) > 0;
}

void EngineWorld::Meet() noexcept {
  if (arms_.size() == 1) return Step();
  auto lock = Lock();
  const std::uint64_t round = round_;
  ++here_;
  while (round_ == round && IsAwaitedLocked()) {
    if (here_ < PresentArms()) {
      gate_ ? gate_->changed.wait(lock) : others_();
      continue;
    }
    here_ = 0;
    ++round_;
    Step();
    if (gate_) gate_->changed.notify_all();
  }
}

void EngineWorld::SetPresence(std::size_t i, Presence presence) noexcept {
  const auto lock = Lock();
  presence_[i] = presence;
  if (presence == Presence::kGone) {
    arms_[i].live().drive = {};
    arms_[i].live().drive.brakes = true;
  }
  if (gate_) gate_->changed.notify_all();
}

void EngineWorld::StandBy(std::size_t i) noexcept {
  SetPresence(i, Presence::kStandingBy);
}

void EngineWorld::Leave(std::size_t i) noexcept {
  SetPresence(i, Presence::kGone);
}

void EngineWorld::Halt() noexcept {
  ++faults_;
  ++step_warnings_;
  halted_ = true;
}

EngineWorld::FreeMotion EngineWorld::Swap(int joint, const FreeMotion& motion) {
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

Overlap EngineWorld::DeepestOf(int body) const noexcept {
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

std::optional<Overlap> EngineWorld::Place(int body, const Transform& X_WB) noexcept {
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
    if (deepest.depth > Plant::kMostOverlap) {
      Swap(joint, before);
      return deepest;
    }
    std::fill_n(data_->qacc_warmstart + model_->jnt_dofadr[joint], motion.qvel.size(), 0);
  } catch (const EngineFault&) {
    Halt();
  }
  return {};
}

std::unique_ptr<const Plant::State> EngineWorld::Save() const {
  auto saved = std::make_unique<Saved>();
  for (const EngineArm& arm : arms_) saved->arms.push_back(arm.live());
  saved->tick = tick_;
  saved->halted = halted_;
  saved->data.reset(mj_copyData(nullptr, model_.get(), data_.get()));
  saved->dof_frictionloss.assign(model_->dof_frictionloss, model_->dof_frictionloss + model_->nv);
  return saved;
}

void EngineWorld::Restore(const Plant::State& state) {
  const auto& saved = static_cast<const Saved&>(state);
  mj_copyData(data_.get(), model_.get(), saved.data.get());
  std::ranges::copy(saved.dof_frictionloss, model_->dof_frictionloss);
  for (std::size_t i = 0; i < arms_.size(); ++i) arms_[i].live() = saved.arms[i];
  tick_ = saved.tick;
  halted_ = saved.halted;
}

bool EngineWorld::TakeWarnings() noexcept {
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

std::string EngineWorld::DescribeWarnings() const {
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

mjData& EngineWorld::SideData() {
  if (!side_data_) side_data_.reset(mj_makeData(model_.get()));
  return *side_data_;
}

}  // namespace twin::plant
