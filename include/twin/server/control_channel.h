#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "twin/robot/answer_paced_robot.h"
#include "twin/robot/threaded_robot.h"
#include "twin/server/control_request.h"
#include "twin/server/request_handler.h"

namespace twin::server {

/// Lets programs on this machine control a served robot beside its clients: a Unix socket that only
/// this user can open, a request per line (ParseControlRequest), an answer per request, in order.
///
///     {"ok": true, "cycle": 1200, "mode": "Idle", ...}   the robot after the request
///     {"ok": false, "error": "..."}                      why it was refused
///
/// docs/reference/control-channel.md has all members.
///
/// A step is answered when its cycles have run; in a motion that takes the client's answers. Bytes
/// that are no request end the connection after their answer, as does a line of more than 4096
/// bytes; so what a browser or another stray program sends has no effect. Up to 8 connections; a
/// ninth gets a refusal and ends.
///
/// Threads: one; it has one of its own.
class ControlChannel {
 public:
  /// What a channel controls; all of it must outlive the channel.
  struct Controlled {
    robot::ThreadedRobot& robot;
    /// The same robot in lockstep; null on the wall clock, where time cannot be paused.
    robot::AnswerPacedRobot* lockstep = nullptr;
    /// Puts an object of the scene somewhere, as ServedRobot::Place().
    std::function<void(const std::string& name, const Transform& X_WB)> place;
    /// Refuses joint positions at which the arm overlaps, as ServedRobot::RequireFree(); may be
    /// empty.
    std::function<void(const JointVector& q)> require_free;
    bool may_reset = false;  ///< whether a request may reset the robot
  };

  /// Creates the socket; a socket of a server that has ended is replaced.
  /// @param tell   gets a line per request that changed something, on the channel's thread.
  /// @throws InputError when the path is too long or names another file; EnvironmentError when
  /// another server uses it, or it cannot be created.
  ControlChannel(const std::filesystem::path& path, const Controlled& controlled, TellPeople tell);
  /// Closes all connections and removes the socket.
  ~ControlChannel();
  ControlChannel(const ControlChannel&) = delete;
  ControlChannel& operator=(const ControlChannel&) = delete;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Sends one request to a channel and waits for the answer. @returns its line.
/// @throws EnvironmentError when no server has a channel there, or it ends before it answers.
[[nodiscard]] std::string AskControl(const std::filesystem::path& path,
                                     const ControlRequest& request);

}  // namespace twin::server
