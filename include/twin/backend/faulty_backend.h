#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "twin/backend/backend.h"
#include "twin/core/random.h"
#include "twin/rt/loss_model.h"

namespace twin::backend {

/// When a fault strikes: with a probability per message, and at the messages listed besides.
struct FaultSchedule {
  double probability = 0;                 ///< in [0, 1]
  std::vector<std::uint64_t> messages{};  ///< message_id of each, rising
};

/// What goes wrong between a backend and who uses it. A message's number is its message_id: of a
/// state its own, of a command that of the state it answers. Whether a fault strikes is a function
/// of (plan, number); a plan draws apart from the link's faults, also with the same seed.
struct FaultPlan {
  std::uint64_t seed = 0;

  rt::LossModel state_loss{};    ///< states that are never read
  rt::LossModel command_loss{};  ///< commands that are never written; nothing else happens to them

  FaultSchedule command_duplicated{};  ///< written twice
  /// Written after the next one. Those two are left in peace by command_delayed, and the second by
  /// command_swapped.
  FaultSchedule command_swapped{};
  FaultSchedule command_delayed{};  ///< written before the next one, but not earlier
  /// NaN in the fields that the modes of the state read last make active; none outside a motion.
  FaultSchedule command_garbage{};

  /// The connection is gone as soon as this state, or one after it, would be read.
  std::optional<std::uint64_t> gone_from{};

  /// @throws InputError naming the field that is out of range, out of order, or that can never
  /// strike because of another one.
  void Validate() const;
};

/// How often each fault has struck.
struct FaultCounts {
  std::uint64_t states_lost = 0;
  std::uint64_t commands_lost = 0;
  std::uint64_t commands_duplicated = 0;
  std::uint64_t commands_swapped = 0;
  std::uint64_t commands_delayed = 0;
  std::uint64_t commands_garbage = 0;

  bool operator==(const FaultCounts&) const = default;
};

/// Any backend, with faults injected on the way to and from it.
///
/// A state is lost when it is read: Read() then gives kPending, as if it had never come. (An older
/// one that it overtook inside the backend does not come back.) Once the connection is gone, Read()
/// gives kLost and Write() and Stop() reach nobody for good; the rest is refused. A command held
/// back when no other follows is never written.
///
/// Threads and real-time: as Backend; counts() while nobody reads or writes.
class FaultyBackend final : public Backend {
 public:
  /// @throws InputError when the plan is not valid.
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
  /// A command with what has been decided about it; no copies: there is none.
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
  std::uint64_t seed_;  ///< from the plan's
  rt::LossProcess state_loss_;
  rt::LossProcess command_loss_;

  RobotState read_;  ///< so that the caller's is written only for kState
  MotionGeneratorMode generator_ = MotionGeneratorMode::kIdle;  ///< as the state given last showed
  ControllerMode controller_ = ControllerMode::kOther;
  Outgoing held_;
  bool held_is_swapped_ = false;  ///< else delayed
  FaultCounts counts_;
  std::atomic<bool> gone_ = false;  ///< set by Read, seen by the calls of the other thread
};

}  // namespace twin::backend
