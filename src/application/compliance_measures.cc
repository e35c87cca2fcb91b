#include "application/compliance.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include "twin/core/joint_vector.h"
#include "twin/core/modes.h"
#include "twin/model/inverse_kinematics.h"
#include "twin/record/log_reader.h"

namespace twin::application::compliance {
namespace {

Vector3 PositionOf(const Transform& X) noexcept {
  return {X[12], X[13], X[14]};
}

/// Collects the traces from a log's records.
class TraceCollector {
 public:
  TraceCollector(const std::array<std::optional<Span>, kCases>& spans, const JointLimits& limits,
                 Log& log)
      : spans_(spans), limits_(limits), log_(log) {}

  void operator()(const record::CycleRecord& cycle) {
    const RobotState& state = cycle.state;
    const bool is_reflex = state.robot_mode == RobotMode::kReflex;
    log_.reflexes += is_reflex && !was_reflex_ ? 1 : 0;
    was_reflex_ = is_reflex;
    if (state.robot_mode == RobotMode::kMove) AddMoving(cycle);
    last_id_ = state.message_id;
    last_tau_J_d_ = state.tau_J_d;
  }

  void operator()(const record::TickRecord& tick) {
    if (tick.action != record::TickAction::kFinished) return;
    for (std::size_t i = 0; i < kCases; ++i) {
      if (!IsIn(tick.read, spans_[i]) || finished_[i]) continue;
      finished_[i] = tick.message_id;
    }
  }

  template <class Other>
  void operator()(const Other& /*record*/) {}

  /// Removes the samples after a motion's finished command, when the robot stops the arm itself.
  void LeaveOutStops() {
    for (std::size_t i = 0; i < kCases; ++i) {
      if (!finished_[i]) continue;
      std::erase_if(log_.traces[i], [&](const Sample& sample) {
        return first_ids_[i] + sample.cycle > *finished_[i];
      });
    }
  }

 private:
  static bool IsIn(Time at, const std::optional<Span>& span) {
    return span && at >= span->begun && at <= span->ended;
  }

  void AddMoving(const record::CycleRecord& cycle) {
    for (std::size_t i = 0; i < kCases; ++i) {
      if (!IsIn(cycle.at, spans_[i])) continue;
      if (log_.traces[i].empty()) {
        first_ids_[i] = cycle.state.message_id;
        begun_ = cycle.at;
        held_ = cycle.state.O_T_EE;
      }
      log_.traces[i].push_back(SampleOf(cycle, *spans_[i], first_ids_[i]));
      return;
    }
  }

  [[nodiscard]] Sample SampleOf(const record::CycleRecord& cycle, const Span& span,
                                std::uint64_t first_id) const {
    const RobotState& state = cycle.state;
    Sample sample{.cycle = state.message_id - first_id,
                  .at = ToSeconds(cycle.at.time_since_epoch()),
                  .p = PositionOf(state.O_T_EE),
                  .q = state.q};
    const Transform wanted = span.path ? span.path->Sample(cycle.at - begun_).O_T_EE : held_;
    const Vector6 error = model::Displacement(wanted, state.O_T_EE);
    sample.off = {error[0], error[1], error[2]};
    sample.turned = HalfNorm(error, 3);
    for (std::size_t i = 0; i < sample.force.size(); ++i) sample.force[i] = -state.O_F_ext_hat_K[i];
    TakeTorques(state, sample);
    return sample;
  }

  void TakeTorques(const RobotState& state, Sample& sample) const {
    const double since = kCycleSeconds * static_cast<double>(std::max<std::uint64_t>(
                                             state.message_id - last_id_, 1));
    for (std::size_t j = 0; j < kJoints; ++j) {
      const double torque = std::max(std::abs(state.tau_J[j]), std::abs(state.tau_J_d[j]));
      const double rate = std::abs(state.tau_J_d[j] - last_tau_J_d_[j]) / since;
      sample.torque = std::max(sample.torque, torque / limits_.tau_max[j]);
      sample.rate = std::max(sample.rate, rate / limits_.dtau_max[j]);
    }
  }

  const std::array<std::optional<Span>, kCases>& spans_;
  const JointLimits& limits_;
  Log& log_;
  bool was_reflex_ = false;
  std::uint64_t last_id_ = 0;
  JointVector last_tau_J_d_{};
  std::array<std::uint64_t, kCases> first_ids_{};
  std::array<std::optional<std::uint64_t>, kCases> finished_{};  ///< states that were answered so
  Time begun_{};                         ///< first state of the motion under way
  Transform held_ = kIdentityTransform;  ///< where it began
};

/// Share of the steady deflection within which the arm has settled.
constexpr double kSettled = 0.1;

double Dot(const Vector3& a, const Vector3& b) noexcept {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double Norm(const Vector3& a) noexcept {
  return std::hypot(a[0], a[1], a[2]);
}

Vector3 Minus(const Vector3& a, const Vector3& b) noexcept {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// Values subtracted from a sample.
struct Base {
  Vector3 off{};
  Vector3 force{};
};

/// Means over kBefore before the push.
Base MeanBefore(const Trace& trace, const plant::Push& push) {
  const double begin = ToSeconds(push.begin);
  Base mean;
  double count = 0;
  for (const Sample& sample : trace) {
    if (sample.t() < begin - ToSeconds(kBefore) || sample.t() >= begin) continue;
    for (std::size_t i = 0; i < mean.off.size(); ++i) {
      mean.off[i] += sample.off[i];
      mean.force[i] += sample.force[i];
    }
    ++count;
  }
  for (std::size_t i = 0; i < mean.off.size(); ++i) {
    mean.off[i] /= std::max(count, 1.0);
    mean.force[i] /= std::max(count, 1.0);
  }
  return mean;
}

/// Finds the unpushed motion's sample at the same time, or the previous one if a state was lost.
/// Times must rise.
class Untouched {
 public:
  explicit Untouched(const Trace& trace) : trace_(trace) {}

  [[nodiscard]] Base At(std::uint64_t cycle) {
    while (next_ + 1 < trace_.size() && trace_[next_ + 1].cycle <= cycle) ++next_;
    return {trace_[next_].off, trace_[next_].force};
  }

 private:
  const Trace& trace_;
  std::size_t next_ = 0;
};

/// Adds a sample to a response.
void Take(const Sample& sample, const Base& base, const Vector3& direction, const plant::Push& push,
          Response& r) {
  const Vector3 d = Minus(sample.off, base.off);
  const double along = Dot(d, direction);
  const Duration t = static_cast<std::int64_t>(sample.cycle) * kCycle;
  r.t.push_back(sample.t());
  r.along.push_back(along);
  r.across.push_back(std::sqrt(std::max(Dot(d, d) - along * along, 0.0)));
  r.scripted.push_back(r.force * plant::ShareAt(push, t));
  r.estimated.push_back(Dot(Minus(sample.force, base.force), direction));
}

double MeanBetween(const Response& r, const std::vector<double>& values, double begin, double end) {
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (r.t[i] < begin || r.t[i] >= end) continue;
    sum += values[i];
    ++count;
  }
  return sum / std::max(count, 1.0);
}

std::optional<double> SettlingOf(const Response& r, double released) {
  std::optional<double> settled;
  for (std::size_t i = 0; i < r.t.size(); ++i) {
    if (r.t[i] < released) continue;
    if (std::abs(r.along[i]) > kSettled * std::abs(r.steady)) {
      settled.reset();
    } else if (!settled) {
      settled = r.t[i] - released;
    }
  }
  return settled;
}

}  // namespace

Log ReadLog(const std::filesystem::path& path, const std::array<std::optional<Span>, kCases>& spans,
            const JointLimits& limits) {
  Log log;
  record::LogReader reader(path);
  TraceCollector collector(spans, limits, log);
  record::LogEntry entry;
  while (reader.Next(entry)) std::visit(collector, entry);
  collector.LeaveOutStops();
  return log;
}

std::optional<Response> ResponseOf(const Trace& pushed, const Trace* untouched,
                                   const plant::Push& push, const Gains& gains) {
  const double end = ToSeconds(push.begin + push.duration);
  if (pushed.back().t() < end || (untouched != nullptr && untouched->back().t() < end)) {
    return std::nullopt;
  }
  Response r;
  r.force = Norm(push.force);
  Vector3 direction{};
  for (std::size_t i = 0; i < direction.size(); ++i) {
    direction[i] = push.force[i] / r.force;
    if (push.force[i] != 0) r.expected += direction[i] * push.force[i] / gains.K_P[i];
  }
  const Base before = MeanBefore(pushed, push);
  std::optional<Untouched> beside;
  if (untouched != nullptr) beside.emplace(*untouched);
  for (const Sample& sample : pushed) {
    Take(sample, beside ? beside->At(sample.cycle) : before, direction, push, r);
    const bool is_pushed = sample.t() >= ToSeconds(push.begin) && sample.t() < end;
    if (is_pushed) r.peak = std::max(r.peak, r.along.back());
  }
  const double falls = end - ToSeconds(push.rise);
  r.steady = MeanBetween(r, r.along, falls - ToSeconds(kSteady), falls);
  r.estimated_steady = MeanBetween(r, r.estimated, falls - ToSeconds(kSteady), falls);
  r.settling = SettlingOf(r, end);
  return r;
}

Tracking TrackingOf(const Trace& trace) {
  Tracking tracking;
  double squares = 0;
  for (const Sample& sample : trace) {
    const double off = Norm(sample.off);
    tracking.largest = std::max(tracking.largest, off);
    tracking.largest_turned = std::max(tracking.largest_turned, sample.turned);
    squares += off * off;
  }
  tracking.rms = std::sqrt(squares / static_cast<double>(trace.size()));
  return tracking;
}

double WanderingBegin(const Config& config) {
  return ToSeconds(config.soft_start + kBefore);
}

std::optional<Wandering> WanderingOf(const Trace& trace, const Config& config) {
  const Sample* first = nullptr;
  Wandering w;
  for (const Sample& sample : trace) {
    if (sample.t() < WanderingBegin(config)) continue;
    if (first == nullptr) first = &sample;
    w.end_effector = std::max(w.end_effector, Norm(Minus(sample.p, first->p)));
    for (std::size_t j = 0; j < kJoints; ++j) {
      w.joints = std::max(w.joints, std::abs(sample.q[j] - first->q[j]));
    }
  }
  if (first == nullptr) return std::nullopt;
  return w;
}

Measures Measure(const Log& log, const Config& config, const Pushes& pushes) {
  Measures m;
  m.reflexes = log.reflexes;
  const auto respond = [&](CaseIndex index, const Trace* untouched, const plant::Push& push) {
    const Trace& trace = log.traces[index];
    if (trace.empty() || (untouched != nullptr && untouched->empty())) return;
    m.responses[index] = ResponseOf(trace, untouched, push, GainsOf(kAllCases[index], config));
  };
  respond(kA, nullptr, pushes.standing);
  respond(kB, nullptr, pushes.standing);
  respond(kC, &log.traces[kC0], pushes.moving);
  respond(kD, &log.traces[kD0], pushes.moving);
  for (const CaseIndex index : {kC0, kD0}) {
    if (!log.traces[index].empty()) m.trackings[index] = TrackingOf(log.traces[index]);
  }
  m.wandering = WanderingOf(log.traces[kN], config);
  for (const Trace& trace : log.traces) {
    for (const Sample& sample : trace) {
      m.torque = std::max(m.torque, sample.torque);
      m.rate = std::max(m.rate, sample.rate);
    }
  }
  return m;
}

}  // namespace twin::application::compliance
