#include "campaign/record_hash.h"

#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <variant>

#include "twin/fci/datagrams.h"
#include "twin/record/log_reader.h"

namespace twin::campaign {
namespace {

template <typename Value>
std::uint64_t Word(Value value) {
  return static_cast<std::uint64_t>(value);
}

std::uint64_t Word(Time time) {
  return static_cast<std::uint64_t>(time.time_since_epoch().count());
}

template <std::size_t N>
void Add(WordHash& hash, const std::array<double, N>& values) {
  hash.AddNumbers(values.data(), N);
}

void Add(WordHash& hash, std::span<const std::byte> bytes) {
  for (std::size_t i = 0; i < bytes.size(); i += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + i, std::min(sizeof(word), bytes.size() - i));
    hash.AddWord(word);
  }
}

void Add(WordHash& hash, const Violation& violation) {
  hash.AddWord(Word(violation.error));
  hash.AddWord(Word(violation.axis));
  hash.AddNumber(violation.value);
  hash.AddNumber(violation.limit);
  hash.AddWord(violation.message_id);
}

void Add(WordHash& hash, const BaseState& base) {
  const BasePose& at = base.odometry;
  hash.AddWord(base.message_id);
  for (const double number :
       {at.x, at.y, at.yaw, base.twist.v, base.twist.w, base.twist_d.v, base.twist_d.w})
    hash.AddNumber(number);
  Add(hash, base.dq_wheels);
  hash.AddWord(Word(base.mode));
}

}  // namespace

void RecordHash::Put(const record::CycleRecord& record) noexcept {
  for (const std::uint64_t word :
       {std::uint64_t{1}, Word(record.at), Word(record.fate), Word(record.lost_in_row),
        Word(record.dropped), Word(record.violated)}) {
    hash_.AddWord(word);
  }
  fci::StateBytes state;
  fci::Encode(record.state, state);
  Add(hash_, state);
  Add(hash_, record.state.accelerometer_top);
  Add(hash_, record.state.accelerometer_bottom);
  Add(hash_, record.dddq_d);
  if (record.violated) Add(hash_, record.violation);
  if (record.base) Add(hash_, *record.base);
  if (next_ != nullptr) next_->Put(record);
}

void RecordHash::Put(const record::TickRecord& record) noexcept {
  for (const std::uint64_t word :
       {std::uint64_t{2}, Word(record.read), Word(record.written), record.message_id,
        Word(record.action), Word(record.skipped_states), Word(record.deposit_time),
        Word(record.stalled), Word(record.margin.has_value()), Word(record.kept_back)}) {
    hash_.AddWord(word);
  }
  hash_.AddNumber(record.margin.value_or(0));
  Add(hash_, record.q_ext);
  Add(hash_, record.dq_ext);
  fci::CommandBytes command;
  fci::Encode(record.command, command);
  Add(hash_, command);
  if (next_ != nullptr) next_->Put(record);
}

std::uint64_t RecordHashOf(const std::filesystem::path& log) {
  record::LogReader reader(log);
  RecordHash hash;
  record::LogEntry entry;
  while (reader.Next(entry)) {
    if (const auto* cycle = std::get_if<record::CycleRecord>(&entry)) hash.Put(*cycle);
    if (const auto* tick = std::get_if<record::TickRecord>(&entry)) hash.Put(*tick);
  }
  return hash.value();
}

}  // namespace twin::campaign
