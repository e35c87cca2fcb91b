#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string_view>

#include "conformance/reference_rules.h"
#include "twin/core/hash.h"
#include "twin/record/cycle_record.h"
#include "twin/scenario/scenario.h"

namespace twin::campaign {

/// Whether the workstation sent a command in this tick.
[[nodiscard]] bool WasWritten(const record::TickRecord& tick);

/// Messages that laws of chance lost, and how many they should have.
struct LossTally {
  double lost = 0;
  double expected = 0;
  double variance = 0;

  void Add(const LossTally& other) {
    lost += other.lost;
    expected += other.expected;
    variance += other.variance;
  }
};

/// Watches clocks, links and the workstation's ticks of a run in lockstep, by what the scenario
/// says of them and nothing else. Part of Watch.
class MessageWatch {
 public:
  using Note = std::function<void(std::string_view invariant, const test::Finding& finding)>;

  /// @param world  must outlive this. @param note  is told of each violation.
  MessageWatch(const scenario::Scenario& world, Note note);

  void OnTick(const record::TickRecord& tick);
  void OnCycle(const record::CycleRecord& record);
  /// After the run. @param written, arrived  commands: in all, and those served or dropped.
  void End(std::uint64_t written, std::uint64_t arrived);

  /// Messages that the links' laws of chance lost; 0 if they lost all, which is no chance.
  [[nodiscard]] std::uint64_t lost_by_chance() const {
    return losses_.lost < losses_.sent ? losses_.lost : 0;
  }
  /// Of both directions, by laws of chance.
  [[nodiscard]] const LossTally& tally() const { return tally_; }
  /// Which messages were lost, and how long each tick took: another seed, another value.
  [[nodiscard]] std::uint64_t losses_hash() const { return losses_hash_.value(); }
  [[nodiscard]] std::uint64_t costs_hash() const { return costs_hash_.value(); }
  /// Ticks that took another time than the one before, where it is drawn.
  [[nodiscard]] std::uint64_t changed_costs() const { return changed_costs_; }

 private:
  /// What is known of one direction of the link.
  struct Direction {
    Duration least{};         ///< no message arrives earlier
    bool is_certain = false;  ///< each message arrives once, after `least`, or not at all
  };
  /// Trials of a law of loss, and how many it lost.
  struct Losses {
    std::uint64_t sent = 0;
    std::uint64_t lost = 0;
  };

  static constexpr std::size_t kKept = 1024;  ///< by message id

  [[nodiscard]] static Direction Of(const scenario::DirectionSection& section);
  void CheckTickCount(const record::TickRecord& tick);
  void CheckPeriod(const record::TickRecord& tick);
  void CheckStall(const record::TickRecord& tick);
  void CheckDepositTime(const record::TickRecord& tick);
  void CheckArrival(const record::TickRecord& tick);
  void CountStates(std::uint64_t from, std::uint64_t to);
  void CheckCommand(const record::CycleRecord& record);
  void CheckArrived(std::uint64_t written, std::uint64_t arrived);
  void CheckLosses(std::string_view what, const scenario::DirectionSection& section,
                   const Losses& losses);

  const scenario::Scenario& world_;
  const Note note_;
  const Direction states_;
  const Direction commands_;
  const bool reads_all_;  ///< each state that arrives is read as it does
  std::array<record::TickRecord, kKept> ticks_{};
  std::array<Time, kKept> sent_{};  ///< when the state of an id was sent
  std::optional<record::TickRecord> last_tick_;
  std::optional<record::CycleRecord> first_cycle_;
  std::optional<Time> first_deposit_;
  std::uint64_t without_deposit_ = 0;  ///< cycles
  std::uint64_t last_command_ = 0;     ///< id that the last command answered; 0: none yet
  std::uint64_t lost_by_script_ = 0;   ///< commands
  /// When those commands were written that may not have come in the motion's last cycle.
  std::deque<Time> lately_;
  Losses states_lost_;
  Losses commands_lost_;
  Losses losses_;  ///< of both, by chance
  LossTally tally_;
  WordHash losses_hash_;
  WordHash costs_hash_;
  Duration last_cost_{};
  std::uint64_t changed_costs_ = 0;
};

}  // namespace twin::campaign
