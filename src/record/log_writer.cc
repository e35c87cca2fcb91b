#include "record/log_writer.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace twin::record {

LogWriter::LogWriter(const std::filesystem::path& path, const RunInfo& run, const LogSplit& split,
                     std::size_t chunk_bytes)
    : path_(path), run_(run), split_(split), chunk_bytes_(chunk_bytes), files_(path) {
  if (split_.wanted()) number_ = files_.Next();
  file_ = Create({});
}

std::unique_ptr<LogWriter::File> LogWriter::Create(
    std::vector<std::uint32_t> first_sequences) const {
  return std::make_unique<File>(split_.wanted() ? LogPart(path_, number_) : path_,
                                McapWriterOptions{.library = "panda-twin " + run_.version,
                                                  .chunk_bytes = chunk_bytes_,
                                                  .first_sequences = std::move(first_sequences),
                                                  .is_synced = split_.is_synced},
                                run_);
}

void LogWriter::Add(const CycleRecord& record) {
  if (split_.wanted()) {
    const bool is_complete = completing_.valid() && completing_.wait_for(std::chrono::seconds(0)) ==
                                                        std::future_status::ready;
    if (is_complete) Count(completing_.get());  // its failure is told at once
    if (IsFull(record.at)) GoOn();
    begin_ = begin_ ? std::min(*begin_, record.at) : record.at;  // a reset takes time back
  }
  file_->encoder.Add(record);
}

bool LogWriter::IsFull(Time at) const {
  if (!begin_) return false;
  return (split_.time && at - *begin_ >= *split_.time) ||
         (split_.bytes && file_->mcap.bytes() >= *split_.bytes);
}

void LogWriter::GoOn() {
  if (completing_.valid()) Count(completing_.get());
  std::vector<std::uint32_t> next = file_->mcap.next_sequences();
  completing_ =
      std::async(std::launch::async, [this, file = std::move(file_), number = number_]() mutable {
        return Complete(std::move(file), number);
      });
  ++number_;
  begin_.reset();
  file_ = Create(std::move(next));
}

McapTotals LogWriter::Complete(std::unique_ptr<File> file, std::size_t number) const {
  const McapTotals totals = file->mcap.Finish();
  if (split_.keep) files_.Prune(*split_.keep, number);
  return totals;
}

void LogWriter::Count(const McapTotals& totals) {
  totals_.messages += totals.messages;
  totals_.chunks += totals.chunks;
  totals_.bytes += totals.bytes;
}

McapTotals LogWriter::Finish() {
  if (completing_.valid()) Count(completing_.get());
  Count(Complete(std::move(file_), number_));
  return totals_;
}

}  // namespace twin::record
