#include "twin/run/run_records.h"

#include <cstddef>
#include <utility>

namespace twin::run {

void RunRecords::Log(const std::filesystem::path& path, const record::RunInfo& run,
                     record::FullRing full_ring, const record::LogSplit& split) {
  log_.emplace(path, run, full_ring, split);
}

void RunRecords::Film(const plant::TruthProbe& truth, Duration duration, int fps,
                      render::SnapshotRecorder::Keep keep) {
  truth_ = &truth;
  camera_.emplace(duration, fps, truth.qpos_size(), keep);
}

void RunRecords::WatchContacts(const plant::TruthProbe& truth) {
  contacts_.emplace(truth);
}

void RunRecords::Put(const record::CycleRecord& record) noexcept {
  if (contacts_) {
    contacts_->Look(record.at);
    const bool has_error = record.state.errors.any();
    if (has_error && !had_error_) contacts_->Keep(record.at);
    had_error_ = has_error;
  }
  if (log_) log_->Put(record);
  if (camera_) TakeScenes(record.at);
}

void RunRecords::TakeScenes(Time now) noexcept {
  const std::size_t captured = camera_->Capture(now, *truth_);
  if (!log_) return;
  for (std::size_t i = 0; i < captured; ++i) log_->Put(camera_->last());
}

void RunRecords::Put(const record::TickRecord& record) noexcept {
  if (log_) log_->Put(record);
}

void RunRecords::Event(Time at, std::string_view kind, std::string_view text) noexcept {
  if (log_) log_->Event(at, kind, text);
}

std::function<void(Time, std::string_view, std::string_view)> RunRecords::Events() {
  if (!log_ && !camera_) return {};
  return [this](Time at, std::string_view kind, std::string_view text) {
    Event(at, kind, text);
    if (camera_) events_.push_back({at, std::string(kind), std::string(text)});
  };
}

void RunRecords::Add(record::PlanRecord plan) {
  if (log_) log_->Add(plan);
  plans_.push_back(std::move(plan));
}

std::uint64_t RunRecords::Finish() {
  if (!log_) return 0;
  if (contacts_) {
    for (const plant::ContactMoment& moment : contacts_->Moments()) {
      log_->Event(moment.at, "contact", moment.Text());
    }
  }
  log_failed_ = true;
  const std::uint64_t dropped = log_->Finish().dropped;
  log_failed_ = false;
  log_.reset();
  return dropped;
}

record::RunInfo InfoOf(const scenario::Scenario& scenario, const scenario::RobotData& robot) {
  return {scenario.name,
          scenario.seed,
          TWIN_VERSION,
          std::string(scenario.drive_name()),
          scenario::ToYaml(scenario),
          record::RunLimits{robot.limits, robot.cartesian}};
}

}  // namespace twin::run
