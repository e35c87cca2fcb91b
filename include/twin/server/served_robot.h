#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "twin/fci/sockets.h"
#include "twin/robot/answer_paced_robot.h"
#include "twin/robot/make_plant.h"
#include "twin/robot/robot_config.h"
#include "twin/rt/cycle_record.h"
#include "twin/rt/duration_histogram.h"
#include "twin/rt/thread_setup.h"
#include "twin/server/request_handler.h"
#include "twin/server/server.h"

namespace twin::plant {
class TruthProbe;
}  // namespace twin::plant

namespace twin::server {

/// How a robot is served. What is pointed to must outlive it.
struct ServedRobotSettings {
  /// Where, to whom, and with what. Its capture keeps datagrams as well as TCP.
  ServerConfig server{};
  /// Instead of the server's ports: two free ones in a row, since clients that know the arm's port
  /// look for the hand at the next.
  bool takes_free_ports = false;
  /// Lockstep with who answers; absent: on the wall clock.
  std::optional<robot::LockstepOptions> lockstep{};
  /// Of the robot's thread. Absent: at real-time priority on the wall clock, an ordinary one in
  /// lockstep.
  std::optional<rt::ThreadSettings> thread{};
  rt::RecordSink* sink = nullptr;  ///< gets INT's cycles, on the robot's thread; null: nobody does
  TellPeople tell{};               ///< may be empty
};

/// A whole emulated robot and its server at this machine: plant, robot, its end of UDP,
/// connections.
///
///     construct -> { Begin -> Serve | Start } -> End
///
/// Threads: one, which may wait; the robot has one of its own from Begin() on, connections one from
/// Start() on.
class ServedRobot {
 public:
  /// Listens from now on; clients wait.
  /// @param plant  the robot's body: robot::MakePlant(config), or another.
  /// @throws InputError naming the field that is out of range; EnvironmentError when a port cannot
  /// be opened.
  ServedRobot(const robot::RobotConfig& config, robot::MadePlant plant,
              ServedRobotSettings settings);
  ~ServedRobot();
  ServedRobot(const ServedRobot&) = delete;
  ServedRobot& operator=(const ServedRobot&) = delete;

  [[nodiscard]] fci::Endpoint arm() const;
  /// Absent: no hand is mounted.
  [[nodiscard]] std::optional<fci::Endpoint> hand() const;
  /// Which body the robot has, for people.
  [[nodiscard]] const std::string& plant_name() const noexcept;
  /// Null for the ideal plant. Between Begin() and End() only from RecordSink::Put of a cycle's
  /// record, which is called on the plant's thread.
  [[nodiscard]] const plant::TruthProbe* truth() const noexcept;

  /// The robot's time begins, once. @throws InputError as rt::SetUpThisThread.
  void Begin();
  /// What its thread was not permitted, a line each. @pre after Begin().
  [[nodiscard]] const std::vector<std::string>& notices() const;
  /// Serves on this thread until `ends` says so, which is asked at least every 100 ms.
  void Serve(const std::function<bool()>& ends);
  /// Begin(), and Serve() on a thread of its own until End().
  void Start();

  /// Presses the robot's user stop, or lets it go. Threads: any, between Begin() and End().
  /// @throws RobotFault as robot::ThreadedRobot's requests.
  void PressUserStop(bool pressed);

  /// Ends connections and robot; no record is put after it returns. More than once: no effect.
  void End();

  // What follows: after End().

  /// What the simulation itself complained of, for people; empty: nothing.
  [[nodiscard]] std::string DescribeWarnings() const;
  /// Of a robot on the wall clock: begin of a cycle after its deadline, and whole periods that the
  /// host did not give. @pre it is one.
  [[nodiscard]] const rt::DurationHistogram& lateness() const;
  [[nodiscard]] std::uint64_t overruns() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::server
