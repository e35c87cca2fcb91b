// Prints how chains compare, as the tables of src/reference/CHAINS.md: the deviation from the plan
// under bursts of lost commands, late and stalled sources, jitter and drift.
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "run/chain_runs.h"

namespace twin::run::test::chain_runs {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

struct Chain {
  const char* name;
  loop::Generator generator;
  bool limiter;
  std::optional<int> viability;
};

std::vector<Chain> ChainsOf(CommandInterface interface) {
  using loop::Generator;
  if (interface == CommandInterface::kTorque) {
    return {{"none", Generator::kNone, false, {}}, {"limiter", Generator::kNone, true, {}}};
  }
  const Generator papers = interface == CommandInterface::kJointPosition   ? Generator::kJoint
                           : interface == CommandInterface::kCartesianPose ? Generator::kCartesian
                                                                           : Generator::kNone;
  return {{"none", Generator::kNone, false, {}},
          {"paper's law", papers, false, {}},
          {"paper's law, limiter", papers, true, {}},
          {"paper's law, viability", papers, false, 19},
          {"rejoining", Generator::kRejoining, false, {}},
          {"rejoining, viability", Generator::kRejoining, false, 19}};
}

struct Fault {
  std::string name;
  std::function<void(scenario::Scenario&)> inject;
};

std::vector<Fault> Faults() {
  std::vector<Fault> faults{{"none", [](scenario::Scenario&) {}}};
  for (const std::uint64_t n : {1, 3, 7, 10, 15, 19}) {
    faults.push_back({fmt::format("{} commands lost in a row", n),
                      [n](scenario::Scenario& s) { s.link.command.loss = BurstsOf(n); }});
  }
  faults.push_back(
      {"4 us of jitter, 50 ppm of drift", [](scenario::Scenario& s) {
         s.controller.wake_delay = {faults::NormalDelay{microseconds(20), microseconds(4)}};
         s.controller.clock_drift_ppm = 50;
         s.controller.phase = microseconds(920);
       }});
  faults.push_back({"30 % of wake-ups up to 12 ms late", [](scenario::Scenario& s) {
                      s.controller.wake_delay = LateWakes(0.3, milliseconds(12));
                    }});
  for (const int ms : {2, 5, 10, 20, 50, 100, 200, 500}) {
    faults.push_back({fmt::format("0.2 % of wake-ups {} ms late", ms), [ms](scenario::Scenario& s) {
                        s.controller.wake_delay = {faults::EmpiricalDelay{
                            {Duration::zero(), microseconds(20), milliseconds(ms),
                             milliseconds(ms) + microseconds(1)},
                            {998, 0, 2}}};
                      }});
  }
  return faults;
}

void Print(const Bench& bench, CommandInterface interface, const char* name, const Tempo& tempo) {
  std::printf("\n### %s, %s\n\n| fault |", name, std::string(tempo.name).c_str());
  for (const Chain& chain : ChainsOf(interface)) std::printf(" %s |", chain.name);
  std::printf("\n|---|");
  for (std::size_t i = 0; i < ChainsOf(interface).size(); ++i) std::printf("---|");
  std::printf("\n");
  for (const Fault& fault : Faults()) {
    std::printf("| %s |", fault.name.c_str());
    for (const Chain& chain : ChainsOf(interface)) {
      scenario::Scenario scenario = bench.Make(interface, tempo);
      scenario.tick.generator = chain.generator;
      scenario.tick.limiter = chain.limiter;
      scenario.tick.viability = chain.viability;
      fault.inject(scenario);
      const Outcome outcome = bench.Run(scenario);
      const std::string text =
          outcome.aborted() ? "aborted" : fmt::format("{:.1f}", 1e3 * outcome.deviation);
      std::printf(" %s |", text.c_str());
    }
    std::printf("\n");
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace twin::run::test::chain_runs

int main() {
  using namespace twin::run::test::chain_runs;
  const Bench bench;
  for (const Tempo& tempo : {kGentle, kBrisk, kHard}) {
    Print(bench, CommandInterface::kJointPosition, "Joint positions, mrad", tempo);
    Print(bench, CommandInterface::kJointVelocity, "Joint velocities, mrad", tempo);
    Print(bench, CommandInterface::kCartesianPose, "Poses, mm", tempo);
    Print(bench, CommandInterface::kTorque, "Torques, mrad", tempo);
  }
}
