#include "twin/record/mcap_reader.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "record/mcap_chunk.h"
#include "record/mcap_cursor.h"
#include "record/mcap_format.h"
#include "record/mcap_source.h"
#include "twin/core/error.h"

namespace twin::record {

using mcap::Cursor;
using mcap::Opcode;

class McapReader::Impl {
 public:
  Impl(std::unique_ptr<mcap::Source> source, std::string name)
      : source_(std::move(source)), name_(std::move(name)) {
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
      if (auto message = chunk_.Next(channels_)) {
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
    chunk_.Close();
    Opcode opcode{};
    while (!ended_ && ReadRecord(opcode)) {
      Cursor cursor(record_, name_, offset_ - record_.size());
      switch (opcode) {
        case Opcode::kChunk:
          chunk_.Open(cursor, name_, offset_);
          ++chunk_count_;
          return true;
        case Opcode::kSchema: channels_.TakeSchema(cursor); break;
        case Opcode::kChannel: channels_.TakeChannel(cursor); break;
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

  void TakeAttachment(Cursor& cursor) {
    static_cast<void>(cursor.TakeBytes(2 * sizeof(std::uint64_t)));  // log time, creation time
    McapAttachment attachment;
    attachment.name = mcap::TakeName(cursor);
    attachment.media_type = mcap::TakeName(cursor);
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
    std::string name = mcap::TakeName(cursor);
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
  bool truncated_ = false;
  bool ended_ = false;  ///< all data has been read
  std::uint64_t offset_ = 0;
  std::uint32_t data_crc_ = 0;         ///< of all bytes read
  std::uint32_t data_crc_before_ = 0;  ///< the same without the last record
  mcap::Bytes record_;                 ///< content of the last record
  mcap::Chunk chunk_;                  ///< the open one
  mcap::Channels channels_;
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
