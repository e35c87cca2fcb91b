#include "twin/record/pcapng_reader.h"

#include <array>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "record/ip_packets.h"
#include "record/mcap_source.h"
#include "record/pcapng_format.h"
#include "twin/core/error.h"

namespace twin::record {
namespace {

/// A block's type and length; the length is repeated at its end.
constexpr std::size_t kBlockHead = 8;
constexpr std::size_t kBlockFrame = 12;
/// Largest accepted block: the largest packet with its headers, and room for comments.
constexpr std::size_t kLargestBlock = std::size_t{512} * 1024;
constexpr std::size_t kLargestPacket = std::size_t{256} * 1024;
constexpr std::size_t kMostInterfaces = 64;

template <typename Integer>
Integer Load(std::span<const std::byte> bytes, std::size_t at) {
  Integer value{};
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

struct Interface {
  std::uint16_t link = 0;
  std::uint64_t ns_per_tick = 1000;  ///< microseconds by default
};

/// True if this is the magic of the older format pcap, in either byte order.
bool IsClassic(std::uint32_t magic) {
  const std::uint32_t other = __builtin_bswap32(magic);
  return magic == pcapng::kClassicMicroseconds || magic == pcapng::kClassicNanoseconds ||
         other == pcapng::kClassicMicroseconds || other == pcapng::kClassicNanoseconds;
}

/// Offset of the IPv4 header in a packet of this link type; nullopt if there is none.
std::optional<std::size_t> IpOffset(std::uint16_t link, std::span<const std::byte> packet) {
  const auto ethertype_at = [&](std::size_t at) {
    return packet.size() >= at + 2 && packet[at] == std::byte{0x08} &&
           packet[at + 1] == std::byte{0};
  };
  switch (link) {
    case pcapng::kLinkIpv4:
    case pcapng::kLinkRaw: return 0;
    case pcapng::kLinkEthernet:
      return ethertype_at(12) ? std::optional<std::size_t>(14) : std::nullopt;
    case pcapng::kLinkLinuxCooked:
      return ethertype_at(14) ? std::optional<std::size_t>(16) : std::nullopt;
    default: return std::nullopt;
  }
}

}  // namespace

class PcapngReader::Impl {
 public:
  explicit Impl(const std::filesystem::path& path)
      : where_(path.string()), source_(mcap::OpenFile(path)) {
    ReadSectionHeader();
  }
  explicit Impl(std::vector<std::byte> file)
      : where_("memory"), memory_(std::move(file)), source_(mcap::OpenMemory(memory_)) {
    ReadSectionHeader();
  }

  std::optional<Packet> Next() {
    while (true) {
      const auto kind = ReadBlock();
      if (!kind) return std::nullopt;
      switch (*kind) {
        case pcapng::kSectionHeader: ReadSection(); break;
        case pcapng::kInterfaceDescription: ReadInterface(); break;
        case pcapng::kEnhancedPacket:
          if (const auto packet = ReadPacket()) return packet;
          break;
        default: break;  // statistics, names: not needed
      }
    }
  }

  [[nodiscard]] std::uint64_t passed_over() const { return passed_over_ + ip_.passed_over(); }
  [[nodiscard]] bool truncated() const { return truncated_; }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    throw InputError(
        fmt::format("{}: damaged at byte {}: {}; capture it again", where_, block_at_, what));
  }

  void ReadSectionHeader() {
    std::array<std::byte, 12> head{};
    const bool whole = source_->ReadAt(0, head) == head.size();
    if (whole && IsClassic(Load<std::uint32_t>(head, 0))) {
      throw InputError(
          fmt::format("{0}: a classic pcap file, as tcpdump -w writes it, not pcapng; "
                      "convert it: editcap -F pcapng {0} {0}ng",
                      where_));
    }
    if (!whole || Load<std::uint32_t>(head, 0) != pcapng::kSectionHeader) {
      throw InputError(
          where_ +
          ": no pcapng file; decode reads what --capture and Wireshark write, and what "
          "tcpdump wrote once editcap -F pcapng IN OUT has converted it");
    }
    if (Load<std::uint32_t>(head, 8) != pcapng::kByteOrderMagic) {
      throw InputError(where_ + ": written on a big-endian machine, which is not supported");
    }
  }

  /// Reads the next block's body into block_. @returns its type; nullopt at the end.
  std::optional<std::uint32_t> ReadBlock() {
    block_at_ = next_;
    std::array<std::byte, kBlockHead> head{};
    const std::size_t got = source_->ReadAt(next_, head);
    if (got < head.size()) {
      truncated_ = truncated_ || got > 0;
      return std::nullopt;
    }
    const auto length = Load<std::uint32_t>(head, 4);
    if (length < kBlockFrame || length % 4 != 0) {
      Fail(fmt::format("a block of {} bytes", length));
    }
    if (length > kLargestBlock) {
      Fail(fmt::format("a block of {} bytes, more than {}", length, kLargestBlock));
    }
    block_.resize(length - kBlockFrame);
    if (next_ + length > source_->size() ||
        source_->ReadAt(next_ + kBlockHead, block_) < block_.size()) {
      truncated_ = true;
      return std::nullopt;
    }
    next_ += length;
    return Load<std::uint32_t>(head, 0);
  }

  void ReadSection() {
    if (block_.size() < 16) Fail("a section's head that is too short");
    if (Load<std::uint32_t>(block_, 0) != pcapng::kByteOrderMagic) {
      Fail("a section of another byte order");
    }
    interfaces_.clear();
  }

  void ReadInterface() {
    if (block_.size() < 8) Fail("an interface's description that is too short");
    if (interfaces_.size() == kMostInterfaces) Fail("too many interfaces");
    Interface interface { .link = Load<std::uint16_t>(block_, 0) };
    for (std::size_t at = 8; at + 4 <= block_.size();) {
      const auto code = Load<std::uint16_t>(block_, at);
      const auto length = Load<std::uint16_t>(block_, at + 2);
      if (code == pcapng::kOptionEnd) break;
      if (code == pcapng::kOptionTimeResolution && length == 1 && at + 5 <= block_.size()) {
        interface.ns_per_tick = NsPerTick(std::to_integer<unsigned>(block_[at + 4]));
      }
      at += 4 + (std::size_t{length} + 3) / 4 * 4;
    }
    interfaces_.push_back(interface);
  }

  [[nodiscard]] std::uint64_t NsPerTick(unsigned resolution) const {
    if (resolution > 9) {
      Fail("a time resolution other than a power of ten from 1 s to 1 ns");
    }
    std::uint64_t ns = 1'000'000'000;
    for (unsigned i = 0; i < resolution; ++i) ns /= 10;
    return ns;
  }

  std::optional<Packet> ReadPacket() {
    constexpr std::size_t kHead = 20;
    if (block_.size() < kHead) Fail("a packet's head that is too short");
    const auto interface = Load<std::uint32_t>(block_, 0);
    const auto length = Load<std::uint32_t>(block_, 12);
    if (interface >= interfaces_.size()) Fail("a packet of an interface that was not described");
    if (length > block_.size() - kHead) Fail("a packet longer than its block");
    if (length > kLargestPacket) Fail("a packet that is too long");
    const std::uint64_t ticks =
        (std::uint64_t{Load<std::uint32_t>(block_, 4)} << 32) | Load<std::uint32_t>(block_, 8);
    const Time at{Duration(static_cast<std::int64_t>(ticks * interfaces_[interface].ns_per_tick &
                                                     0x7fffffffffffffff))};
    const auto packet = std::span<const std::byte>(block_).subspan(kHead, length);
    const auto offset = IpOffset(interfaces_[interface].link, packet);
    if (!offset || *offset > packet.size()) {
      ++passed_over_;
      return std::nullopt;
    }
    return ip_.Take(at, packet.subspan(*offset));
  }

  std::string where_;
  std::vector<std::byte> memory_;
  std::unique_ptr<mcap::Source> source_;
  std::uint64_t next_ = 0;
  std::uint64_t block_at_ = 0;
  std::vector<std::byte> block_;
  std::vector<Interface> interfaces_;
  IpPackets ip_;
  std::uint64_t passed_over_ = 0;
  bool truncated_ = false;
};

PcapngReader::PcapngReader(const std::filesystem::path& path)
    : impl_(std::make_unique<Impl>(path)) {}
PcapngReader::PcapngReader(std::vector<std::byte> file)
    : impl_(std::make_unique<Impl>(std::move(file))) {}
PcapngReader::~PcapngReader() = default;

std::optional<Packet> PcapngReader::Next() {
  return impl_->Next();
}

std::uint64_t PcapngReader::passed_over() const noexcept {
  return impl_->passed_over();
}

bool PcapngReader::truncated() const noexcept {
  return impl_->truncated();
}

}  // namespace twin::record
