#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "twin/record/packet.h"

namespace twin::record {

/// Writes packets into a pcapng file, as Wireshark and tcpdump open it: raw IPv4, nanoseconds, with
/// the heads a network would have put before the bytes (IPv4, UDP or TCP with running sequence
/// numbers), and checksums where they are needed. Source: IETF draft-ietf-opsawg-pcapng; RFC 791,
/// 768, 9293.
///
/// A packet's bytes are never fragmented, as on the loopback; what is longer than 16 KiB of a TCP
/// stream becomes several segments. The same calls give the same bytes.
///
/// Threads: one. Real-time: no. Errors: EnvironmentError when the file cannot be made or written.
class PcapngWriter {
 public:
  /// Creates `<path>.partial`.
  explicit PcapngWriter(const std::filesystem::path& path);
  /// Without Finish(): leaves `<path>.partial`, which is readable.
  ~PcapngWriter();
  PcapngWriter(const PcapngWriter&) = delete;
  PcapngWriter& operator=(const PcapngWriter&) = delete;

  /// @pre a datagram has at most 65507 bytes.
  void Add(const Packet& packet);

  /// Writes what is buffered, and gives the file its name. Call once.
  void Finish();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::record
