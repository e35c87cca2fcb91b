#include "twin/record/mcap_reader.h"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "record/mcap_cursor.h"
#include "record/mcap_format.h"
#include "record/mcap_source.h"
#include "twin/core/error.h"

namespace twin::record {

using mcap::Cursor;
using mcap::Opcode;

namespace {

/// Longest accepted name of a topic, schema or encoding; bounds the memory.
constexpr std::size_t kMaxNameBytes = 4096;

std::string TakeName(Cursor& cursor) {
  const std::string_view name = cursor.TakeString();
  if (name.size() > kMaxNameBytes) {
    cursor.Fail(
        fmt::format("a name of {} bytes; at most {} are accepted", name.size(), kMaxNameBytes));
  }
  return std::string(name);
}

}  // namespace

class McapReader::Impl {
 public:
  Impl(std::unique_ptr<mcap::Source> source, std::string name)
      : source_(std::move(source)),
        name_(std::move(name)),
        zstd_(ZSTD_createDCtx(), &ZSTD_freeDCtx) {
    TWIN_CHECK(zstd_ != nullptr);
    truncated_ = !EndsWithMagic();
    if (ReadMore(mcap::kMagic.size()) < mcap::kMagic.size() || !IsMagic(record_)) {
      throw InputError(
          fmt::format("{} is not an MCAP file: its first 8 bytes are not the magic; "
                      "name a log of a run (*.mcap)",
                      name_));
    }
    NextChunk();
  }

  std::optional<McapMessage> Next() {
    while (true) {
      if (auto message = NextInChunk()) {
        ++message_count_;
        return message;
      }
      if (!NextChunk()) return std::nullopt;
    }
  }

  std::map<std::string, mcap::TextMap> metadata;
  std::vector<McapAttachment> attachments;

  [[nodiscard]] std::uint64_t message_count() const { return message_count_; }
  [[nodiscard]] bool truncated() const { return truncated_; }

 private:
  struct Schema {
    std::string name;
    std::string encoding;
    std::uint32_t crc = 0;  ///< of its data, because repetitions must be identical
  };

  static bool IsMagic(std::span<const std::byte> bytes) {
    return std::ranges::equal(bytes, mcap::AsBytes(mcap::kMagic));
  }

  bool EndsWithMagic() {
    std::array<std::byte, 8> last{};
    if (source_->size() < 2 * last.size()) return false;
    source_->ReadAt(source_->size() - last.size(), last);
    return IsMagic(last);
  }

  /// Appends up to `count` bytes of the file to `record_`. @returns the number read.
  std::size_t ReadMore(std::size_t count) {
    record_.resize(count);
    const std::size_t got = source_->ReadAt(offset_, record_);
    record_.resize(got);
    data_crc_before_ = data_crc_;
    data_crc_ = mcap::Crc32(data_crc_, record_);
    offset_ += got;
    return got;
  }

  /// Reads the next record. @returns false at the end of a truncated file.
  bool ReadRecord(Opcode& opcode) {
    const std::uint64_t start = offset_;
    const std::uint32_t crc_before = data_crc_;
    if (ReadMore(mcap::kRecordHeaderBytes) < mcap::kRecordHeaderBytes) return EndEarly(start);
    Cursor header(record_, name_, start);
    opcode = static_cast<Opcode>(header.Take<std::uint8_t>());
    const auto length = header.Take<std::uint64_t>();
    if (length > source_->size() - offset_) return EndEarly(start);
    if (length > kMaxRecordBytes) {
      mcap::FailDamaged(
          name_, start,
          fmt::format("a record of {} bytes; at most {} are accepted", length, kMaxRecordBytes));
    }
    if (ReadMore(static_cast<std::size_t>(length)) < length) return EndEarly(start);
    data_crc_before_ = crc_before;
    return true;
  }

  bool EndEarly(std::uint64_t start) {
    ended_ = true;
    if (truncated_) return false;
    mcap::FailDamaged(name_, start, "a record is longer than the file");
  }

  /// Opens the next chunk. @returns false at the end of the data.
  bool NextChunk() {
    chunk_.clear();
    chunk_at_ = 0;
    Opcode opcode{};
    while (!ended_ && ReadRecord(opcode)) {
      Cursor cursor(record_, name_, offset_ - record_.size());
      switch (opcode) {
        case Opcode::kChunk: OpenChunk(cursor); return true;
        case Opcode::kSchema: TakeSchema(cursor); break;
        case Opcode::kChannel: TakeChannel(cursor); break;
        case Opcode::kAttachment: TakeAttachment(cursor); break;
        case Opcode::kMetadata: TakeMetadata(cursor); break;
        case Opcode::kDataEnd: TakeEnd(cursor); break;
        case Opcode::kMessage:
          cursor.Fail("a message outside of a chunk, which this reader does not accept");
        case Opcode::kFooter: cursor.Fail("a footer without an end of the data before it");
        default: break;  // header, indexes, and records of later MCAP versions
      }
    }
    return false;
  }

  void OpenChunk(Cursor& cursor) {
    static_cast<void>(cursor.TakeBytes(2 * sizeof(std::uint64_t)));  // first and last log time
    const auto size = cursor.Take<std::uint64_t>();
    const auto crc = cursor.Take<std::uint32_t>();
    const std::string compression = TakeName(cursor);
    const auto data = cursor.TakeBytes(cursor.Take<std::uint64_t>());
    if (size > kMaxRecordBytes) {
      cursor.Fail(
          fmt::format("a chunk of {} bytes; at most {} are accepted", size, kMaxRecordBytes));
    }
    if (compression == "zstd") {
      Decompress(data, size, cursor);
    } else if (compression.empty() && data.size() == size) {
      chunk_.assign(data.begin(), data.end());
    } else {
      cursor.Fail(
          fmt::format("a chunk compressed with '{}' of {} bytes for {}; only zstd and none "
                      "are accepted",
                      compression, data.size(), size));
    }
    if (crc != 0 && mcap::Crc32(0, chunk_) != crc) cursor.Fail("the CRC of the chunk is wrong");
    chunk_where_ = fmt::format("{}: the chunk that ends at byte {}", name_, offset_);
    ++chunk_count_;
  }

  void Decompress(std::span<const std::byte> data, std::uint64_t size, Cursor& cursor) {
    // Checking the frame's own size finds a wrong length before memory is allocated.
    const unsigned long long frame = ZSTD_getFrameContentSize(data.data(), data.size());
    if (frame == ZSTD_CONTENTSIZE_ERROR || (frame != ZSTD_CONTENTSIZE_UNKNOWN && frame != size)) {
      cursor.Fail("the chunk is not a zstd frame of the stated size");
    }
    chunk_.resize(static_cast<std::size_t>(size));
    const std::size_t got =
        ZSTD_decompressDCtx(zstd_.get(), chunk_.data(), chunk_.size(), data.data(), data.size());
    if (ZSTD_isError(got) != 0 || got != size) {
      cursor.Fail(fmt::format("the chunk cannot be decompressed ({})", ZSTD_getErrorName(got)));
    }
  }

  std::optional<McapMessage> NextInChunk() {
    while (chunk_at_ < chunk_.size()) {
      Cursor cursor(std::span<const std::byte>(chunk_).subspan(chunk_at_), chunk_where_, chunk_at_);
      const auto opcode = static_cast<Opcode>(cursor.Take<std::uint8_t>());
      const auto content = cursor.TakeBytes(cursor.Take<std::uint64_t>());
      const std::size_t end = chunk_.size() - cursor.remaining();
      Cursor record(content, chunk_where_, end - content.size());
      chunk_at_ = end;
      switch (opcode) {
        case Opcode::kMessage: return TakeMessage(record);
        case Opcode::kSchema: TakeSchema(record); break;
        case Opcode::kChannel: TakeChannel(record); break;
        default: break;
      }
    }
    return std::nullopt;
  }

  McapMessage TakeMessage(Cursor& cursor) const {
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

  void TakeSchema(Cursor& cursor) {
    const auto id = cursor.Take<std::uint16_t>();
    Schema schema;
    schema.name = TakeName(cursor);
    schema.encoding = TakeName(cursor);
    const std::string_view data = cursor.TakeString();
    schema.crc = mcap::Crc32(0, mcap::AsBytes(data));
    if (id == 0) return;  // the specification says to ignore it
    const auto [known, added] = schemas_.emplace(id, schema);
    const bool same = known->second.name == schema.name &&
                      known->second.encoding == schema.encoding && known->second.crc == schema.crc;
    if (!added && !same) cursor.Fail(fmt::format("schema {} comes twice and differs", id));
    if (schemas_.size() > kMaxChannels) {
      cursor.Fail(fmt::format("more than {} schemas, the most accepted", kMaxChannels));
    }
  }

  void TakeChannel(Cursor& cursor) {
    const auto id = cursor.Take<std::uint16_t>();
    const auto schema_id = cursor.Take<std::uint16_t>();
    McapChannel channel;
    channel.topic = TakeName(cursor);
    channel.message_encoding = TakeName(cursor);
    if (schema_id != 0) {
      const auto schema = schemas_.find(schema_id);
      if (schema == schemas_.end()) {
        cursor.Fail(
            fmt::format("channel {} has schema {}, which was not introduced", id, schema_id));
      }
      channel.schema_name = schema->second.name;
      channel.schema_encoding = schema->second.encoding;
    }
    const auto [known, added] = channels_.emplace(id, channel);
    if (!added && !(known->second == channel))
      cursor.Fail(fmt::format("channel {} comes twice and differs", id));
    if (channels_.size() > kMaxChannels) {
      cursor.Fail(fmt::format("more than {} channels, the most accepted", kMaxChannels));
    }
  }

  void TakeAttachment(Cursor& cursor) {
    static_cast<void>(cursor.TakeBytes(2 * sizeof(std::uint64_t)));  // log time, creation time
    McapAttachment attachment;
    attachment.name = TakeName(cursor);
    attachment.media_type = TakeName(cursor);
    const auto data = cursor.TakeBytes(cursor.Take<std::uint64_t>());
    const auto covered = std::span(record_).first(record_.size() - cursor.remaining());
    const auto crc = cursor.Take<std::uint32_t>();
    if (crc != 0 && mcap::Crc32(0, covered) != crc) {
      cursor.Fail(fmt::format("the CRC of attachment '{}' is wrong", attachment.name));
    }
    attachment.data.assign(reinterpret_cast<const char*>(data.data()), data.size());
    attachments.push_back(std::move(attachment));
  }

  void TakeMetadata(Cursor& cursor) {
    std::string name = TakeName(cursor);
    metadata.insert_or_assign(std::move(name), cursor.TakeMap());
  }

  void TakeEnd(Cursor& cursor) {
    const auto crc = cursor.Take<std::uint32_t>();
    if (crc != 0 && crc != data_crc_before_) cursor.Fail("the CRC of the data section is wrong");
    ended_ = true;
    if (!truncated_) TakeSummary();
  }

  /// Checks the part after the data: the summary's CRC and counts.
  void TakeSummary() {
    const std::uint64_t summary_start = offset_;
    data_crc_ = 0;  // counts the summary from here on
    Opcode opcode{};
    while (ReadRecord(opcode)) {
      Cursor cursor(record_, name_, offset_ - record_.size());
      if (opcode == Opcode::kStatistics) TakeStatistics(cursor);
      if (opcode != Opcode::kFooter) continue;
      const auto start = cursor.Take<std::uint64_t>();
      static_cast<void>(cursor.Take<std::uint64_t>());  // summary offsets
      const auto covered = std::span(record_).first(record_.size() - cursor.remaining());
      const auto crc = cursor.Take<std::uint32_t>();
      if (start != 0 && start != summary_start) cursor.Fail("the footer misplaces the summary");
      if (crc != 0 && crc != FooterCrc(covered)) cursor.Fail("the CRC of the summary is wrong");
      if (offset_ + mcap::kMagic.size() != source_->size()) {
        cursor.Fail("something stands between the footer and the closing magic");
      }
      return;
    }
  }

  /// CRC of the summary including `covered`, the first part of the footer.
  std::uint32_t FooterCrc(std::span<const std::byte> covered) const {
    mcap::Bytes header;
    mcap::Put(header, Opcode::kFooter);
    mcap::Put(header, std::uint64_t{record_.size()});
    return mcap::Crc32(mcap::Crc32(data_crc_before_, header), covered);
  }

  void TakeStatistics(Cursor& cursor) {
    const auto messages = cursor.Take<std::uint64_t>();
    static_cast<void>(cursor.TakeBytes(2 + 4 + 4 + 4));  // schemas, channels, attachments, metadata
    const auto chunks = cursor.Take<std::uint32_t>();
    if (messages != message_count_ || chunks != chunk_count_) {
      cursor.Fail(
          fmt::format("the statistics state {} messages in {} chunks, but there are {} in "
                      "{}",
                      messages, chunks, message_count_, chunk_count_));
    }
  }

  std::unique_ptr<mcap::Source> source_;
  const std::string name_;
  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> zstd_;
  bool truncated_ = false;
  bool ended_ = false;  ///< all data has been read
  std::uint64_t offset_ = 0;
  std::uint32_t data_crc_ = 0;         ///< of all bytes read
  std::uint32_t data_crc_before_ = 0;  ///< the same without the last record
  mcap::Bytes record_;                 ///< content of the last record
  mcap::Bytes chunk_;                  ///< records of the open chunk
  std::size_t chunk_at_ = 0;
  std::string chunk_where_;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, McapChannel> channels_;
  std::uint64_t message_count_ = 0;
  std::uint64_t chunk_count_ = 0;
};

McapReader::McapReader(const std::filesystem::path& path)
    : impl_(std::make_unique<Impl>(mcap::OpenFile(path), path.string())) {}

McapReader::McapReader(std::span<const std::byte> bytes, std::string name)
    : impl_(std::make_unique<Impl>(mcap::OpenMemory(bytes), std::move(name))) {}

McapReader::~McapReader() = default;

std::optional<McapMessage> McapReader::Next() {
  return impl_->Next();
}

const std::map<std::string, std::map<std::string, std::string>>& McapReader::metadata() const {
  return impl_->metadata;
}

const std::vector<McapAttachment>& McapReader::attachments() const {
  return impl_->attachments;
}

std::uint64_t McapReader::message_count() const {
  return impl_->message_count();
}

bool McapReader::truncated() const {
  return impl_->truncated();
}

}  // namespace twin::record
