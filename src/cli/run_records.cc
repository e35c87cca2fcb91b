#include "cli/run_records.h"

namespace twin::cli {

void RunRecords::Log(const std::filesystem::path& path, const record::RunInfo& run,
                     record::FullRing full_ring) {
  log_.emplace(path, run, full_ring);
}

void RunRecords::Film(const plant::TruthProbe& truth, Duration duration, int fps) {
  truth_ = &truth;
  camera_.emplace(duration, fps, truth.qpos_size());
}

void RunRecords::WatchContacts(const plant::TruthProbe& truth) {
  contacts_.emplace(truth);
}

void RunRecords::Put(const rt::CycleRecord& record) noexcept {
  if (contacts_) contacts_->Look(record.at);
  if (camera_) camera_->Capture(record.at, *truth_);
  if (log_) log_->Put(record);
}

void RunRecords::Put(const rt::TickRecord& record) noexcept {
  if (log_) log_->Put(record);
}

std::function<void(Time, std::string_view, std::string_view)> RunRecords::Events() {
  if (!log_) return {};
  return [this](Time at, std::string_view kind, std::string_view text) {
    log_->Event(at, kind, text);
  };
}

std::uint64_t RunRecords::Finish() {
  if (!log_) return 0;
  const std::uint64_t dropped = log_->Finish().dropped;
  log_.reset();
  return dropped;
}

}  // namespace twin::cli
