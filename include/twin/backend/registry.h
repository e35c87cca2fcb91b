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
#include "twin/core/modes.h"
#include "twin/core/registry.h"
#include "twin/record/cycle_record.h"
#include "twin/robot/robot_config.h"
#include "twin/rt/duration_histogram.h"
#include "twin/rt/event_queue.h"
#include "twin/rt/signal.h"
#include "twin/rt/thread_setup.h"

namespace twin::plant {
class TruthProbe;
}  // namespace twin::plant

namespace twin::fci {
class Capture;
}  // namespace twin::fci

namespace twin::robot {
class Robot;
}  // namespace twin::robot

namespace twin::backend {

/// The virtual clock of lockstep.
struct VirtualTime {
  rt::EventQueue& events;
  rt::EventHandler& state_ready;  ///< notified (token = message_id) when a state has arrived
};

/// The wall clock. A simulated robot runs on its own thread.
struct WallTime {
  const MonotonicClock& clock;
  rt::ThreadSettings robot_thread;
};

/// Clock of a robot at the other end of a wire.
enum class RobotTime : std::uint8_t {
  kWall,  ///< the robot has a clock, as hardware does
  /// The states are the clock: each is 1 ms, and is sent after the previous one was answered.
  kStates,
  /// kStates for a robot that says that it is a twin served in lockstep, else kWall.
  kAsItSays,
};

/// A robot at the other end of a wire.
struct RobotAddress {
  std::string host;             ///< IPv4 address, or name
  std::uint16_t arm_port = 0;   ///< TCP; 0: the interface's default
  std::uint16_t hand_port = 0;  ///< TCP; 0: the port after the arm's, a vacuum gripper's two after
  RobotTime time = RobotTime::kAsItSays;
  /// The longest time without a state; then the robot counts as gone. At least 5 s for kStates.
  Duration silence = std::chrono::seconds(1);
  fci::Capture* capture = nullptr;  ///< records the traffic on the wire; may be null
};

/// The same, with the clock that times its messages.
struct RemoteRobot {
  const MonotonicClock& clock;
  RobotAddress address;
};

/// Arguments of a factory. References and pointers must outlive the backend.
struct Request {
  const robot::RobotConfig& robot;
  std::variant<VirtualTime, WallTime, RemoteRobot> time;
  record::RecordSink* sink =
      nullptr;  ///< INT's cycle records, if the backend knows them; may be null
};

/// Timing of a simulated robot in real time.
struct RobotTimings {
  rt::DurationHistogram lateness;    ///< of a cycle's start
  std::uint64_t overruns = 0;        ///< whole periods skipped
  std::uint64_t commands_lost = 0;   ///< lost at a full queue: the robot did not read
  std::vector<std::string> notices;  ///< permissions that its thread did not get
};

/// Controls a simulated robot on the wall clock. Threads: one.
class RealtimeRobotControl {
 public:
  virtual ~RealtimeRobotControl() = default;
  /// Starts the cycles, once; the first is due 1 ms from now. Before that, no state is sent and
  /// commands are lost. @throws InputError if this machine does not support the thread's settings.
  virtual void Begin() = 0;
  /// Its records end: after return none is put. INT holds the arm, for others that share its model.
  /// @throws RobotFault when the robot's thread does not answer within 1 s.
  virtual void StandBy() = 0;
  /// Ends the cycles: after return, no record is put and no state is sent. May be called again.
  virtual void End() = 0;
  /// @pre not between Begin() and End().
  [[nodiscard]] virtual RobotTimings timings() const = 0;
};

/// Buttons and switches of a simulated robot. Threads: any, as Backend's requests.
class Panel {
 public:
  virtual ~Panel() = default;
  /// @throws RobotFault naming action and mode if the robot's mode does not allow the action.
  virtual void Operate(PanelAction action) = 0;
};

/// A connected backend, with the extras that only a twin has.
struct Connection {
  std::unique_ptr<Backend> backend;
  rt::Arrival* arrival = nullptr;  ///< real time, remote: signals the next state; owned by the
                                   ///< backend; null in lockstep
  RealtimeRobotControl* robot_time = nullptr;  ///< real time, simulated robot; null otherwise
  Panel* panel = nullptr;                      ///< owned by the backend; null for hardware
  Hand* hand = nullptr;                        ///< owned by the backend; null without a hand
  MobileBase* base = nullptr;                  ///< owned by the backend; null without a mobile base
  /// A robot simulated in lockstep, to be looked at, reset, saved and restored between two events;
  /// owned by the backend; null otherwise.
  robot::Robot* lockstep_robot = nullptr;
  /// Owned by the backend; null for hardware and the ideal plant. In real time, while cycles run,
  /// use it only in RecordSink::Put of a cycle's record, which runs on the plant's thread.
  const plant::TruthProbe* truth = nullptr;
  /// The simulation's warnings since the connection, for users; "" if there are none. An empty
  /// function without a simulation. Do not call while cycles run on another thread.
  std::function<std::string()> engine_warnings;
  /// Why the connection was lost, for users; "" while it is up. An empty function without a wire.
  std::function<std::string()> why_lost;
  Duration silence = std::chrono::seconds(1);  ///< without a state: the robot has gone
  RobotTime time = RobotTime::kWall;           ///< remote: its clock; never kAsItSays
  /// True if only a simulated arm moves. False for hardware, and for a robot that does not say.
  bool is_twin = true;
  bool uses_meshes = false;  ///< false: the arm is drawn in primitive shapes
};

using Factory = std::function<Connection(const Request&)>;

/// The program's backends by name. The program's main fills it from an explicit list.
class Registry : public twin::Registry<Factory> {
 public:
  Registry() : twin::Registry<Factory>("backend") {}
};

}  // namespace twin::backend
