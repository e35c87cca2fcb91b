#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace twin::record {

/// Options of an MCAP file.
struct McapWriterOptions {
  std::string library = "panda-twin";  ///< text of the header; must not name a machine or a time
  std::size_t chunk_bytes = std::size_t{512} * 1024;  ///< uncompressed size limit of a chunk
  int zstd_level = 1;                                 ///< compression of the chunks, 1 (fast) .. 19
  /// Sequence number of each channel's first message, by id; those that are missing are 0.
  std::vector<std::uint32_t> first_sequences{};
  bool is_synced = false;  ///< the finished file is on the disk (PartialFile::CommitSynced)
};

/// Contents of a finished file.
struct McapTotals {
  std::uint64_t messages = 0;
  std::uint64_t chunks = 0;
  std::uint64_t bytes = 0;  ///< length of the file
};

/// Writes an MCAP file: chunks of zstd with CRC-32, message, chunk, attachment and metadata
/// indexes, statistics, summary with its own CRC. Source: https://mcap.dev/spec.
///
///     magic Header  Schema.. Channel.. Metadata.. Attachment..  (Chunk MessageIndex..)..  DataEnd
///     summary: Schema.. Channel.. Statistics ChunkIndex.. AttachmentIndex.. MetadataIndex..
///     SummaryOffset.. Footer magic
///
/// The file is `<path>.partial` until Finish(). A chunk with its indexes is one write(2), and other
/// records are written at once, so a killed process loses at most the open chunk. The same calls
/// give the same bytes.
///
/// Threads: one thread. Real-time: no. Errors: EnvironmentError with path, cause and cure if the
/// file cannot be created or written; after an error only destruction is permitted.
class McapWriter {
 public:
  /// Creates `<path>.partial` and writes the header.
  explicit McapWriter(const std::filesystem::path& path, const McapWriterOptions& options = {});
  /// Leaves `<path>.partial`, without the open chunk, if Finish() was not called.
  ~McapWriter();

  /// @param encoding  "protobuf": `data` is a serialized FileDescriptorSet.
  /// @returns the schema's id.
  std::uint16_t AddSchema(std::string_view name, std::string_view encoding, std::string_view data);

  /// @returns the channel's id.
  std::uint16_t AddChannel(std::uint16_t schema, std::string_view topic,
                           std::string_view message_encoding);

  /// Texts must be UTF-8.
  void AddMetadata(std::string_view name, const std::map<std::string, std::string>& entries);

  /// @param log_time_ns  on the run's clock.
  void AddAttachment(std::string_view name, std::string_view media_type, std::string_view data,
                     std::uint64_t log_time_ns = 0);

  /// Adds a message of `size` bytes to the open chunk, or to a new one if that is full.
  /// @returns the buffer for its data, to be filled before the next call.
  std::span<std::byte> AddMessage(std::uint16_t channel, std::uint64_t log_time_ns,
                                  std::size_t size);

  /// Sequence number of each channel's next message, by id: where the next file of a log goes on.
  [[nodiscard]] std::vector<std::uint32_t> next_sequences() const;
  /// Length of the file without the open chunk.
  [[nodiscard]] std::uint64_t bytes() const noexcept;

  /// Writes the open chunk, unless it is empty.
  void Flush();

  /// Writes the remaining data, summary and footer, and renames the file to `path`. Call once.
  McapTotals Finish();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::record
