#include "record/mcap_chunk.h"

#include <zstd.h>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::record::mcap {

std::string TakeName(Cursor& cursor) {
  const std::string_view name = cursor.TakeString();
  if (name.size() > kMaxNameBytes) {
    cursor.Fail(
        fmt::format("a name of {} bytes; at most {} are accepted", name.size(), kMaxNameBytes));
  }
  return std::string(name);
}

void Channels::TakeSchema(Cursor& cursor) {
  const auto id = cursor.Take<std::uint16_t>();
  Schema schema;
  schema.name = TakeName(cursor);
  schema.encoding = TakeName(cursor);
  const std::string_view data = cursor.TakeString();
  schema.crc = Crc32(0, AsBytes(data));
  if (id == 0) return;  // the specification says to ignore it
  const auto [known, added] = schemas_.emplace(id, schema);
  const bool same = known->second.name == schema.name &&
                    known->second.encoding == schema.encoding && known->second.crc == schema.crc;
  if (!added && !same) cursor.Fail(fmt::format("schema {} comes twice and differs", id));
  if (schemas_.size() > McapReader::kMaxChannels) {
    cursor.Fail(fmt::format("more than {} schemas, the most accepted", McapReader::kMaxChannels));
  }
}

void Channels::TakeChannel(Cursor& cursor) {
  const auto id = cursor.Take<std::uint16_t>();
  const auto schema_id = cursor.Take<std::uint16_t>();
  McapChannel channel;
  channel.topic = TakeName(cursor);
  channel.message_encoding = TakeName(cursor);
  if (schema_id != 0) {
    const auto schema = schemas_.find(schema_id);
    if (schema == schemas_.end()) {
      cursor.Fail(fmt::format("channel {} has schema {}, which was not introduced", id, schema_id));
    }
    channel.schema_name = schema->second.name;
    channel.schema_encoding = schema->second.encoding;
  }
  const auto [known, added] = channels_.emplace(id, channel);
  if (!added && !(known->second == channel)) {
    cursor.Fail(fmt::format("channel {} comes twice and differs", id));
  }
  if (channels_.size() > McapReader::kMaxChannels) {
    cursor.Fail(fmt::format("more than {} channels, the most accepted", McapReader::kMaxChannels));
  }
}

McapMessage Channels::TakeMessage(Cursor& cursor) const {
  const auto id = cursor.Take<std::uint16_t>();
  const auto channel = channels_.find(id);
  if (channel == channels_.end()) {
    cursor.Fail(fmt::format("a message on channel {}, which was not introduced", id));
  }
  McapMessage message;
  message.channel = &channel->second;
  message.sequence = cursor.Take<std::uint32_t>();
  message.log_time_ns = cursor.Take<std::uint64_t>();
  static_cast<void>(cursor.Take<std::uint64_t>());  // publish time
  message.data = cursor.TakeBytes(cursor.remaining());
  return message;
}

ChunkHeader TakeChunkHeader(Cursor& cursor) {
  ChunkHeader header;
  header.first_ns = cursor.Take<std::uint64_t>();
  header.last_ns = cursor.Take<std::uint64_t>();
  header.bytes = cursor.Take<std::uint64_t>();
  header.crc = cursor.Take<std::uint32_t>();
  if (header.bytes > McapReader::kMaxRecordBytes) {
    cursor.Fail(fmt::format("a chunk of {} bytes; at most {} are accepted", header.bytes,
                            McapReader::kMaxRecordBytes));
  }
  return header;
}

Chunk::Chunk() : zstd_(ZSTD_createDCtx(), &ZSTD_freeDCtx) {
  TWIN_CHECK(zstd_ != nullptr);
}

Chunk::~Chunk() = default;

void Chunk::Open(Cursor& record, const std::string& name, std::uint64_t end) {
  Close();
  const ChunkHeader header = TakeChunkHeader(record);
  const std::string compression = TakeName(record);
  const auto data = record.TakeBytes(record.Take<std::uint64_t>());
  if (compression == "zstd") {
    Decompress(data, header.bytes, record);
  } else if (compression.empty() && data.size() == header.bytes) {
    records_.assign(data.begin(), data.end());
  } else {
    record.Fail(
        fmt::format("a chunk compressed with '{}' of {} bytes for {}; only zstd and none "
                    "are accepted",
                    compression, data.size(), header.bytes));
  }
  if (header.crc != 0 && Crc32(0, records_) != header.crc) {
    record.Fail("the CRC of the chunk is wrong");
  }
  where_ = fmt::format("{}: the chunk that ends at byte {}", name, end);
}

void Chunk::Close() {
  records_.clear();
  at_ = 0;
}

void Chunk::Decompress(std::span<const std::byte> data, std::uint64_t size, Cursor& cursor) {
  // Checking the frame's own size finds a wrong length before memory is allocated.
  const unsigned long long frame = ZSTD_getFrameContentSize(data.data(), data.size());
  if (frame == ZSTD_CONTENTSIZE_ERROR || (frame != ZSTD_CONTENTSIZE_UNKNOWN && frame != size)) {
    cursor.Fail("the chunk is not a zstd frame of the stated size");
  }
  records_.resize(static_cast<std::size_t>(size));
  const std::size_t got =
      ZSTD_decompressDCtx(zstd_.get(), records_.data(), records_.size(), data.data(), data.size());
  if (ZSTD_isError(got) != 0 || got != size) {
    cursor.Fail(fmt::format("the chunk cannot be decompressed ({})", ZSTD_getErrorName(got)));
  }
}

std::optional<McapMessage> Chunk::Next(Channels& channels) {
  while (at_ < records_.size()) {
    Cursor cursor(std::span<const std::byte>(records_).subspan(at_), where_, at_);
    const auto opcode = static_cast<Opcode>(cursor.Take<std::uint8_t>());
    const auto content = cursor.TakeBytes(cursor.Take<std::uint64_t>());
    const std::size_t end = records_.size() - cursor.remaining();
    Cursor record(content, where_, end - content.size());
    at_ = end;
    switch (opcode) {
      case Opcode::kMessage: return channels.TakeMessage(record);
      case Opcode::kSchema: channels.TakeSchema(record); break;
      case Opcode::kChannel: channels.TakeChannel(record); break;
      default: break;
    }
  }
  return std::nullopt;
}

}  // namespace twin::record::mcap
