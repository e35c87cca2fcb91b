#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "twin/record/packet.h"

namespace twin::record {

/// Writes packets into a pcapng file for Wireshark and tcpdump: raw IPv4, nanoseconds. Adds the
/// headers of a network (IPv4, UDP or TCP with running sequence numbers), with checksums where
/// required. Source: IETF draft-ietf-opsawg-pcapng; RFC 791, 768, 9293.
///
/// Packets are never fragmented, as on loopback; TCP data above 16 KiB becomes several segments.
/// The same calls give the same bytes.
///
/// Threads: one. Real-time: no. Errors: EnvironmentError if the file cannot be created or written.
class PcapngWriter {
 public:
  /// Creates `<path>.partial`.
  explicit PcapngWriter(const std::filesystem::path& path);
  /// Leaves `<path>.partial`, which is readable, if Finish() was not called.
  ~PcapngWriter();
  PcapngWriter(const PcapngWriter&) = delete;
  PcapngWriter& operator=(const PcapngWriter&) = delete;

  /// @pre a datagram has at most 65507 bytes.
  void Add(const Packet& packet);

  /// Writes the buffered data and renames the file to its final name. Call once.
  void Finish();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::record
