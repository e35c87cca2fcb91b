#include "record/mcap_index.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace twin::record::mcap {

Index::Index(std::unique_ptr<Source> source, std::string name)
    : source_(std::move(source)), name_(std::move(name)) {
  Bytes bytes;
  bool is_data = true;
  std::uint64_t offset = kMagic.size();
  while (Read(offset, kRecordHeaderBytes, bytes)) {
    Cursor header(bytes, name_, offset);
    const auto opcode = static_cast<Opcode>(header.Take<std::uint8_t>());
    const auto length = header.Take<std::uint64_t>();
    const std::uint64_t start = offset + kRecordHeaderBytes;
    if (length > source_->size() - start || opcode == Opcode::kFooter) return;
    if (length > McapReader::kMaxRecordBytes) {
      FailDamaged(name_, offset,
                  fmt::format("a record of {} bytes; at most {} are accepted", length,
                              McapReader::kMaxRecordBytes));
    }
    if (opcode == Opcode::kDataEnd) is_data = false;  // the summary repeats schemas and channels
    const bool is_chunk = is_data && opcode == Opcode::kChunk;
    if (is_chunk || opcode == Opcode::kSchema || opcode == Opcode::kChannel) {
      Read(start, is_chunk ? std::min<std::uint64_t>(kChunkHeaderBytes, length) : length, bytes);
      Cursor record(bytes, name_, start);
      if (is_chunk) chunks_.push_back({TakeChunkHeader(record), start, length});
      if (opcode == Opcode::kSchema) channels_.TakeSchema(record);
      if (opcode == Opcode::kChannel) channels_.TakeChannel(record);
    }
    if (is_data && opcode == Opcode::kMessage) {
      FailDamaged(name_, offset, "a message outside of a chunk, which this reader does not accept");
    }
    offset = start + length;
  }
}

void Index::Open(const Place& place, Bytes& record, Chunk& chunk) const {
  Read(place.offset, place.length, record);
  Cursor cursor(record, name_, place.offset);
  chunk.Open(cursor, name_, place.offset + place.length);
}

bool Index::Read(std::uint64_t offset, std::uint64_t count, Bytes& out) const {
  out.resize(static_cast<std::size_t>(count));
  out.resize(source_->ReadAt(offset, out));
  return out.size() == count;
}

}  // namespace twin::record::mcap
