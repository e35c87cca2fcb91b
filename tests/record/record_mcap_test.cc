#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "record/mcap_format.h"
#include "record/mcap_index.h"
#include "record/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/record/mcap_reader.h"
#include "twin/record/mcap_writer.h"

namespace twin::record::record_mcap_test {
namespace {

using ::testing::HasSubstr;

std::string Text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Message k of the small file: its text, k bytes longer than six.
std::string SmallText(int k) {
  return "hello " + std::string(static_cast<std::size_t>(k), 'a');
}

/// A file with two channels, `messages` messages, metadata and an attachment, in small chunks.
std::vector<std::byte> SmallFile(int messages) {
  const TemporaryFolder folder;
  McapWriter writer(folder / "small.mcap", {.library = "test", .chunk_bytes = 200});
  writer.AddMetadata("about", {{"key", "value"}, {"empty", ""}});
  writer.AddAttachment("note.txt", "text/plain", "a note", 5);
  const auto schema = writer.AddSchema("Schema", "protobuf", "data");
  const std::uint16_t channels[] = {writer.AddChannel(schema, "/even", "protobuf"),
                                    writer.AddChannel(0, "/odd", "text")};
  for (int k = 0; k < messages; ++k) {
    const std::string text = SmallText(k);
    const auto place = writer.AddMessage(
        channels[k % 2], std::uint64_t{1000} * static_cast<std::uint64_t>(k), text.size());
    std::memcpy(place.data(), text.data(), text.size());
  }
  writer.Finish();
  return ReadBytes(folder / "small.mcap");
}

struct Read {
  std::vector<std::string> texts;
  bool truncated = false;
};

Read ReadAll(std::span<const std::byte> bytes) {
  McapReader reader(bytes, "bytes");
  Read read;
  while (const auto message = reader.Next()) read.texts.push_back(Text(message->data));
  read.truncated = reader.truncated();
  return read;
}

std::vector<std::string> SmallTexts(std::size_t count) {
  std::vector<std::string> texts;
  for (std::size_t k = 0; k < count; ++k) texts.push_back(SmallText(static_cast<int>(k)));
  return texts;
}

std::uint64_t Number(std::span<const std::byte> bytes, std::size_t at) {
  std::uint64_t number = 0;
  std::memcpy(&number, &bytes[at], sizeof number);
  return number;
}

/// Where chunks are by the summary's index: offsets of their records.
std::vector<std::uint64_t> IndexedChunks(std::span<const std::byte> bytes) {
  constexpr std::size_t kFooter = 8 + 8 + 4;
  const std::size_t footer = bytes.size() - mcap::kMagic.size() - kFooter;
  std::vector<std::uint64_t> offsets;
  for (std::size_t at = Number(bytes, footer); at < footer;) {
    const std::size_t content = at + mcap::kRecordHeaderBytes;
    const bool is_index = bytes[at] == static_cast<std::byte>(mcap::Opcode::kChunkIndex);
    if (is_index) offsets.push_back(Number(bytes, content + 16));
    at = content + Number(bytes, at + 1);
  }
  return offsets;
}

TEST(McapReaderTest, GivesBackWhatWasWritten) {
  const auto bytes = SmallFile(9);
  McapReader reader(bytes, "bytes");
  EXPECT_EQ(reader.metadata().at("about").at("key"), "value");
  ASSERT_EQ(reader.attachments().size(), 1U);
  EXPECT_EQ(reader.attachments()[0].data, "a note");
  for (int k = 0; k < 9; ++k) {
    const auto message = reader.Next();
    ASSERT_TRUE(message.has_value());
    EXPECT_EQ(Text(message->data), SmallText(k));
    EXPECT_EQ(message->channel->topic, k % 2 == 0 ? "/even" : "/odd");
    EXPECT_EQ(message->channel->schema_name, k % 2 == 0 ? "Schema" : "");
    EXPECT_EQ(message->log_time_ns, 1000U * static_cast<unsigned>(k));
    EXPECT_EQ(message->sequence, static_cast<unsigned>(k / 2));
  }
  EXPECT_FALSE(reader.Next().has_value());
  EXPECT_FALSE(reader.Next().has_value());
  EXPECT_FALSE(reader.truncated());
}

TEST(McapReaderTest, ReadsAFileWithoutMessages) {
  EXPECT_TRUE(ReadAll(SmallFile(0)).texts.empty());
}

TEST(McapWriterTest, IndexesEveryChunkOfALongFile) {
  constexpr int kMessages = 2000;  // a chunk each but the shortest: an index of 200 kB
  const auto bytes = SmallFile(kMessages);
  std::vector<std::uint64_t> chunks;
  const mcap::Index index(mcap::OpenMemory(bytes), "bytes");
  for (const auto& place : index.chunks()) {
    chunks.push_back(place.offset - mcap::kRecordHeaderBytes);
  }
  EXPECT_GT(chunks.size(), kMessages - 100U);
  EXPECT_EQ(IndexedChunks(bytes), chunks);
}

TEST(McapWriterTest, GivesTheFileItsNameOnlyWhenItIsWhole) {
  const TemporaryFolder folder;
  McapWriter writer(folder / "a.mcap");
  EXPECT_TRUE(std::filesystem::exists(folder / "a.mcap.partial"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.mcap"));
  writer.Finish();
  EXPECT_FALSE(std::filesystem::exists(folder / "a.mcap.partial"));
  EXPECT_TRUE(std::filesystem::exists(folder / "a.mcap"));
}

TEST(McapWriterTest, NamesTheFolderThatIsMissing) {
  const TemporaryFolder folder;
  try {
    McapWriter writer(folder / "missing" / "a.mcap");
    FAIL() << "no exception";
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), HasSubstr("missing/a.mcap.partial: No such file or directory"));
  }
}

TEST(McapWriterTest, ReportsADiskThatIsFull) {
  const TemporaryFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "a.mcap.partial");
  try {
    McapWriter writer(folder / "a.mcap");
    FAIL() << "no exception";
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), HasSubstr("No space left on device"));
  }
}

TEST(McapReaderTest, ReadsTheWholeChunksOfAFileCutAnywhere) {
  const auto bytes = SmallFile(12);
  std::size_t longest = 0;
  for (std::size_t length = mcap::kMagic.size(); length < bytes.size(); ++length) {
    const Read read = ReadAll(std::span(bytes).first(length));
    ASSERT_TRUE(read.truncated) << length;
    ASSERT_EQ(read.texts, SmallTexts(read.texts.size())) << length;
    ASSERT_GE(read.texts.size(), longest) << "fewer messages in more bytes, at " << length;
    longest = read.texts.size();
  }
  EXPECT_EQ(longest, 12U);
}

TEST(McapReaderTest, NoticesEveryChangedByte) {
  const auto whole = SmallFile(4);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const int flip : {0x01, 0x80, 0xFF}) {
      auto bytes = whole;
      bytes[at] ^= static_cast<std::byte>(flip);
      try {
        // A changed closing magic looks like a killed writer, which is noticed too.
        EXPECT_TRUE(ReadAll(bytes).truncated) << "byte " << at << " of " << whole.size();
      } catch (const InputError&) {
      }
    }
  }
}

/// A file that begins like ours, then holds `record` and the closing magic.
std::vector<std::byte> FileWith(const mcap::Bytes& record) {
  mcap::Bytes bytes;
  mcap::PutBytes(bytes, mcap::AsBytes(mcap::kMagic));
  mcap::PutBytes(bytes, record);
  mcap::PutBytes(bytes, mcap::AsBytes(mcap::kMagic));
  return bytes;
}

std::string FailureOf(std::span<const std::byte> bytes) {
  try {
    ReadAll(bytes);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no failure";
}

mcap::Bytes ChunkRecord(std::uint64_t size, std::string_view compression, std::string_view data) {
  mcap::Bytes record;
  const auto begin = mcap::BeginRecord(record, mcap::Opcode::kChunk);
  mcap::Put(record, std::uint64_t{0});
  mcap::Put(record, std::uint64_t{0});
  mcap::Put(record, size);
  mcap::Put(record, std::uint32_t{0});
  mcap::PutString(record, compression);
  mcap::Put(record, std::uint64_t{data.size()});
  mcap::PutBytes(record, mcap::AsBytes(data));
  mcap::EndRecord(record, begin);
  return record;
}

TEST(McapReaderTest, RefusesWhatIsNoMcapFile) {
  EXPECT_THAT(FailureOf(mcap::AsBytes("time,q[0]\n0,0\n")), HasSubstr("not an MCAP file"));
  EXPECT_THAT(FailureOf({}), HasSubstr("not an MCAP file"));
}

TEST(McapReaderTest, TakesNoMemoryForAChunkThatClaimsToBeHuge) {
  EXPECT_THAT(FailureOf(FileWith(ChunkRecord(1ULL << 40, "zstd", "x"))),
              HasSubstr("a chunk of 1099511627776 bytes; at most 67108864"));
}

TEST(McapReaderTest, RefusesAChunkThatIsNoZstdFrame) {
  EXPECT_THAT(FailureOf(FileWith(ChunkRecord(1000, "zstd", "xxxxxxxxxxxxxxxxx"))),
              HasSubstr("not a zstd frame of the stated size"));
}

TEST(McapReaderTest, RefusesCompressionItDoesNotKnow) {
  EXPECT_THAT(FailureOf(FileWith(ChunkRecord(1000, "lz4", "x"))),
              HasSubstr("compressed with 'lz4'"));
}

TEST(McapReaderTest, RefusesARecordLongerThanTheFile) {
  mcap::Bytes record;
  mcap::Put(record, mcap::Opcode::kMetadata);
  mcap::Put(record, std::uint64_t{1} << 60);
  EXPECT_THAT(FailureOf(FileWith(record)),
              HasSubstr("at byte 8: a record is longer than the file"));
}

TEST(McapReaderTest, RefusesAMessageOnAChannelItWasNotToldAbout) {
  mcap::Bytes message;
  const auto begin = mcap::BeginRecord(message, mcap::Opcode::kMessage);
  mcap::Put(message, std::uint16_t{7});
  mcap::PutBytes(message, std::vector<std::byte>(20));
  mcap::EndRecord(message, begin);
  EXPECT_THAT(FailureOf(FileWith(ChunkRecord(message.size(), "", Text(message)))),
              HasSubstr("channel 7, which was not introduced"));
}

TEST(McapReaderTest, NamesAFileThatIsNotThere) {
  EXPECT_THROW(McapReader("/nonexistent/a.mcap"), InputError);
  EXPECT_THROW(McapReader(std::filesystem::path("/")), InputError);
}

// Check value of CRC-32/ISO-HDLC, as catalogues of CRC parameters give it.
TEST(McapFormatTest, CrcIsTheOneOfZipFiles) {
  EXPECT_EQ(mcap::Crc32(0, mcap::AsBytes("123456789")), 0xCBF43926U);
}

}  // namespace
}  // namespace twin::record::record_mcap_test
