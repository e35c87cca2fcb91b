#include "campaign/record_hash.h"

#include <array>
#include <variant>

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

}  // namespace

void RecordHash::Put(const record::CycleRecord& record) noexcept {
  for (const std::uint64_t word :
       {std::uint64_t{1}, Word(record.at), record.state.message_id, Word(record.fate),
        Word(record.lost_in_row), Word(record.dropped), Word(record.violated)}) {
    hash_.AddWord(word);
  }
  Add(hash_, record.dddq_d);
  if (next_ != nullptr) next_->Put(record);
}

void RecordHash::Put(const record::TickRecord& record) noexcept {
  const RobotCommand& command = record.command;
  for (const std::uint64_t word :
       {std::uint64_t{2}, Word(record.read), Word(record.written), record.message_id,
        Word(record.action), Word(record.skipped_states), Word(record.deposit_time),
        Word(record.stalled), Word(record.margin.has_value()), Word(record.kept_back),
        command.message_id, Word(command.motion_generation_finished)}) {
    hash_.AddWord(word);
  }
  hash_.AddNumber(record.margin.value_or(0));
  Add(hash_, record.q_ext);
  Add(hash_, record.dq_ext);
  Add(hash_, command.q_c);
  Add(hash_, command.dq_c);
  Add(hash_, command.O_T_EE_c);
  Add(hash_, command.tau_J_d);
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
