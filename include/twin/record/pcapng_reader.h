#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "twin/record/packet.h"

namespace twin::record {

/// Reads the UDP datagrams and the TCP bytes of a pcapng file: of PcapngWriter's, or of a capture
/// that Wireshark made on an Ethernet, loopback or raw IPv4 interface (fragmented datagrams, as a
/// state on a real network is, are put together). The older format pcap, as `tcpdump -w` writes it,
/// is refused by name: `editcap -F pcapng IN OUT` converts it. What is neither UDP nor TCP over
/// IPv4 is passed over and counted. TCP segments are given as captured, but for those repeated.
///
/// The file is not trusted: no length in it is believed without a look, no packet above 256 KiB is
/// taken.
///
/// Threads: one. Errors: InputError with file, offset and what is wrong with it.
class PcapngReader {
 public:
  /// @throws InputError when it is no pcapng file, EnvironmentError when it cannot be read.
  explicit PcapngReader(const std::filesystem::path& path);
  /// Reads from memory, as the constructor above.
  explicit PcapngReader(std::vector<std::byte> file);
  ~PcapngReader();

  /// The next packet; nothing at the end. Its bytes are valid until the next call.
  [[nodiscard]] std::optional<Packet> Next();

  /// Packets passed over so far.
  [[nodiscard]] std::uint64_t passed_over() const noexcept;
  /// Whether the file ends within a block: whoever wrote it was killed.
  [[nodiscard]] bool truncated() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::record
