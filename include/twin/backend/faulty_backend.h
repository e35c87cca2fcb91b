#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "twin/backend/backend.h"
#include "twin/core/random.h"
#include "twin/faults/loss_model.h"

namespace twin::backend {

/// Messages at which a fault strikes: each with a probability, and all those listed.
struct FaultSchedule {
  double probability = 0;                 ///< in [0, 1]
  std::vector<std::uint64_t> messages{};  ///< message_ids, rising
};

/// Faults between a backend and its user. A state's number is its message_id; a command has the
/// number of the state that it answers. A fault depends on (plan, number) only. Its draws are
/// independent of the link's faults, even with the same seed.
struct FaultPlan {
  std::uint64_t seed = 0;

  faults::LossModel state_loss{};  ///< states that are never read
  faults::LossModel
      command_loss{};  ///< commands that are never written; no other fault affects them

  FaultSchedule command_duplicated{};  ///< written twice
  /// Written after the next command. command_delayed skips both commands of a swap, and
  /// command_swapped skips the second.
  FaultSchedule command_swapped{};
  FaultSchedule command_delayed{};  ///< held until just before the next command is written
  /// NaN in the fields that the modes of the last read state use; no effect outside a motion.
  FaultSchedule command_garbage{};

  /// The connection is lost when this state, or a later one, would be read.
  std::optional<std::uint64_t> gone_from{};

  /// @throws InputError naming a field that is out of range, out of order, or that another field
  /// keeps from ever striking.
  void Validate() const;
};

/// Number of strikes of each fault.
struct FaultCounts {
  std::uint64_t states_lost = 0;
  std::uint64_t commands_lost = 0;
  std::uint64_t commands_duplicated = 0;
  std::uint64_t commands_swapped = 0;
  std::uint64_t commands_delayed = 0;
  std::uint64_t commands_garbage = 0;

  bool operator==(const FaultCounts&) const = default;
};

/// Decorates any backend with injected faults.
///
/// A lost state makes Read() give kPending, as if it had not arrived. (An older state that it
/// overtook inside the backend does not return.) After the connection is lost, Read() gives kLost,
/// Write() and Stop() have no effect, and all other requests are refused. A held command is never
/// written if no other command follows.
///
/// Threads and real-time: as Backend; call counts() only while no Read() or Write() runs.
class FaultyBackend final : public Backend {
 public:
  /// @throws InputError if the plan is invalid.
  FaultyBackend(std::unique_ptr<Backend> inner, FaultPlan plan);

  [[nodiscard]] Description Describe() const override;
  void Configure(const Setting& setting) override;
  void Start(const MotionModes& modes) override;
  [[nodiscard]] ReadResult Read(ReadRule rule, RobotState& state,
                                Time& arrival) noexcept override TWIN_REALTIME;
  void Write(const RobotCommand& command) noexcept override TWIN_REALTIME;
  void Stop() override;
  void Recover() override;

  [[nodiscard]] const FaultCounts& counts() const noexcept { return counts_; }

 private:
  /// A command and its number of copies after the faults; 0 copies: lost.
  struct Outgoing {
    RobotCommand command;
    int copies = 0;
  };

  [[nodiscard]] bool gone() const noexcept;
  void RequireConnection(const char* request) const;
  [[nodiscard]] Outgoing Prepare(const RobotCommand& command) noexcept;
  [[nodiscard]] bool Hold(const Outgoing& outgoing) noexcept;
  void PutOut(const Outgoing& outgoing) noexcept;

  std::unique_ptr<Backend> inner_;
  FaultPlan plan_;
  std::uint64_t seed_;  ///< derived from the plan's seed
  faults::LossProcess state_loss_;
  faults::LossProcess command_loss_;

  RobotState read_;  ///< a copy, so that the caller's state is written only for kState
  MotionGeneratorMode generator_ = MotionGeneratorMode::kIdle;  ///< as in the last returned state
  ControllerMode controller_ = ControllerMode::kOther;
  Outgoing held_;
  bool held_is_swapped_ = false;  ///< else delayed
  FaultCounts counts_;
  std::atomic<bool> gone_ = false;  ///< set by Read, read by calls on other threads
};

}  // namespace twin::backend
