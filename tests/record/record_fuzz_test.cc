#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "record/mcap_format.h"
#include "record/sample_records.h"
#include "record/temporary_folder.h"
#include "twin/core/random.h"
#include "twin/record/mcap_reader.h"
#include "twin/record/recorder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace twin::record::record_fuzz_test {
namespace {

using mcap::Opcode;

std::vector<std::byte> SmallLog() {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait, {}, 4096);
  for (std::uint64_t k = 0; k < 6; ++k) {
    recorder.Put(SampleCycle(k));
    recorder.Put(SampleTick(k));
    recorder.Put(SampleScene(k));
  }
  recorder.Event(Time(), "mode", "Move");
  recorder.Add(SamplePlan());
  recorder.Finish();
  return ReadBytes(folder / "a.mcap");
}

void PutChannel(mcap::Bytes& out, std::uint16_t id, const McapChannel& channel) {
  const std::size_t schema = mcap::BeginRecord(out, Opcode::kSchema);
  mcap::Put(out, static_cast<std::uint16_t>(id + 1));
  mcap::PutString(out, channel.schema_name);
  mcap::PutString(out, channel.schema_encoding);
  mcap::PutString(out, "");
  mcap::EndRecord(out, schema);
  const std::size_t record = mcap::BeginRecord(out, Opcode::kChannel);
  mcap::Put(out, id);
  mcap::Put(out, static_cast<std::uint16_t>(id + 1));
  mcap::PutString(out, channel.topic);
  mcap::PutString(out, channel.message_encoding);
  mcap::PutMap(out, {});
  mcap::EndRecord(out, record);
}

/// The messages of a log in one chunk without compression and CRC, so that a mutation is not
/// stopped by either but reaches the code behind them.
std::vector<std::byte> BareLog(const std::vector<std::byte>& log) {
  mcap::Bytes records;
  McapReader reader(log, "log");
  std::uint16_t id = 0;
  while (const auto message = reader.Next()) {
    PutChannel(records, id, *message->channel);
    const std::size_t begin = mcap::BeginRecord(records, Opcode::kMessage);
    mcap::Put(records, id++);
    mcap::PutBytes(records, std::vector<std::byte>(4 + 8 + 8));
    mcap::PutBytes(records, message->data);
    mcap::EndRecord(records, begin);
  }
  mcap::Bytes out;
  mcap::PutBytes(out, mcap::AsBytes(mcap::kMagic));
  const std::size_t metadata = mcap::BeginRecord(out, Opcode::kMetadata);
  mcap::PutString(out, "run");
  mcap::PutMap(out, {{"seed", "1"}});
  mcap::EndRecord(out, metadata);
  const std::size_t chunk = mcap::BeginRecord(out, Opcode::kChunk);
  mcap::PutBytes(out, std::vector<std::byte>(16));
  mcap::Put(out, std::uint64_t{records.size()});
  mcap::Put(out, std::uint32_t{0});
  mcap::PutString(out, "");
  mcap::Put(out, std::uint64_t{records.size()});
  mcap::PutBytes(out, records);
  mcap::EndRecord(out, chunk);
  return out;
}

/// Changes `bytes` in one of the ways in which files break, or are broken.
void Mutate(std::vector<std::byte>& bytes, const Random& random, std::uint64_t round) {
  const auto bits = random.Bits(round);
  if (bytes.empty()) return;
  const std::size_t at = bits[1] % bytes.size();
  switch (bits[0] % 5) {
    case 0: bytes[at] ^= static_cast<std::byte>(1U << bits[2] % 8); break;
    case 1: bytes.resize(at); break;
    case 2: {  // a length, perhaps
      const std::uint32_t values[] = {0, 1, 0x7FFFFFFF, 0xFFFFFFFF, bits[2]};
      const std::size_t size = std::min<std::size_t>(4, bytes.size() - at);
      std::memcpy(&bytes[at], &values[bits[3] % 5], size);
      break;
    }
    case 3: bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at)); break;
    default:
      bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                   static_cast<std::byte>(bits[2]));
  }
}

void FeedMutations(const std::vector<std::byte>& whole, std::uint64_t seed, std::uint64_t rounds) {
  const Random random(seed, RandomStream::kTest);
  for (std::uint64_t round = 0; round < rounds; ++round) {
    auto bytes = whole;
    const std::uint64_t changes = 1 + round % 3;
    for (std::uint64_t i = 0; i < changes; ++i) Mutate(bytes, random, 3 * round + i);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }
}

TEST(LogFuzzTest, SurvivesMutationsOfALog) {
  FeedMutations(SmallLog(), 1, 5'000);
}

TEST(LogFuzzTest, SurvivesMutationsBehindTheCrc) {
  FeedMutations(BareLog(SmallLog()), 2, 10'000);
}

TEST(LogFuzzTest, ReadsTheBareLogThatItMutates) {
  const auto log = SmallLog();
  const auto bare = BareLog(log);
  McapReader whole(log, "log");
  McapReader reader(bare, "bare");
  while (whole.Next().has_value()) ASSERT_TRUE(reader.Next().has_value());
  EXPECT_FALSE(reader.Next().has_value());
  EXPECT_GT(reader.message_count(), 18U);
}

}  // namespace
}  // namespace twin::record::record_fuzz_test
