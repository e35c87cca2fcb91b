#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "experiment/statistics.h"
#include "experiment/viability.h"

namespace twin::experiment {
namespace {

using reference::AxisBounds;
using reference::AxisState;
using reference::ViableAxis;

/// Losses in a row whose borders the figure shows.
constexpr std::array<int, 3> kDrawn{0, 3, 20};
constexpr std::array<double, 3> kDistances{0.05, 0.3, 1.5};  ///< rad

/// The border of a condition that holds at `holds` and not at `fails`.
template <class Condition>
double Border(double holds, double fails, const Condition& condition) {
  constexpr int kHalvings = 50;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (holds + fails) / 2;
    (condition(middle) ? holds : fails) = middle;
  }
  return holds;
}

double Middle(const ViableAxis& axis) {
  return (axis.kept().q_min + axis.kept().q_max) / 2;
}

/// The border for some losses. First velocity against acceleration, far from the range's ends: the
/// upper border, then the lower one back, which is the upper one mirrored. Then velocity against
/// the distance to the upper end of the range, without acceleration.
Figure BorderFigure(const AxisBounds& bounds) {
  constexpr int kSteps = 200;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  constexpr double kFarthest = 0.3;  // rad
  constexpr int kDistanceSteps = 300;
  Figure figure{.id = "border",
                .columns =
                    "lost in a row [-],acceleration [rad/s^2],velocity [rad/s],distance to "
                    "the end of the range [rad]"};
  std::vector<std::vector<double>> against_distance;
  for (const int lost : kDrawn) {
    const ViableAxis axis(bounds, lost, "joint 1");
    const double most = axis.kept().ddq_max;
    for (const double sign : {1.0, -1.0}) {
      for (int k = 0; k <= kSteps; ++k) {
        const double ddq = most * (2.0 * k / kSteps - 1);
        const double dq = HighestSpeed(axis, Middle(axis), ddq);
        figure.rows.push_back(Row(lost, sign * ddq, sign * dq, kNone));
      }
    }
    for (int k = 0; k <= kDistanceSteps; ++k) {
      const double distance = kFarthest * k / kDistanceSteps;
      const double dq = HighestSpeed(axis, axis.kept().q_max - distance, 0);
      against_distance.push_back(Row(lost, 0, dq, distance));
    }
    if (lost == 0) figure.values = {{"dq_max", axis.kept().dq_max}, {"ddq_max", most}};
  }
  figure.rows.insert(figure.rows.end(), against_distance.begin(), against_distance.end());
  return figure;
}

/// Extra time of a motion over one that tolerates no losses, %.
double LongerPercent(const AxisBounds& bounds, int lost, double distance) {
  return 100 * (RestToRestTime(bounds, lost, distance) / RestToRestTime(bounds, 0, distance) - 1);
}

Figure PriceFigure(const AxisBounds& bounds) {
  constexpr int kMost = 20;
  Figure figure{.id = "price",
                .columns =
                    "lost in a row [-],speed at full acceleration [rad/s],stopping distance "
                    "[rad],0.05 rad longer by [%],0.3 rad longer by [%],1.5 rad longer by "
                    "[%]"};
  for (int lost = 0; lost <= kMost; ++lost) {
    const ViableAxis axis(bounds, lost, "joint 1");
    std::vector<double>& row = figure.rows.emplace_back(
        Row(lost, HighestSpeed(axis, Middle(axis), axis.kept().ddq_max), StoppingDistance(axis)));
    for (const double distance : kDistances) row.push_back(LongerPercent(bounds, lost, distance));
  }
  return figure;
}

/// The borders of the first joint, which are known beforehand.
void CompareBorder(const AxisBounds& bounds, Findings& findings) {
  struct Known {
    int lost;
    double speed_at_full_acceleration;
    double stopping_distance;
  };
  constexpr std::array kKnown{Known{0, 2.1675, 0.1574}, Known{3, 2.10, 0.1671},
                              Known{20, 1.7175, 0.2217}};
  const auto add = [&](std::string quantity, const char* unit, double ours, double known,
                       double share) {
    findings.Add(std::move(quantity), unit, ours)
        .Demand(fmt::format("{} within {:.2g} %", known, 100 * share),
                std::abs(ours / known - 1) <= share);
  };
  for (const Known& known : kKnown) {
    const ViableAxis axis(bounds, known.lost, "joint 1");
    const std::string name = fmt::format("joint 1, n = {}, ", known.lost);
    add(name + "highest speed without acceleration", "rad/s", HighestSpeed(axis, Middle(axis), 0),
        2.175, 1e-4);
    add(name + "highest speed at full acceleration", "rad/s",
        HighestSpeed(axis, Middle(axis), axis.kept().ddq_max), known.speed_at_full_acceleration,
        1e-4);
    add(name + "way to stop from full speed", "rad", StoppingDistance(axis),
        known.stopping_distance, 3e-3);
  }
}

/// The range of the extra time over all joints.
void CompareTimes(const std::vector<AxisBounds>& bounds, Findings& findings) {
  struct Band {
    double distance;
    double low_percent;
    double high_percent;
  };
  constexpr std::array kBands{Band{kDistances[0], 12, 29}, Band{kDistances[1], 2, 5},
                              Band{kDistances[2], 0, 1}};
  for (const Band& band : kBands) {
    for (const int lost : {3, 19, 20}) {
      Spread longer = SpreadOf(ValuesOf(bounds, [&](const AxisBounds& joint) {
        return LongerPercent(joint, lost, band.distance);
      }));
      longer.mean = LongerPercent(bounds.front(), lost, band.distance);
      Comparison& one = findings.Add(
          fmt::format(
              "all joints, n = {}, {} rad from rest to rest: longer than with n = 0, joint 1", lost,
              band.distance),
          "%", longer);
      if (lost != kDrawn.back()) continue;
      one.Demand(fmt::format("all within {} to {} %", band.low_percent, band.high_percent),
                 longer.low >= band.low_percent && longer.high <= band.high_percent);
      one.reason = "the other implementation's figures are whole per cents";
    }
  }
}

}  // namespace

double HighestSpeed(const ViableAxis& axis, double q, double ddq) {
  const auto is_viable = [&](double dq) { return axis.Contains({.q = q, .dq = dq, .ddq = ddq}); };
  const double most = axis.kept().dq_max;
  if (is_viable(most)) return most;
  return is_viable(0) ? Border(0, most, is_viable) : 0;
}

double StoppingDistance(const ViableAxis& axis) {
  const auto is_viable = [&](double distance) {
    return axis.Contains({.q = axis.kept().q_max - distance, .dq = axis.kept().dq_max, .ddq = 0});
  };
  return Border(axis.longest_way(), 0, is_viable);
}

double RestToRestTime(const AxisBounds& bounds, int lost, double distance, double close) {
  constexpr int kMostCycles = 60'000;
  AxisBounds towards = bounds;
  towards.q_max = distance;
  towards.q_min = distance - (bounds.q_max - bounds.q_min);
  const ViableAxis axis(towards, lost, "the joint");
  AxisState x;
  int cycles = 0;
  while (distance - x.q > close && cycles < kMostCycles) {
    x = ViableAxis::Step(x, axis.Nearest(x, bounds.dddq_max));
    ++cycles;
  }
  return cycles * kCycleSeconds;
}

void AddViableSet(const std::vector<AxisBounds>& bounds, Findings& findings) {
  CompareBorder(bounds.front(), findings);
  CompareTimes(bounds, findings);
  findings.figures.push_back(BorderFigure(bounds.front()));
  findings.figures.push_back(PriceFigure(bounds.front()));
}

}  // namespace twin::experiment
