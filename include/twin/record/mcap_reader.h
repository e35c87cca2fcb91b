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

/// A file within the file.
struct McapAttachment {
  std::string name;
  std::string media_type;
  std::string data;
};

/// Reads MCAP files front to back, whole ones and those whose writer was killed. Source:
/// https://mcap.dev/spec. Chunks are zstd or uncompressed; messages outside of chunks, which MCAP
/// also allows, are refused.
///
/// A file without its closing magic is one whose writer was killed: all complete chunks are read,
/// then truncated() is true. In any other file every length, CRC, count and reference must be
/// right. Memory: one record and one chunk, each capped; bytes are checked by their CRC before they
/// are used.
///
/// Threads: one thread. Real-time: no. Errors: InputError with the offset when the bytes are not
/// acceptable; EnvironmentError when the file cannot be read.
class McapReader {
 public:
  /// Longest record accepted, and longest chunk when decompressed, in bytes.
  static constexpr std::uint64_t kMaxRecordBytes = std::uint64_t{64} << 20;
  /// Most channels, and most schemas, accepted.
  static constexpr std::size_t kMaxChannels = 1024;

  /// Opens a file and reads on to its first chunk.
  explicit McapReader(const std::filesystem::path& path);
  /// The same on bytes in memory, which must outlive the reader. @param name  for error texts.
  McapReader(std::span<const std::byte> bytes, std::string name);
  ~McapReader();

  /// @returns the next message in the order of the file; nothing at its end.
  std::optional<McapMessage> Next();

  /// Metadata records met so far, by name; the last of a name counts.
  [[nodiscard]] const std::map<std::string, std::map<std::string, std::string>>& metadata() const;
  /// Attachments met so far.
  [[nodiscard]] const std::vector<McapAttachment>& attachments() const;
  /// Messages given out so far.
  [[nodiscard]] std::uint64_t message_count() const;
  /// Whether the writer never finished the file. Known from the start.
  [[nodiscard]] bool truncated() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::record
