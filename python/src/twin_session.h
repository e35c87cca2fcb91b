#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bindings.h"
#include "cell_clock.h"
#include "home_process.h"
#include "signals.h"
#include "twin/control/registry.h"
#include "twin/core/hand_command.h"
#include "twin/core/robot_state.h"
#include "twin/planning/collision_world.h"
#include "twin/run/run_records.h"
#include "twin/run/session.h"
#include "twin/scenario/scenario.h"

namespace twin::python {

/// Where a session's scenario comes from, and what replaces its own.
struct Opening {
  std::optional<std::string> text;  ///< nullopt: `file` is read
  std::filesystem::path file;       ///< or the text's name in messages
  std::optional<std::uint64_t> seed;
  std::optional<std::string> lab;
  std::optional<std::filesystem::path> log;
};

/// The place of a robot in a cell. All must outlive the session.
struct Seat {
  CellClock& clock;
  std::size_t robot = 0;              ///< of the clock
  const backend::Registry& backends;  ///< which connect it to the model that it shares
  run::RunFiles files;                ///< with its neighbours
};

/// A snapshot, and whose it is.
struct Snapshot {
  std::shared_ptr<const run::Session::Snapshot> copy;
  std::uint64_t session = 0;
};

/// The options of TwinSession::Control().
struct ControlOptions {
  std::optional<double> until;  ///< s
  std::string impedance;
  std::optional<std::string> tick;  ///< section of a scenario, YAML
};

/// A run::Session with its records, for Python: calls from two threads at once, from the law of a
/// motion that runs, and after Close() are refused; Ctrl-C stops each call.
///
/// All calls are made with the GIL released, but Control(). Errors: as run::Session;
/// std::runtime_error while another call is under way, and in a fork of the process when there is a
/// log; InputError once closed. A robot of a cell has the cell's time, as CellClock has it: its
/// calls also throw as CellClock::Call, and Reset(), Save() and Restore() throw InputError.
class TwinSession {
 public:
  explicit TwinSession(const Opening& opening);
  /// Of a robot of a cell. @param log  MCAP file to write.
  TwinSession(const scenario::Scenario& scenario, const std::optional<std::filesystem::path>& log,
              const Seat& seat);
  ~TwinSession();
  TwinSession(const TwinSession&) = delete;
  TwinSession& operator=(const TwinSession&) = delete;

  [[nodiscard]] RobotState State();
  [[nodiscard]] double Now();
  /// The scenario's own motion.
  run::MotionResult MoveOwn();
  run::MotionResult Move(const reference::Trajectory& trajectory, const std::string& interface,
                         const std::string& impedance, const std::string& name);
  run::MotionResult MoveTo(const JointVector& q, const std::string& interface,
                           const reference::Timing& pace, double clearance);
  /// Runs a law. @pre the GIL is held.
  run::MotionResult Control(nb::object law, const ControlOptions& options);
  run::HandOutcome Command(const HandCommand& command);
  [[nodiscard]] HandState ReadHand();
  [[nodiscard]] std::vector<std::pair<std::string, Transform>> Bodies();
  void Place(const std::string& body, const Transform& X_WB);
  void Wait(double seconds);
  void Recover();
  void Reset(const std::optional<JointVector>& q);
  void PressUserStop(bool pressed);
  [[nodiscard]] Snapshot Save();
  void Restore(const Snapshot& snapshot);

  /// Ends the session and completes the log. A second call does nothing.
  void Close();
  [[nodiscard]] bool is_closed() const noexcept { return closed_.load(); }
  /// @throws InputError before Close().
  [[nodiscard]] run::SessionResult Result();
  [[nodiscard]] const std::string& name() const noexcept { return scenario_.name; }

 private:
  class Use;
  class LawInUse;
  /// @param seat  null: alone.
  TwinSession(scenario::Scenario scenario, const std::optional<std::filesystem::path>& log,
              const Seat* seat);
  [[nodiscard]] std::unique_ptr<run::Session> Connect(const backend::Registry& backends);
  void Begin(const std::optional<std::filesystem::path>& log);
  /// @throws InputError in a cell.
  void RequireAlone(std::string_view call) const;
  void Look();
  /// Throws what a signal's handler raised during a call, or that the cell has stopped it.
  void Rethrow();
  /// Makes a call that Ctrl-C interrupts, and raises what a signal's handler raised meanwhile.
  template <typename Call>
  auto Interruptible(Call call);
  run::MotionResult Run(const run::Motion& motion);
  /// Of a law: the scenario's, unless it is one of torques and this interface is not, or reversed.
  scenario::TickSection TickFor(control::CommandInterface interface) const;
  run::Motion MotionOn(control::CommandInterface interface, const std::string& impedance,
                       const std::string& name, reference::Trajectory trajectory) const;

  const std::uint64_t id_;
  const scenario::Scenario scenario_;
  const run::RunFiles files_;
  control::ControllerRegistry controllers_;  ///< the program's, and law_
  std::function<std::unique_ptr<control::Controller>()> law_;
  SignalWatch signals_;
  const HomeProcess home_;
  CellClock* const clock_;                    ///< null: alone
  const std::size_t robot_;                   ///< of the clock
  std::unique_ptr<run::RunRecords> records_;  ///< null: no log
  std::unique_ptr<CycleEnds> ends_;           ///< in a cell: before the records
  std::unique_ptr<run::Session> session_;
  std::unique_ptr<planning::CollisionWorld> world_;  ///< of MoveTo(), made by its first call
  std::optional<run::SessionResult> result_;
  std::atomic<bool> in_use_{false};  ///< acquire-release: the session's memory goes with it
  std::atomic<bool> closed_{false};
};

}  // namespace twin::python
