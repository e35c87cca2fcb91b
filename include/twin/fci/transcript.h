#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "twin/fci/protocol.h"
#include "twin/record/packet.h"

namespace twin::fci {

/// How a transcript is written.
struct TranscriptOptions {
  bool fields = true;  ///< every field of every message, not a line each
  std::uint16_t arm_port = kArmPort;
  std::uint16_t hand_port = kHandPort;
};

/// What a capture says, message by message, for people: states, commands, requests and their
/// answers, arm and hand. TCP streams are put together from their packets, answers are named by the
/// requests they answer. What is none of the protocol is told as such.
///
///     12.345678901 s  127.0.0.1:40000 > 127.0.0.1:1337  request 7: Move
///         modes = joint_impedance joint_position
///
/// What it keeps is bounded, whatever the packets say.
///
/// Threads: one. Errors: none; untrusted bytes end in a line that says what is wrong with them.
class Transcript {
 public:
  explicit Transcript(const TranscriptOptions& options);
  ~Transcript();

  /// @returns the lines this packet completes, each ended; empty when it completes none.
  [[nodiscard]] std::string Take(const record::Packet& packet);

  /// Packets of TCP so far between other ports than those of the options.
  [[nodiscard]] std::uint64_t elsewhere() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::fci
