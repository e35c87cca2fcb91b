#include "campaign/first_difference.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "twin/core/robot_state.h"
#include "twin/record/cycle_record.h"
#include "twin/run/run.h"

namespace twin::campaign {
namespace {

/// Keeps a run's states.
class States final : public record::RecordSink {
 public:
  void Put(const record::CycleRecord& record) noexcept override { of_run_.push_back(record.state); }
  void Put(const record::TickRecord& /*record*/) noexcept override {}

  [[nodiscard]] const std::vector<RobotState>& of_run() const { return of_run_; }

 private:
  std::vector<RobotState> of_run_;
};

/// What a controller commands shows in the desired values first.
constexpr std::array<std::pair<std::string_view, JointVector RobotState::*>, 6> kValues{
    {{"q_d", &RobotState::q_d},
     {"dq_d", &RobotState::dq_d},
     {"tau_J_d", &RobotState::tau_J_d},
     {"q", &RobotState::q},
     {"dq", &RobotState::dq},
     {"tau_J", &RobotState::tau_J}}};

std::optional<std::string> Difference(const RobotState& a, const RobotState& b) {
  for (const auto& [name, values] : kValues) {
    for (std::size_t j = 0; j < kJoints; ++j) {
      if ((a.*values)[j] == (b.*values)[j]) continue;
      return fmt::format("{}[{}] of state {} is {} and {}", name, j, a.message_id, (a.*values)[j],
                         (b.*values)[j]);
    }
  }
  if (a.errors == b.errors) return std::nullopt;
  return fmt::format("the errors of state {} are others", a.message_id);
}

}  // namespace

std::string FirstDifference(const scenario::Scenario& world, const run::Catalogue& catalogue,
                            const run::RunFiles& files) {
  std::array<States, 2> runs;
  for (States& states : runs) {
    static_cast<void>(run::Run(world, catalogue, files, &states).Execute());
  }
  const std::vector<RobotState>& a = runs[0].of_run();
  const std::vector<RobotState>& b = runs[1].of_run();
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (const auto difference = Difference(a[i], b[i])) {
      return fmt::format("of two more runs, {}", *difference);
    }
  }
  if (a.size() == b.size()) return "two more runs are alike";
  return fmt::format("two more runs have {} and {} states, alike as long as both last", a.size(),
                     b.size());
}

}  // namespace twin::campaign
