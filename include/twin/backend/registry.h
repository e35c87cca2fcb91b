#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "twin/backend/backend.h"
#include "twin/backend/hand.h"
#include "twin/backend/mobile_base.h"
#include "twin/core/clock.h"
#include "twin/core/panel.h"
#include "twin/robot/robot_config.h"
#include "twin/rt/arrival.h"
#include "twin/rt/cycle_record.h"
#include "twin/rt/duration_histogram.h"
#include "twin/rt/event_queue.h"
#include "twin/rt/thread_setup.h"

namespace twin::plant {
class TruthProbe;
}  // namespace twin::plant

namespace twin::fci {
class Capture;
}  // namespace twin::fci

namespace twin::backend {

/// The virtual clock of lockstep.
struct LockstepHost {
  rt::EventQueue& events;
  rt::EventHandler& state_ready;  ///< told (token = message_id) when a state has arrived
};

/// The wall clock. A simulated robot runs on a thread of its own.
struct RealtimeHost {
  const MonotonicClock& clock;
  rt::ThreadSettings robot_thread;
};

/// What keeps the time of a robot at the other end of a wire.
enum class RobotTime : std::uint8_t {
  kWall,  ///< it has a clock, as hardware has
  /// Its states: each is sent when the one before has been answered, and is 1 ms of its time.
  kStates,
};

/// A robot at the other end of a wire.
struct RemoteHost {
  const MonotonicClock& clock;
  std::string address;         ///< IPv4 address, or name
  std::uint16_t arm_port = 0;  ///< of TCP; 0: the interface's own
  RobotTime time = RobotTime::kWall;
  fci::Capture* capture = nullptr;  ///< keeps what goes over the wire; null: nothing does
};

/// What a factory gets. References and pointers must outlive the backend.
struct Request {
  const robot::RobotConfig& robot;
  std::variant<LockstepHost, RealtimeHost, RemoteHost> host;
  rt::RecordSink* sink =
      nullptr;  ///< INT's cycle records, where the backend knows them; may be null
};

/// How a simulated robot kept its own time, in real time.
struct RobotTimings {
  rt::DurationHistogram lateness;    ///< of a cycle's begin after its deadline
  std::uint64_t overruns = 0;        ///< whole periods that were skipped
  std::uint64_t commands_lost = 0;   ///< written while it took none for so long that they piled up
  std::vector<std::string> notices;  ///< what its thread was not permitted
};

/// A simulated robot that runs on the wall clock. Threads: one.
class RealtimeRobotControl {
 public:
  virtual ~RealtimeRobotControl() = default;
  /// Starts the cycles, once; the first is due 1 ms from now. Until then no state is sent, and what
  /// is written is lost. @throws InputError when the thread's settings are none of this machine's.
  virtual void Begin() = 0;
  /// Ends them: no record is put and no state sent after it returns. May be called again.
  virtual void End() = 0;
  /// @pre not between Begin() and End().
  [[nodiscard]] virtual RobotTimings timings() const = 0;
};

/// The buttons and switches of a simulated robot. Threads: any, as Backend's requests.
class Panel {
 public:
  virtual ~Panel() = default;
  /// @throws RobotFault when the robot's mode does not allow it, naming both.
  virtual void Operate(PanelAction action) = 0;
};

/// A connected backend, and what only a twin has.
struct Connection {
  std::unique_ptr<Backend> backend;
  rt::Arrival* arrival = nullptr;  ///< real time, remote: where to wait for the next state; owned
                                   ///< by the backend; null in lockstep
  RealtimeRobotControl* robot_time = nullptr;  ///< real time, simulated robot; null otherwise
  Panel* panel = nullptr;                      ///< owned by the backend; null for hardware
  Hand* hand = nullptr;                        ///< owned by the backend; null when none is mounted
  MobileBase* base = nullptr;  ///< owned by the backend; null when the arm stands on the world
  /// Owned by the backend; null for hardware and the ideal plant. In real time, while cycles run,
  /// only from RecordSink::Put of a cycle's record: that is called on the plant's thread.
  const plant::TruthProbe* truth = nullptr;
  /// What the simulation itself complained of since it was connected, for people; empty: nothing.
  /// Empty function: there is no simulation. Not while cycles run on another thread.
  std::function<std::string()> engine_warnings;
  /// Why the connection is gone, for people; empty: it is not. Empty function: there is no wire.
  std::function<std::string()> why_lost;
  /// Nothing but a simulated arm moves. False: hardware, or a robot that does not say.
  bool is_twin = true;
  bool uses_meshes = false;  ///< false: the arm is drawn in primitive shapes
};

using Factory = std::function<Connection(const Request&)>;

/// The backends a program knows, by name. Filled from an explicit list by the program's main.
class Registry {
 public:
  /// @pre no backend of this name was added.
  void Add(std::string name, Factory factory);

  /// @throws InputError when there is no such backend; the text lists those there are.
  [[nodiscard]] const Factory& Find(std::string_view name) const;

  [[nodiscard]] std::vector<std::string> Names() const;

 private:
  std::vector<std::pair<std::string, Factory>> entries_;
};

}  // namespace twin::backend
