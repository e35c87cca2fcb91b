#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace twin::record {

/// A stream of messages in an MCAP file.
struct McapChannel {
  std::string topic;
  std::string message_encoding;
  std::string schema_name;      ///< empty: no schema
  std::string schema_encoding;  ///< empty: no schema

  bool operator==(const McapChannel&) const = default;
};

/// One message. Valid until the reader's next call.
struct McapMessage {
  const McapChannel* channel = nullptr;
  std::uint32_t sequence = 0;
  std::uint64_t log_time_ns = 0;
  std::span<const std::byte> data;
};

/// A file embedded in the MCAP file.
struct McapAttachment {
  std::string name;
  std::string media_type;
  std::string data;
};

/// Reads MCAP files front to back, complete or from a killed writer. Source: https://mcap.dev/spec.
/// Chunks are zstd or uncompressed; messages outside chunks, which MCAP permits, are refused.
///
/// A file without closing magic has a killed writer: all complete chunks are read, then truncated()
/// is true. In any other file every length, CRC, count and reference must be right. Memory: one
/// record and one chunk, each bounded; bytes pass their CRC before use.
///
/// Threads: one thread. Real-time: no. Errors: InputError with the offset for invalid bytes;
/// EnvironmentError if the file cannot be read.
class McapReader {
 public:
  /// Largest accepted record, and largest chunk after decompression, bytes.
  static constexpr std::uint64_t kMaxRecordBytes = std::uint64_t{64} << 20;
  /// Largest accepted number of channels, and of schemas.
  static constexpr std::size_t kMaxChannels = 1024;

  /// Opens a file and reads up to its first chunk.
  explicit McapReader(const std::filesystem::path& path);
  /// Reads bytes in memory, which must outlive the reader. @param name  for error messages.
  McapReader(std::span<const std::byte> bytes, std::string name);
  ~McapReader();

  /// @returns the next message in file order; nullopt at the end.
  std::optional<McapMessage> Next();

  /// Metadata records read so far, by name; the last one of a name counts.
  [[nodiscard]] const std::map<std::string, std::map<std::string, std::string>>& metadata() const;
  /// Attachments read so far.
  [[nodiscard]] const std::vector<McapAttachment>& attachments() const;
  /// Messages returned so far.
  [[nodiscard]] std::uint64_t message_count() const;
  /// True if the writer did not finish the file; available at once.
  [[nodiscard]] bool truncated() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::record
