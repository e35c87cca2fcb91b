#include "twin/record/pcapng_writer.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "record/pcapng_format.h"
#include "twin/core/error.h"
#include "twin/record/partial_file.h"

namespace twin::record {
namespace {

/// First word of a section header, and so of any pcapng file.
constexpr std::array<std::uint32_t, 1> kMagic{pcapng::kSectionHeader};

/// Largest piece of a TCP stream in one packet, bytes.
constexpr std::size_t kSegmentBytes = std::size_t{16} * 1024;

/// Bytes written to the file at once.
constexpr std::size_t kBufferBytes = std::size_t{256} * 1024;

/// Largest datagram in IPv4, bytes.
constexpr std::size_t kLargestDatagram = 65507;

class BlockBytes {
 public:
  /// Blocks are in the byte order of the magic: little-endian.
  void Little16(std::uint16_t x) { Put(x, 2, false); }
  void Little32(std::uint32_t x) { Put(x, 4, false); }
  /// Network headers are big-endian.
  void Big16(std::uint16_t x) { Put(x, 2, true); }
  void Big32(std::uint32_t x) { Put(x, 4, true); }
  void Byte(std::uint8_t x) { bytes_.push_back(std::byte{x}); }
  void Append(std::span<const std::byte> more) {
    bytes_.insert(bytes_.end(), more.begin(), more.end());
  }
  void Pad() { bytes_.resize((bytes_.size() + 3) / 4 * 4); }
  void Overwrite(std::size_t at, std::uint16_t big) {
    bytes_[at] = std::byte(big >> 8);
    bytes_[at + 1] = std::byte(big & 0xff);
  }
  [[nodiscard]] std::span<const std::byte> view() const { return bytes_; }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  void Clear() { bytes_.clear(); }

 private:
  void Put(std::uint32_t x, int count, bool big) {
    for (int i = 0; i < count; ++i) {
      const int shift = 8 * (big ? count - 1 - i : i);
      bytes_.push_back(std::byte((x >> shift) & 0xff));
    }
  }
  std::vector<std::byte> bytes_;
};

/// Internet checksum, RFC 1071.
class Checksum {
 public:
  void Add(std::span<const std::byte> bytes) {
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      sum_ += std::to_integer<std::uint32_t>(bytes[i]) << (i % 2 == 0 ? 8 : 0);
    }
  }
  void Add(std::uint32_t word) { sum_ += word; }
  [[nodiscard]] std::uint16_t value() const {
    std::uint64_t sum = sum_;
    while (sum >> 16 != 0) sum = (sum & 0xffff) + (sum >> 16);
    return static_cast<std::uint16_t>(~sum);
  }

 private:
  std::uint64_t sum_ = 0;
};

}  // namespace

class PcapngWriter::Impl {
 public:
  explicit Impl(const std::filesystem::path& path)
      : file_(path, PartialFile::Leftover::kKeep,
              {.name = "a pcapng capture", .magic = std::as_bytes(std::span(kMagic))}) {
    Begin(pcapng::kSectionHeader);
    out_.Little32(pcapng::kByteOrderMagic);
    out_.Little16(1);  // version 1.0
    out_.Little16(0);
    out_.Little32(0xffffffff);  // section length: unspecified
    out_.Little32(0xffffffff);
    End();
    Begin(pcapng::kInterfaceDescription);
    out_.Little16(pcapng::kLinkIpv4);
    out_.Little16(0);
    out_.Little32(0);  // packets are not truncated
    out_.Little16(pcapng::kOptionTimeResolution);
    out_.Little16(1);
    out_.Byte(9);  // 1e-9 s
    out_.Pad();
    out_.Little32(pcapng::kOptionEnd);
    End();
  }

  void Add(const Packet& packet) {
    if (packet.transport == Transport::kUdp) {
      TWIN_CHECK(packet.bytes.size() <= kLargestDatagram);
      AddOne(packet, packet.bytes);
      return;
    }
    for (std::size_t at = 0; at < packet.bytes.size(); at += kSegmentBytes) {
      AddOne(packet, packet.bytes.subspan(at, std::min(kSegmentBytes, packet.bytes.size() - at)));
    }
  }

  void Flush() {
    file_.Write(out_.view());
    out_.Clear();
  }

  void Finish() {
    Flush();
    file_.Commit();
  }

 private:
  void Begin(std::uint32_t kind) {
    block_ = BlockBytes();
    std::swap(block_, out_);
    kind_ = kind;
  }
  /// Completes the block with the bytes in out_ since Begin() as its body.
  void End() {
    std::swap(block_, out_);
    const auto length = static_cast<std::uint32_t>(block_.size() + 12);
    out_.Little32(kind_);
    out_.Little32(length);
    out_.Append(block_.view());
    out_.Little32(length);
    if (out_.size() >= kBufferBytes) Flush();
  }

  void AddOne(const Packet& packet, std::span<const std::byte> bytes) {
    const bool tcp = packet.transport == Transport::kTcp;
    const std::size_t heads = pcapng::kIpBytes + (tcp ? pcapng::kTcpBytes : pcapng::kUdpBytes);
    const auto length = static_cast<std::uint32_t>(heads + bytes.size());
    const auto ns = static_cast<std::uint64_t>(packet.at.time_since_epoch().count());
    Begin(pcapng::kEnhancedPacket);
    out_.Little32(0);  // interface
    out_.Little32(static_cast<std::uint32_t>(ns >> 32));
    out_.Little32(static_cast<std::uint32_t>(ns));
    out_.Little32(length);
    out_.Little32(length);
    AddIpHead(packet, static_cast<std::uint16_t>(length));
    if (tcp) {
      AddTcpHead(packet, bytes);
    } else {
      AddUdpHead(packet, bytes.size());
    }
    out_.Append(bytes);
    out_.Pad();
    End();
  }

  void AddIpHead(const Packet& packet, std::uint16_t length) {
    const std::size_t begin = out_.size();
    out_.Byte(0x45);  // version 4, five words
    out_.Byte(0);
    out_.Big16(length);
    out_.Big16(identification_++);
    out_.Big16(0x4000);  // do not fragment
    out_.Byte(64);       // time to live
    out_.Byte(packet.transport == Transport::kTcp ? pcapng::kTcp : pcapng::kUdp);
    out_.Big16(0);
    out_.Big32(packet.from.address);
    out_.Big32(packet.to.address);
    Checksum sum;
    sum.Add(out_.view().subspan(begin));
    out_.Overwrite(begin + 10, sum.value());
  }

  void AddUdpHead(const Packet& packet, std::size_t bytes) {
    out_.Big16(packet.from.port);
    out_.Big16(packet.to.port);
    out_.Big16(static_cast<std::uint16_t>(pcapng::kUdpBytes + bytes));
    out_.Big16(0);  // no checksum
  }

  void AddTcpHead(const Packet& packet, std::span<const std::byte> bytes) {
    std::uint32_t& sent = sent_[{packet.from, packet.to}];
    const std::size_t begin = out_.size();
    out_.Big16(packet.from.port);
    out_.Big16(packet.to.port);
    out_.Big32(sent + 1);
    out_.Big32(sent_[{packet.to, packet.from}] + 1);
    out_.Big16(0x5018);  // five words; PSH, ACK
    out_.Big16(0xffff);  // window
    out_.Big16(0);
    out_.Big16(0);
    sent += static_cast<std::uint32_t>(bytes.size());
    Checksum sum;
    sum.Add(packet.from.address >> 16);
    sum.Add(packet.from.address & 0xffff);
    sum.Add(packet.to.address >> 16);
    sum.Add(packet.to.address & 0xffff);
    sum.Add(pcapng::kTcp);
    sum.Add(static_cast<std::uint32_t>(pcapng::kTcpBytes + bytes.size()));
    sum.Add(out_.view().subspan(begin));
    sum.Add(bytes);
    out_.Overwrite(begin + 16, sum.value());
  }

  PartialFile file_;
  BlockBytes out_;
  BlockBytes block_;
  std::uint32_t kind_ = 0;
  std::uint16_t identification_ = 0;
  std::map<std::pair<PacketEnd, PacketEnd>, std::uint32_t> sent_;
};

PcapngWriter::PcapngWriter(const std::filesystem::path& path)
    : impl_(std::make_unique<Impl>(path)) {}

PcapngWriter::~PcapngWriter() {
  if (impl_ == nullptr) return;
  try {
    impl_->Flush();
  } catch (const std::exception&) {
    // The file keeps the name .partial, which marks it as incomplete.
  }
}

void PcapngWriter::Add(const Packet& packet) {
  impl_->Add(packet);
}

void PcapngWriter::Finish() {
  const std::unique_ptr<Impl> impl = std::move(impl_);
  impl->Finish();
}

}  // namespace twin::record
