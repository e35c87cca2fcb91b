#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace twin::record::mcap {

static_assert(std::endian::native == std::endian::little, "MCAP is little-endian, and so are we");

/// Record types. Source: MCAP format specification, https://mcap.dev/spec.
enum class Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

/// First and last bytes of a file: 0x89 "MCAP0" CR LF.
inline constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);

/// Bytes of a record before its content: opcode and 64-bit length.
inline constexpr std::size_t kRecordHeaderBytes = 9;

using Bytes = std::vector<std::byte>;
using TextMap = std::map<std::string, std::string>;

/// CRC-32 (IEEE 802.3, reflected), continued from `crc` over `bytes`; initial `crc` 0.
[[nodiscard]] std::uint32_t Crc32(std::uint32_t crc, std::span<const std::byte> bytes);

/// The bytes of a text.
[[nodiscard]] std::span<const std::byte> AsBytes(std::string_view text);

/// Appends raw bytes.
void PutBytes(Bytes& out, std::span<const std::byte> bytes);

/// Appends an integer.
template <typename Integer>
void Put(Bytes& out, Integer value) {
  PutBytes(out, std::as_bytes(std::span(&value, 1)));
}

/// Appends a text, or bytes, with a 32-bit length prefix.
void PutString(Bytes& out, std::string_view text);

/// Appends a map of texts.
void PutMap(Bytes& out, const TextMap& map);

/// Begins a record; its length is set by EndRecord. @returns its offset in `out`.
[[nodiscard]] std::size_t BeginRecord(Bytes& out, Opcode opcode);

/// Ends the record that began at `begin`.
void EndRecord(Bytes& out, std::size_t begin);

/// Begins an array or map with a 32-bit byte length prefix. @returns its offset in `out`.
[[nodiscard]] std::size_t BeginArray(Bytes& out);

/// Ends the array that began at `begin`.
void EndArray(Bytes& out, std::size_t begin);

}  // namespace twin::record::mcap
