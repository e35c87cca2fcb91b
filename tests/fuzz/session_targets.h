#pragma once

#include <cstddef>

#include "fuzz/fci_targets.h"

// Whole sessions as targets: a client's stream of bytes in whatever segments, a robot that changes
// in between, and the session that has to answer. Still without sockets, threads and time.
//
// The bytes are a script, a step after the other:
//
//     b < 0xC0    a segment: the next b + 1 bytes (or as many as there are) come over TCP
//     b >= 0xC0   b - 0xC0 says what the robot, or the hand, does now (modulo what there is)
//
// When the script is over, or the session has asked for the connection's end, the client is gone.
namespace twin::fci::fuzz {

/// What was said in a session, for tests of the targets themselves.
struct SessionTally {
  std::size_t requests = 0;  ///< frames the session was given
  std::size_t answers = 0;
  bool ended = false;  ///< the session asked for the connection's end
  bool operator==(const SessionTally&) const = default;
};

/// What the arm does beside a session. Its modes follow from each other as INT's do.
enum class ArmEvent : unsigned char {
  kMotionFinishes,
  kMotionIsAborted,  ///< Reflex, and the arm still comes to rest
  kMotionIsStopped,  ///< as asked, or because it was not answered
  kComesToRest,
  kRecovers,
  kUserStops,  ///< the user stop is pressed
  kUserLets,   ///< and released
};
inline constexpr unsigned kArmEvents = 7;

/// @post Every answer is a whole frame and answers a request that waits; a request is answered
/// once, a motion that starts twice; StopMove before the Move it ends; nothing before Connect and
/// after the end. What waits is bounded, and has_pending() tells it. Once the robot is at rest and
/// Idle nothing waits any more; when the client goes a motion that runs is stopped.
SessionTally RunArmSession(Bytes script);

/// What the hand does: what it was asked for ends with HandResult `event`.
inline constexpr unsigned kHandEvents = 4;

/// @post As above, with one command at most that waits.
SessionTally RunHandSession(Bytes script);

}  // namespace twin::fci::fuzz
