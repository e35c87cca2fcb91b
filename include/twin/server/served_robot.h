#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "twin/fci/sockets.h"
#include "twin/record/cycle_record.h"
#include "twin/robot/answer_paced_robot.h"
#include "twin/robot/robot_config.h"
#include "twin/rt/duration_histogram.h"
#include "twin/rt/thread_setup.h"
#include "twin/server/request_handler.h"
#include "twin/server/server.h"

namespace twin::plant {
class TruthProbe;
}  // namespace twin::plant

namespace twin::server {

/// Configuration of a served robot. Every pointer must outlive the ServedRobot that gets it.
struct ServedRobotSettings {
  /// Addresses, permitted clients and capture. The capture records datagrams as well as TCP.
  ServerConfig server{};
  /// Whether the arm listens at a free port and the hand at the next one, where clients that know
  /// only the arm's port look for it; `server`'s ports are then ignored.
  bool takes_free_ports = false;
  /// Lockstep with the client; absent: the wall clock.
  std::optional<robot::LockstepOptions> lockstep{};
  /// The robot's thread. Absent: real-time priority on the wall clock, normal priority in lockstep.
  std::optional<rt::ThreadSettings> thread{};
  /// Receives INT's cycle records on the robot's thread; may be null.
  record::RecordSink* sink = nullptr;
  /// Receives a line per connection, motion and refusal (request_handler.h); may be empty.
  TellPeople tell{};
};

/// An emulated robot and its server on this machine: plant, robot, UDP port and connections.
///
///     construct -> { Begin -> Serve | Start } -> End
///
/// Threads: one, which may block. The robot has its own thread after Begin(), connections have one
/// after Start().
class ServedRobot {
 public:
  /// Opens the ports; clients wait until Serve() or Start().
  /// @param plant  the robot's body: robot::MakePlant(config), or another.
  /// @throws InputError naming a field out of range; EnvironmentError if a port cannot be opened.
  ServedRobot(const robot::RobotConfig& config, robot::MadePlant plant,
              ServedRobotSettings settings);
  ~ServedRobot();
  ServedRobot(const ServedRobot&) = delete;
  ServedRobot& operator=(const ServedRobot&) = delete;

  [[nodiscard]] fci::Endpoint arm() const;
  /// nullopt without a hand.
  [[nodiscard]] std::optional<fci::Endpoint> hand() const;
  /// Name of the plant, for users.
  [[nodiscard]] const std::string& plant_name() const noexcept;
  /// Null for the ideal plant. Between Begin() and End(), use it only in RecordSink::Put of a
  /// cycle's record, which runs on the plant's thread.
  [[nodiscard]] const plant::TruthProbe* truth() const noexcept;

  /// Starts the robot's time, once. @throws InputError as rt::SetUpThisThread.
  void Begin();
  /// Permissions that its thread did not get, one line each. @pre after Begin().
  [[nodiscard]] const std::vector<std::string>& notices() const;
  /// Serves on this thread until `ends` returns true; calls it at least every 100 ms.
  void Serve(const std::function<bool()>& ends);
  /// Calls Begin(), then Serve() on a new thread until End().
  void Start();

  /// For requests beside those of clients, as a person's at the robot. Threads: any, between
  /// Begin() and End().
  [[nodiscard]] robot::ThreadedRobot& robot() noexcept;
  /// The same where it runs in lockstep; null on the wall clock.
  [[nodiscard]] robot::AnswerPacedRobot* lockstep() noexcept;
  /// Puts the scene's free body `name` at rest at X_WB, of its frame in the world, between two
  /// cycles. Threads: any, between Begin() and End().
  /// @throws InputError, without any effect, for a name that no free body has (listing those there
  /// are), and where it would lie deeper than plant::Plant::kMostOverlap in another body.
  void Place(const std::string& name, const Transform& X_WB);
  /// @throws InputError if the arm, put to `q` by a reset, would lie deeper than
  /// plant::Plant::kMostOverlap in a body, or in itself. Positions beyond the joints' ranges pass:
  /// a reset refuses them. Threads: any.
  void RequireFree(const JointVector& q) const;
  /// Presses or releases the robot's user stop. Threads: any, between Begin() and End().
  /// @throws RobotFault as robot::ThreadedRobot's requests.
  void PressUserStop(bool pressed);

  /// Ends what Start() began but the robot's time: for robots that share a thread, which stops with
  /// the first that ends. Without Start() it does nothing.
  void StopServing();
  /// Closes connections and stops the robot; after return no record is put. Idempotent.
  void End();

  // Only after End():

  /// The simulation's warnings, for users; empty if there are none.
  [[nodiscard]] std::string DescribeWarnings() const;
  /// Lateness of cycle starts, and whole periods skipped. @pre the robot runs on the wall clock.
  [[nodiscard]] const rt::DurationHistogram& lateness() const;
  [[nodiscard]] std::uint64_t overruns() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::server
