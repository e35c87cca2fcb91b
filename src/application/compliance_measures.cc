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

/// Collects the traces from a log's records.
class TraceCollector {
 public:
  TraceCollector(const Spans& spans, const JointLimits& limits, Log& log)
      : spans_(spans), limits_(limits), log_(log) {}

  void operator()(const record::CycleRecord& cycle) {
    const RobotState& state = cycle.state;
    const bool is_reflex = state.robot_mode == RobotMode::kReflex;
    log_.reflexes += is_reflex && !was_reflex_ ? 1 : 0;
    was_reflex_ = is_reflex;
    const std::size_t i = CaseAt(cycle.at);
    if (state.robot_mode == RobotMode::kMove && i < kCases) {
      if (log_.traces[i].empty()) first_ = cycle;
      first_ids_[i] = first_.state.message_id;
      log_.traces[i].push_back(SampleOf(cycle, *spans_[i]));
    }
    last_id_ = state.message_id;
    last_tau_J_d_ = state.tau_J_d;
  }

  void operator()(const record::TickRecord& tick) {
    const std::size_t i = CaseAt(tick.read);
    if (tick.action != record::TickAction::kFinished || i == kCases || finished_[i]) return;
    finished_[i] = tick.message_id;
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
  /// The case with this time in its span; kCases: none.
  [[nodiscard]] std::size_t CaseAt(Time at) const {
    const auto one = std::ranges::find_if(spans_, [at](const std::optional<Span>& span) {
      return span && at >= span->begun && at <= span->ended;
    });
    return static_cast<std::size_t>(one - spans_.begin());
  }

  [[nodiscard]] Sample SampleOf(const record::CycleRecord& cycle, const Span& span) const {
    const RobotState& state = cycle.state;
    Sample sample{.cycle = state.message_id - first_.state.message_id,
                  .at = ToSeconds(cycle.at.time_since_epoch()),
                  .p = {state.O_T_EE[12], state.O_T_EE[13], state.O_T_EE[14]},
                  .q = state.q};
    const Transform wanted =
        span.path ? span.path->Sample(cycle.at - first_.at).O_T_EE : first_.state.O_T_EE;
    const Vector6 error = model::Displacement(wanted, state.O_T_EE);
    sample.off = {error[0], error[1], error[2]};
    sample.turned = HalfNorm(error, 3);
    for (std::size_t i = 0; i < sample.force.size(); ++i) sample.force[i] = -state.O_F_ext_hat_K[i];
    const double since = kCycleSeconds * static_cast<double>(std::max<std::uint64_t>(
                                             state.message_id - last_id_, 1));
    for (std::size_t j = 0; j < kJoints; ++j) {
      const double torque = std::max(std::abs(state.tau_J[j]), std::abs(state.tau_J_d[j]));
      const double rate = std::abs(state.tau_J_d[j] - last_tau_J_d_[j]) / since;
      sample.torque = std::max(sample.torque, torque / limits_.tau_max[j]);
      sample.rate = std::max(sample.rate, rate / limits_.dtau_max[j]);
    }
    return sample;
  }

  const Spans& spans_;
  const JointLimits& limits_;
  Log& log_;
  bool was_reflex_ = false;
  std::uint64_t last_id_ = 0;
  JointVector last_tau_J_d_{};
  record::CycleRecord first_{};  ///< of the current case
  std::array<std::uint64_t, kCases> first_ids_{};
  std::array<std::optional<std::uint64_t>, kCases> finished_{};  ///< states that were answered so
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

/// Mean deviation and force over kBefore before the push.
Sample MeanBefore(const Trace& trace, const plant::Push& push) {
  const double begin = ToSeconds(push.begin);
  Sample mean;
  double count = 0;
  for (const Sample& sample : trace) {
    if (sample.t() < begin - ToSeconds(kBefore) || sample.t() >= begin) continue;
    for (std::size_t i = 0; i < mean.off.size(); ++i) {
      mean.off[i] += sample.off[i];
      mean.force[i] += sample.force[i];
    }
    ++count;
  }
  for (double& off : mean.off) off /= std::max(count, 1.0);
  for (double& force : mean.force) force /= std::max(count, 1.0);
  return mean;
}

/// Adds a sample to a response. @param base  the arm without the push.
void Take(const Sample& sample, const Sample& base, const Vector3& direction,
          const plant::Push& push, Response& r) {
  const Vector3 d = Minus(sample.off, base.off);
  const double along = Dot(d, direction);
  const Duration t = static_cast<std::int64_t>(sample.cycle) * kCycle;
  r.t.push_back(sample.t());
  r.along.push_back(along);
  r.across.push_back(std::sqrt(std::max(Dot(d, d) - along * along, 0.0)));
  r.scripted.push_back(r.force * plant::ShareAt(push, t));
  r.estimated.push_back(Dot(Minus(sample.force, base.force), direction));
  if (t >= push.begin && t < push.begin + push.duration) r.peak = std::max(r.peak, along);
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

Log ReadLog(const std::filesystem::path& path, const Spans& spans, const JointLimits& limits) {
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
  const Sample before = MeanBefore(pushed, push);
  std::size_t beside = 0;
  for (const Sample& sample : pushed) {
    if (untouched == nullptr) {
      Take(sample, before, direction, push, r);
      continue;
    }
    // The unpushed motion's sample at the same time, or the previous one if a state was lost.
    while (beside + 1 < untouched->size() && (*untouched)[beside + 1].cycle <= sample.cycle) {
      ++beside;
    }
    Take(sample, (*untouched)[beside], direction, push, r);
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
  for (std::size_t i = 0; i < kCases; ++i) {
    const Case& one = kAllCases[i];
    const Trace& trace = log.traces[i];
    if (trace.empty()) continue;
    const bool moves = one.kind == Kind::kTrajectory;
    const Trace* untouched = one.is_pushed && moves ? &log.traces[i - 1] : nullptr;
    if (one.is_pushed && (untouched == nullptr || !untouched->empty())) {
      m.responses[i] = ResponseOf(trace, untouched, *pushes[i], GainsOf(one, config));
    }
    if (moves && !one.is_pushed) m.trackings[i] = TrackingOf(trace);
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
