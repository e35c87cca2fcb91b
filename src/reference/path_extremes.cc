#include "reference/quintic_path.h"

#include <cmath>

namespace twin::reference::internal {
namespace {

/// Sum of c[i] s^i on [0, 1].
template <std::size_t N>
using Polynomial = std::array<double, N>;

/// Up to four inner points of [0, 1], ascending.
struct Points {
  std::array<double, 4> s{};
  std::size_t count = 0;
};

template <std::size_t N>
double Evaluate(const Polynomial<N>& p, double s) {
  double value = p[N - 1];
  for (std::size_t i = N - 1; i-- > 0;) value = value * s + p[i];
  return value;
}

template <std::size_t N>
Polynomial<N - 1> Derivative(const Polynomial<N>& p) {
  Polynomial<N - 1> d{};
  for (std::size_t i = 1; i < N; ++i) d[i - 1] = static_cast<double>(i) * p[i];
  return d;
}

/// The sign change of p between a and b.
template <std::size_t N>
double Bisect(const Polynomial<N>& p, double a, double b, bool rises) {
  constexpr int kHalvings = 30;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (a + b);
    (((Evaluate(p, middle) < 0) == rises) ? a : b) = middle;
  }
  return 0.5 * (a + b);
}

/// Sign changes of p in [0, 1].
/// @param turns  sign changes of p's derivative: p is monotonic between them.
template <std::size_t N>
Points SignChanges(const Polynomial<N>& p, const Points& turns) {
  Points roots;
  double a = 0;
  double p_a = Evaluate(p, a);
  for (std::size_t i = 0; i <= turns.count; ++i) {
    const double b = i < turns.count ? turns.s[i] : 1.0;
    const double p_b = Evaluate(p, b);
    if ((p_a < 0) != (p_b < 0)) roots.s[roots.count++] = Bisect(p, a, b, p_a < 0);
    a = b;
    p_a = p_b;
  }
  return roots;
}

/// Calls visit(value, s) at both ends and at inner points.
template <std::size_t N, class Visit>
void VisitExtremes(const Polynomial<N>& p, const Points& inner, const Visit& visit) {
  visit(p[0], 0.0);
  visit(Evaluate(p, 1.0), 1.0);
  for (std::size_t i = 0; i < inner.count; ++i) visit(Evaluate(p, inner.s[i]), inner.s[i]);
}

/// Keeps the largest magnitude of p, a derivative with respect to s, times `unit`.
template <std::size_t N>
void KeepPeak(const Polynomial<N>& p, const Points& inner, double unit,
              const QuinticSegment& segment, std::size_t index, Extreme& peak) {
  VisitExtremes(p, inner, [&](double value, double s) {
    if (std::abs(value * unit) <= std::abs(peak.value)) return;
    peak = {value * unit, ToSeconds(segment.begin) + s * segment.length_s, index};
  });
}

void KeepRange(const Polynomial<6>& p, const Points& inner, const QuinticSegment& segment,
               std::size_t index, Extreme& lowest, Extreme& highest) {
  VisitExtremes(p, inner, [&](double value, double s) {
    const Extreme here{value, ToSeconds(segment.begin) + s * segment.length_s, index};
    if (value < lowest.value) lowest = here;
    if (value > highest.value) highest = here;
  });
}

void Scan(const QuinticSegment& segment, std::size_t index, std::size_t joint,
          PathExtremes& extremes) {
  const double h = segment.length_s;
  Polynomial<6> q = segment.c[joint];
  double power = 1;
  for (double& c : q) {
    c *= power;
    power *= h;
  }
  const auto dq = Derivative(q);
  const auto ddq = Derivative(dq);
  const auto dddq = Derivative(ddq);
  const Points turns_of_dddq = SignChanges(Derivative(dddq), Points{});
  const Points turns_of_ddq = SignChanges(dddq, turns_of_dddq);
  const Points turns_of_dq = SignChanges(ddq, turns_of_ddq);
  const Points turns_of_q = SignChanges(dq, turns_of_dq);
  KeepPeak(dddq, turns_of_dddq, 1 / (h * h * h), segment, index, extremes.dddq[joint]);
  KeepPeak(ddq, turns_of_ddq, 1 / (h * h), segment, index, extremes.ddq[joint]);
  KeepPeak(dq, turns_of_dq, 1 / h, segment, index, extremes.dq[joint]);
  KeepRange(q, turns_of_q, segment, index, extremes.q_lowest[joint], extremes.q_highest[joint]);
}

}  // namespace

PathExtremes FindExtremes(std::span<const QuinticSegment> segments) {
  PathExtremes extremes;
  for (std::size_t joint = 0; joint < kJoints; ++joint) {
    extremes.q_lowest[joint].value = segments.front().c[joint][0];
    extremes.q_highest[joint].value = segments.front().c[joint][0];
  }
  for (std::size_t i = 0; i < segments.size(); ++i) {
    for (std::size_t joint = 0; joint < kJoints; ++joint) Scan(segments[i], i, joint, extremes);
  }
  return extremes;
}

}  // namespace twin::reference::internal
