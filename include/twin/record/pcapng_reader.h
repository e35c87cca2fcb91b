#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "twin/record/packet.h"

namespace twin::record {

/// Reads UDP datagrams and TCP bytes from a pcapng file of PcapngWriter, or of Wireshark on an
/// Ethernet, loopback or raw IPv4 interface. Reassembles fragmented datagrams, such as states on a
/// real network. Refuses the older format pcap of `tcpdump -w` by name: `editcap -F pcapng IN OUT`
/// converts it. Skips and counts packets other than UDP or TCP over IPv4. Returns TCP segments as
/// captured, without repeated ones.
///
/// The file is untrusted: every length in it is checked, and packets above 256 KiB are refused.
///
/// Threads: one. Errors: InputError with file, offset and fault.
class PcapngReader {
 public:
  /// @throws InputError if it is not a pcapng file, EnvironmentError if it cannot be read.
  explicit PcapngReader(const std::filesystem::path& path);
  /// Reads from memory; otherwise as above.
  explicit PcapngReader(std::vector<std::byte> file);
  ~PcapngReader();

  /// @returns the next packet, valid until the next call; nullopt at the end.
  [[nodiscard]] std::optional<Packet> Next();

  /// Packets skipped so far.
  [[nodiscard]] std::uint64_t passed_over() const noexcept;
  /// True if the file ends within a block: its writer was killed.
  [[nodiscard]] bool truncated() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::record
