#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "record/mcap_cursor.h"
#include "record/mcap_format.h"
#include "twin/record/mcap_reader.h"

struct ZSTD_DCtx_s;

namespace twin::record::mcap {

/// Longest accepted name of a topic, schema or encoding; bounds the memory.
inline constexpr std::size_t kMaxNameBytes = 4096;

/// Reads a name. @throws InputError for one that is too long.
[[nodiscard]] std::string TakeName(Cursor& cursor);

/// Schemas and channels of a file, from its untrusted records.
///
/// Threads: one thread. Errors: InputError with the offset; also for a repetition that differs, and
/// more than McapReader::kMaxChannels.
class Channels {
 public:
  void TakeSchema(Cursor& cursor);
  void TakeChannel(Cursor& cursor);
  /// @returns the message, whose channel lives as long as this object.
  [[nodiscard]] McapMessage TakeMessage(Cursor& cursor) const;

 private:
  struct Schema {
    std::string name;
    std::string encoding;
    std::uint32_t crc = 0;  ///< of its data, because repetitions must be identical
  };

  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, McapChannel> channels_;
};

/// What the header of a chunk says.
struct ChunkHeader {
  std::uint64_t first_ns = 0;  ///< log time of its first message
  std::uint64_t last_ns = 0;
  std::uint64_t bytes = 0;  ///< after decompression, at most McapReader::kMaxRecordBytes
  std::uint32_t crc = 0;    ///< 0: none
};

/// Bytes of a ChunkHeader.
inline constexpr std::size_t kChunkHeaderBytes = 8 + 8 + 8 + 4;

/// Reads the beginning of a chunk's record. @throws InputError for a chunk that is too large.
[[nodiscard]] ChunkHeader TakeChunkHeader(Cursor& cursor);

/// A chunk, and the messages in it.
///
/// Threads: one thread. Errors: InputError with the offset.
class Chunk {
 public:
  Chunk();
  ~Chunk();

  /// Decompresses a chunk, and checks its CRC. @param record  its content. @param end  offset of
  /// the first byte behind it. @param name  of the file.
  void Open(Cursor& record, const std::string& name, std::uint64_t end);
  /// Afterwards there are no messages.
  void Close();

  /// @param channels  receives those that the chunk introduces. @returns the next message, valid
  /// until the chunk is opened anew; nullopt at the end.
  [[nodiscard]] std::optional<McapMessage> Next(Channels& channels);

  /// For messages of errors.
  [[nodiscard]] const std::string& where() const { return where_; }

 private:
  void Decompress(std::span<const std::byte> data, std::uint64_t size, Cursor& cursor);

  std::unique_ptr<ZSTD_DCtx_s, std::size_t (*)(ZSTD_DCtx_s*)> zstd_;
  Bytes records_;
  std::size_t at_ = 0;
  std::string where_;
};

}  // namespace twin::record::mcap
