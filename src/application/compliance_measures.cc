#include "application/compliance.h"

#include <algorithm>
#include <cmath>

#include "twin/core/joint_vector.h"

namespace twin::application::compliance {
namespace {

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
