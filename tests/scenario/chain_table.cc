// Prints how chains compare: deviation from the plan under bursts of lost commands, late and
// stalled sources, jitter and drift. The table of src/reference/CHAINS.md.
#include <array>
#include <cstdio>
#include <string>

#include <fmt/format.h>

#include "scenario/chain_runs.h"

namespace twin::scenario::test::chain_runs {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

struct Chain {
  const char* name;
  loop::Generator generator;
  bool limiter;
  std::optional<int> viability;
};

loop::Generator PapersOf(CommandInterface interface) {
  switch (interface) {
    case CommandInterface::kJointPosition: return loop::Generator::kJoint;
    case CommandInterface::kCartesianPose: return loop::Generator::kCartesian;
    default: return loop::Generator::kNone;
  }
}

std::vector<Chain> ChainsOf(CommandInterface interface) {
  const loop::Generator papers = PapersOf(interface);
  return {{"raw stream", loop::Generator::kNone, false, {}},
          {"paper's law", papers, false, {}},
          {"paper's law, limiter", papers, true, {}},
          {"paper's law, viability", papers, false, 19},
          {"rejoining", loop::Generator::kRejoining, false, {}},
          {"rejoining, viability", loop::Generator::kRejoining, false, 19}};
}

void Use(const Chain& chain, Scenario& scenario) {
  scenario.tick.generator = chain.generator;
  scenario.tick.limiter = chain.limiter;
  scenario.tick.viability = chain.viability;
}

struct Fault {
  std::string name;
  std::function<void(Scenario&)> inject;
};

std::vector<Fault> Faults() {
  std::vector<Fault> faults{{"none", [](Scenario&) {}}};
  for (const std::uint64_t n : {1, 3, 7, 10, 15, 19}) {
    faults.push_back(
        {fmt::format("bursts {}", n), [n](Scenario& s) { s.link.command.loss = BurstsOf(n); }});
  }
  faults.push_back(
      {"jitter 4 us, 50 ppm", [](Scenario& s) {
         s.controller.wake_delay = {rt::NormalDelay{microseconds(20), microseconds(4)}};
         s.controller.clock_drift_ppm = 50;
         s.controller.phase = microseconds(920);
       }});
  faults.push_back({"30 % wakes <= 12 ms late", [](Scenario& s) {
                      s.controller.wake_delay = LateWakes(0.3, milliseconds(12));
                    }});
  for (const int ms : {2, 5, 10, 20, 50, 100, 200, 500}) {
    faults.push_back({fmt::format("stalls {} ms", ms), [ms](Scenario& s) {
                        s.controller.wake_delay = {rt::EmpiricalDelay{
                            {Duration::zero(), microseconds(20), milliseconds(ms),
                             milliseconds(ms) + microseconds(1)},
                            {998, 0, 2}}};
                      }});
  }
  return faults;
}

void Print(const Bench& bench, CommandInterface interface, const char* name, const Tempo& tempo) {
  std::printf("\n%s, %s\n%-26s", name, std::string(tempo.name).c_str(), "");
  for (const Chain& chain : ChainsOf(interface)) std::printf(" %24s", chain.name);
  std::printf("\n");
  for (const Fault& fault : Faults()) {
    std::printf("%-26s", fault.name.c_str());
    for (const Chain& chain : ChainsOf(interface)) {
      Scenario scenario = bench.Make(interface, tempo);
      Use(chain, scenario);
      fault.inject(scenario);
      const Outcome outcome = bench.Run(scenario);
      std::printf(" %24s",
                  outcome.aborted()
                      ? outcome.result.report.failure.substr(0, 24).c_str()
                      : fmt::format("{:.2f} ({:.2f})", 1e3 * outcome.deviation, 1e3 * outcome.last)
                            .c_str());
      std::fflush(stdout);
    }
    std::printf("\n");
  }
}

}  // namespace
}  // namespace twin::scenario::test::chain_runs

int main(int argc, char** argv) {
  using namespace twin::scenario::test::chain_runs;
  const Bench bench;
  for (const Tempo& tempo : {kGentle, kBrisk, kHard}) {
    if (argc > 1) {
      Print(bench, CommandInterface::kCartesianPose, argv[1], tempo);
      continue;
    }
    Print(bench, CommandInterface::kJointPosition, "joint positions", tempo);
    Print(bench, CommandInterface::kJointVelocity, "joint velocities", tempo);
    Print(bench, CommandInterface::kCartesianPose, "poses", tempo);
  }
}
