#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <mujoco/mujoco.h>

#include "plant/engine_arm.h"
#include "plant/model_builder.h"
#include "plant/model_sources.h"
#include "twin/plant/plant.h"

namespace twin::plant {

/// A model in the engine and its arms, stepped by 1 ms.
///
/// An unstable motion by the engine's criterion halts all arms.
///
/// Threads: as SharedModel's. Real-time: Step(), Meet(), Place() are noexcept and allocate nothing;
/// with threads for several arms they lock.
class EngineWorld {
 public:
  /// @param arms  options of the model's arms, in the order of `sources`. @param others  as
  /// SharedModel::Create's; of no use to one arm.
  EngineWorld(std::span<const MujocoPlantOptions> arms, const ModelSources& sources,
              BuiltModel built, std::function<void()> others);

  /// An arm alone: the model as in the beginning. One among several: this arm alone, while time
  /// goes on.
  void Reset(std::size_t arm, const JointVector& q);
  /// As BaseJoints, for the state after Reset().
  void RequireStanding(const BasePose& start) const {
    arms_.front().live().base->RequireStanding(start, *model_, *data_);
  }
  /// Takes the step, by each arm's live().drive.
  void Step() noexcept TWIN_REALTIME;

  /// Takes the step with the last arm that comes; until then lets the others go on. Returns without
  /// a step once all arms stand by.
  void Meet() noexcept TWIN_REALTIME;
  /// Arm `i` only holds from now on.
  void StandBy(std::size_t i) noexcept;
  /// Arm `i` comes no more: its brakes close.
  void Leave(std::size_t i) noexcept;
  /// Whether any arm still moves.
  [[nodiscard]] bool is_awaited() const noexcept TWIN_REALTIME;

  /// For calls of one arm's thread that other threads must not interrupt. Empty on one thread.
  [[nodiscard]] std::unique_lock<std::mutex> Lock() const {
    return gate_ ? std::unique_lock(gate_->mutex) : std::unique_lock<std::mutex>();
  }

  std::optional<Overlap> Place(int body, const Transform& X_WB) noexcept TWIN_REALTIME;
  void BeginMotion(std::size_t arm) noexcept TWIN_REALTIME {
    arms_[arm].live().perturber.BeginMotion(time());
  }

  struct Saved final : Plant::State {
    std::vector<EngineArm::Live> arms;
    std::uint64_t tick = 0;
    bool halted = false;
    DataPointer data;
    std::vector<mjtNum> dof_frictionloss;
  };
  [[nodiscard]] std::unique_ptr<const Plant::State> Save() const;
  void Restore(const Plant::State& state);

  [[nodiscard]] EngineArm& arm(std::size_t i) noexcept { return arms_[i]; }
  [[nodiscard]] const EngineArm& arm(std::size_t i) const noexcept { return arms_[i]; }
  [[nodiscard]] std::size_t size() const noexcept { return arms_.size(); }
  [[nodiscard]] mjModel& model() noexcept { return *model_; }
  [[nodiscard]] const mjModel& model() const noexcept { return *model_; }
  [[nodiscard]] mjData& data() noexcept { return *data_; }
  [[nodiscard]] const mjData& data() const noexcept { return *data_; }
  [[nodiscard]] Duration time() const noexcept { return static_cast<std::int64_t>(tick_) * kCycle; }
  /// For computations beside the motion; created on first use.
  [[nodiscard]] mjData& SideData();

  [[nodiscard]] std::uint64_t warning_count() const noexcept {
    return load_warnings_.size() + step_warnings_;
  }
  [[nodiscard]] std::string DescribeWarnings() const;

 private:
  enum class Presence : std::uint8_t { kMoving, kStandingBy, kGone };
  /// Where the threads of several arms wait for each other.
  struct Gate {
    std::mutex mutex;  ///< of all below, and of the model and its data
    std::condition_variable changed;
  };
  void SetPresence(std::size_t i, Presence presence) noexcept;
  [[nodiscard]] bool IsAwaitedLocked() const noexcept TWIN_REALTIME;

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
  /// Collects the engine's warnings. @returns false for one that invalidates the motion.
  bool TakeWarnings() noexcept TWIN_REALTIME;
  [[nodiscard]] std::size_t PresentArms() const noexcept TWIN_REALTIME;

  ModelPointer model_;
  std::vector<std::string> load_warnings_;
  DataPointer data_;
  DataPointer side_data_;
  std::vector<EngineArm> arms_;
  std::uint64_t tick_ = 0;  ///< steps since the last Reset(); key of the noise
  bool halted_ = false;
  const std::function<void()> others_;
  const std::unique_ptr<Gate> gate_;  ///< null: one thread
  std::vector<Presence> presence_;
  std::size_t here_ = 0;     ///< arms that wait for the step
  std::uint64_t round_ = 0;  ///< steps that arms have met for
  // Counts since the construction, which no Restore() takes back.
  std::array<std::uint64_t, mjNWARNING> warnings_{};
  std::uint64_t faults_ = 0;  ///< steps with an engine fault
  std::uint64_t step_warnings_ = 0;
};

}  // namespace twin::plant
