#include "twin/record/log_reader.h"

#include <utility>

#include <fmt/format.h>

#include "record/log_decoder.h"
#include "record/log_text.h"
#include "twin/core/error.h"
#include "twin/core/integer.h"
#include "twin/record/mcap_reader.h"

namespace twin::record {

class LogReader::Impl {
 public:
  template <class... Arguments>
  explicit Impl(std::string name, Arguments&&... arguments)
      : reader_(std::forward<Arguments>(arguments)...), name_(std::move(name)) {
    TakeRunInfo();
  }

  bool Next(LogEntry& entry) {
    while (const auto message = reader_.Next()) {
      try {
        if (Decode(*message, entry)) return true;
      } catch (const InputError& error) {
        throw InputError(fmt::format("{}: message {} of the file, on topic {}: {}", name_,
                                     reader_.message_count(), message->channel->topic,
                                     error.what()));
      }
    }
    return false;
  }

  [[nodiscard]] const RunInfo& run() const { return run_; }
  [[nodiscard]] const McapReader& reader() const { return reader_; }

 private:
  /// @returns false for a message that callers do not receive.
  bool Decode(const McapMessage& message, LogEntry& entry) {
    const std::string& topic = message.channel->topic;
    if (topic == kConfigTopic) {
      RequireType<pb::Config>(message);
      decoder_.TakeConfig(message.data);
      return false;
    }
    if (topic == kCycleTopic) return DecodeAs<pb::Cycle, CycleRecord>(message, entry);
    if (topic == kTickTopic) return DecodeAs<pb::Tick, TickRecord>(message, entry);
    if (topic == kEventTopic) return DecodeAs<pb::Event, EventRecord>(message, entry);
    if (topic == kSceneTopic) return DecodeAs<pb::Scene, SceneRecord>(message, entry);
    if (topic == kPlanTopic) return DecodeAs<pb::Plan, PlanRecord>(message, entry);
    return false;
  }

  template <class Message, class Record>
  bool DecodeAs(const McapMessage& message, LogEntry& entry) {
    RequireType<Message>(message);
    Record record;
    decoder_.Decode(message.data, record);
    entry = std::move(record);
    return true;
  }

  template <class Message>
  static void RequireType(const McapMessage& message) {
    const McapChannel& channel = *message.channel;
    const std::string& expected = Message::descriptor()->full_name();
    if (channel.message_encoding == "protobuf" && channel.schema_name == expected) return;
    throw InputError(fmt::format("holds '{}' messages of type '{}'; expected protobuf, {}",
                                 channel.message_encoding, channel.schema_name, expected));
  }

  void TakeRunInfo() {
    const auto found = reader_.metadata().find(kRunMetadata);
    if (found == reader_.metadata().end()) {
      if (reader_.truncated()) return;  // the run was killed before the message was written
      throw InputError(
          fmt::format("{} is an MCAP file but no log of panda-twin: it has no metadata record '{}'",
                      name_, kRunMetadata));
    }
    const auto value = [&found](const char* key) {
      const auto entry = found->second.find(key);
      return entry == found->second.end() ? std::string() : ToPrintable(entry->second);
    };
    run_.scenario = value(kScenarioKey);
    run_.version = value(kVersionKey);
    run_.drive = value(kDriveKey);
    const std::string text = value(kSeedKey);
    const auto seed = ParseInteger<std::uint64_t>(text);
    if (!seed) {
      throw InputError(fmt::format(
          "{}: seed in the metadata is '{}'; it must be a whole number of 64 bits", name_, text));
    }
    run_.seed = *seed;
    TakeLimits();
    for (const McapAttachment& attachment : reader_.attachments()) {
      if (attachment.name == kScenarioAttachment) run_.scenario_yaml = attachment.data;
    }
  }

  void TakeLimits() {
    const auto found = reader_.metadata().find(kLimitsMetadata);
    if (found == reader_.metadata().end()) return;
    try {
      run_.limits = LimitsFromMetadata(found->second);
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}", name_, error.what()));
    }
  }

  McapReader reader_;
  const std::string name_;
  RunInfo run_;
  LogDecoder decoder_;
};

LogReader::LogReader(const std::filesystem::path& path)
    : impl_(std::make_unique<Impl>(path.string(), path)) {}

LogReader::LogReader(std::span<const std::byte> bytes, const std::string& name)
    : impl_(std::make_unique<Impl>(name, bytes, name)) {}

LogReader::~LogReader() = default;

bool LogReader::Next(LogEntry& entry) {
  return impl_->Next(entry);
}

const RunInfo& LogReader::run() const {
  return impl_->run();
}

bool LogReader::truncated() const {
  return impl_->reader().truncated();
}

std::uint64_t LogReader::message_count() const {
  return impl_->reader().message_count();
}

}  // namespace twin::record
