#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "application/compliance_measures.h"

namespace twin::application::compliance {
namespace {

/// Of the compliant case's deflection, below which the stiff one's must stay.
constexpr double kStiffShare = 0.2;
/// Of F / K, within which the steady deflection must lie.
constexpr double kSteadyShare = 0.1;
/// m.
constexpr double kLargestTracking = 5e-3;
/// m.
constexpr double kLargestWandering = 2e-3;
/// rad; less would demonstrate nothing.
constexpr double kLeastWandering = 0.1;

/// Puts findings together.
class Findings {
 public:
  explicit Findings(std::vector<Finding>& findings) : findings_(findings) {}

  void Report(std::string quantity, double value, std::string unit) {
    findings_.push_back({.quantity = std::move(quantity), .value = value, .unit = std::move(unit)});
  }
  void Demand(std::string quantity, double value, std::string unit, std::string demand, bool met) {
    findings_.push_back({.quantity = std::move(quantity),
                         .value = value,
                         .unit = std::move(unit),
                         .demand = std::move(demand),
                         .met = met});
  }

 private:
  std::vector<Finding>& findings_;
};

void AddResponse(const Case& one, const Response& r, Findings& findings) {
  const auto named = [&one](std::string_view what) { return fmt::format("{}: {}", one.id, what); };
  findings.Report(named("deflection along the push, largest"), 1e3 * r.peak, "mm");
  findings.Demand(
      named("deflection under the constant force"), 1e3 * r.steady, "mm",
      fmt::format("F / K = {:.4g} mm within {:.0f} %", 1e3 * r.expected, 1e2 * kSteadyShare),
      std::abs(r.steady - r.expected) <= kSteadyShare * std::abs(r.expected));
  findings.Report(named("force of the push"), r.force, "N");
  findings.Report(named("force of the push, estimated by the robot"), r.estimated_steady, "N");
  if (r.settling) {
    findings.Report(named("settling time to a tenth, after the end of the push"), *r.settling, "s");
  } else {
    findings.Report(named("not settled to a tenth by the end of the motion, after"),
                    r.t.back() - r.t.front(), "s");
  }
}

void AddComparison(const Case& stiff, const Case& compliant, const Response& a, const Response& b,
                   Findings& findings) {
  const double share = a.peak / b.peak;
  findings.Demand(fmt::format("{}: largest deflection / that of {}", stiff.id, compliant.id), share,
                  "", fmt::format("below {}", kStiffShare), share < kStiffShare);
}

void AddTracking(const Case& one, const Tracking& t, bool is_demanded, Findings& findings) {
  const std::string largest = fmt::format("{}: tracking error, largest", one.id);
  if (is_demanded) {
    findings.Demand(largest, 1e3 * t.largest, "mm",
                    fmt::format("at most {} mm", 1e3 * kLargestTracking),
                    t.largest <= kLargestTracking);
  } else {
    findings.Report(largest, 1e3 * t.largest, "mm");
  }
  findings.Report(fmt::format("{}: tracking error, RMS", one.id), 1e3 * t.rms, "mm");
  findings.Report(fmt::format("{}: orientation error, largest", one.id), 1e3 * t.largest_turned,
                  "mrad");
}

}  // namespace

std::vector<Finding> FindingsOf(const Measures& m) {
  std::vector<Finding> all;
  Findings findings(all);
  for (const auto& [stiff, compliant] : {std::pair(kA, kB), {kC, kD}}) {
    for (const CaseIndex index : {stiff, compliant}) {
      if (m.responses[index]) AddResponse(kAllCases[index], *m.responses[index], findings);
    }
    if (!m.responses[stiff] || !m.responses[compliant]) continue;
    AddComparison(kAllCases[stiff], kAllCases[compliant], *m.responses[stiff],
                  *m.responses[compliant], findings);
  }
  for (const CaseIndex index : {kC0, kD0}) {
    if (!m.trackings[index]) continue;
    AddTracking(kAllCases[index], *m.trackings[index], index == kC0, findings);
  }
  if (m.wandering) {
    findings.Demand("N: joint motion in the null space, largest", m.wandering->joints, "rad",
                    fmt::format("at least {} rad", kLeastWandering),
                    m.wandering->joints >= kLeastWandering);
    findings.Demand("N: end effector motion meanwhile, largest", 1e3 * m.wandering->end_effector,
                    "mm", fmt::format("at most {} mm", 1e3 * kLargestWandering),
                    m.wandering->end_effector <= kLargestWandering);
  }
  findings.Demand("peak torque / limit, measured or commanded", 1e2 * m.torque, "%",
                  "at most 100 %", m.torque <= 1);
  findings.Demand("peak rate of the commanded torque / limit", 1e2 * m.rate, "%", "at most 100 %",
                  m.rate <= 1);
  findings.Demand("reflexes", static_cast<double>(m.reflexes), "", "none", m.reflexes == 0);
  return all;
}

}  // namespace twin::application::compliance
