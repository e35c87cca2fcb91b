#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "record/mcap_chunk.h"
#include "record/mcap_source.h"

namespace twin::record::mcap {

/// Where the chunks of a file are, from the heads of its records: the file's own index is not used,
/// so that a file of a killed writer has one too.
///
/// Threads: const calls from any. Errors: as McapReader, without the CRC of the file.
class Index {
 public:
  struct Place {
    ChunkHeader header;
    std::uint64_t offset = 0;  ///< of the record's content
    std::uint64_t length = 0;
  };

  Index(std::unique_ptr<Source> source, std::string name);

  [[nodiscard]] const std::vector<Place>& chunks() const { return chunks_; }
  /// Schemas and channels outside of chunks.
  [[nodiscard]] const Channels& channels() const { return channels_; }
  [[nodiscard]] const std::string& name() const { return name_; }

  /// @param record  a buffer to reuse.
  void Open(const Place& place, Bytes& record, Chunk& chunk) const;

 private:
  /// @returns false at the end of a file that ends within a record.
  bool Read(std::uint64_t offset, std::uint64_t count, Bytes& out) const;

  std::unique_ptr<Source> source_;
  std::string name_;
  std::vector<Place> chunks_;
  Channels channels_;
};

}  // namespace twin::record::mcap
