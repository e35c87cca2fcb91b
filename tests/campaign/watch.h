#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "campaign/message_watch.h"
#include "campaign/source_watch.h"
#include "conformance/state_checker.h"
#include "twin/backend/registry.h"
#include "twin/plant/contact_watch.h"
#include "twin/record/cycle_record.h"
#include "twin/run/result.h"
#include "twin/scenario/scenario.h"

namespace twin::campaign {

/// A violated invariant.
struct Finding {
  std::string_view invariant;  ///< its name in README.md
  std::string text;            ///< cycle, values

  bool operator==(const Finding&) const = default;
};

/// Watches a run in lockstep, cycle by cycle, and tells the first invariant that is violated.
/// README.md names the invariants and the documents they come from.
///
/// Threads: the run's.
class Watch final : public record::RecordSink {
 public:
  /// @param world  must outlive this. @param may_touch  others may push the arm, too.
  Watch(const scenario::Scenario& world, bool may_touch)
      : world_(world),
        pushed_from_(may_touch ? std::optional<std::uint64_t>(0) : FirstPush(world)),
        messages_(world, [this](std::string_view invariant,
                                const auto& finding) { Note(invariant, finding); }),
        source_(world, [this](std::string_view invariant, const auto& finding) {
          Note(invariant, finding);
        }) {}
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  /// The registry's backends with a watched one in the place of "mujoco", whose requests this sees.
  [[nodiscard]] backend::Registry Watched(const backend::Registry& backends);

  void Put(const record::CycleRecord& record) noexcept TWIN_REALTIME override;
  void Put(const record::TickRecord& record) noexcept TWIN_REALTIME override;

  /// After the run; of an application there is none.
  void End(const run::RunResult& result);

  [[nodiscard]] const std::optional<Finding>& finding() const { return finding_; }
  /// Measured q of each cycle seen.
  [[nodiscard]] const std::vector<JointVector>& path() const { return path_; }
  [[nodiscard]] const MessageWatch& messages() const { return messages_; }

 private:
  friend class WatchedBackend;

  void Note(std::string_view invariant, const test::Finding& finding);
  void CheckSpecification(const record::CycleRecord& record);
  void CheckCount(const record::CycleRecord& record);
  void CheckEngine();
  void CheckReference(const RobotState& before, const RobotState& after, bool violated);
  void CheckEnergy(const RobotState& state);
  void CheckViability(const record::CycleRecord& record);
  void CheckGuard(const RobotState& state);
  void CheckRest(const RobotState& state);
  void CheckLimiter(const record::TickRecord& tick);
  void CheckFinish(const record::TickRecord& tick);
  void CheckPanel(const RobotState& state);
  void CheckContact(const record::CycleRecord& record);
  void CheckHand(const run::RunResult& result);
  void CheckEnd(const run::RunResult& result);
  void CheckUndisturbed(const run::RunResult& result);

  /// Id of the state from which on a perturbation may act; nullopt: there is none.
  [[nodiscard]] static std::optional<std::uint64_t> FirstPush(const scenario::Scenario& world);
  [[nodiscard]] bool IsPushed() const {
    return pushed_from_ && last_ && last_->state.message_id >= *pushed_from_;
  }

  static constexpr std::size_t kKept = 1024;  ///< ticks, by the id that they answer

  const scenario::Scenario& world_;
  const std::optional<std::uint64_t> pushed_from_;
  MessageWatch messages_;
  SourceWatch source_;
  std::optional<test::CheckedRobot> robot_;
  std::optional<test::StateChecker> specification_;
  std::optional<plant::ContactWatch> contacts_;  ///< of a motion that must not touch anything
  std::function<std::string()> engine_warnings_;
  std::optional<Finding> finding_;
  std::optional<record::CycleRecord> last_;
  JointVector q_d_at_end_{};  ///< in the state that ended the motion
  std::array<record::TickRecord, kKept> ticks_{};
  std::vector<JointVector> path_;
  run::CycleCounts counts_;  ///< by a recount of its own
  std::uint64_t written_ = 0;
  std::uint64_t skipped_ = 0;  ///< states
  bool has_stalled_ = false;   ///< the source, once: the arm then rejoins it by another way
  std::uint64_t last_tick_ = 0;
  bool finish_served_ = false;
  bool has_saturated_ = false;  ///< a motor, since the abort
  int since_abort_ = -1;        ///< cycles since a motion was ended by an error; -1: none was
};

}  // namespace twin::campaign
