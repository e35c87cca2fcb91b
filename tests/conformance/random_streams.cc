// Seeded random command streams against the robot on the ideal plant, watched by StateChecker.
//
//   random_streams --streams 10000 --seed 1    runs streams of the seeds 1, 2, ..., 10000
//   random_streams --streams 1 --seed 4711     runs one again
//
// Prints a summary; of streams that break a rule seed, finding and what is left of the stream when
// all that is not needed for it is taken away. Exit code 0: none broke a rule, and enough of them
// came to a good end.

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "conformance/stream_runner.h"

namespace twin::test {
namespace {

struct Options {
  std::uint64_t streams = 1000;
  std::uint64_t seed = 1;
};

constexpr int kMostReports = 20;
/// Least share of streams that must end without an abort.
constexpr double kLeastGoodEnds = 0.3;

HarnessCase IdealHarness() {
  for (const HarnessCase& harness : Harnesses()) {
    if (harness.plant_kind == robot::PlantKind::kIdeal) return harness;
  }
  return {};
}

void Report(const StreamPlan& plan, const HarnessCase& harness, const std::string& finding) {
  const StreamPlan shrunk = Shrink(
      plan, [&](const StreamPlan& less) { return RunStream(less, harness).finding.has_value(); });
  const Finding last = RunStream(shrunk, harness).finding;
  fmt::print("stream {} breaks a rule: {}\nthe same, shrunk: {}\n{}\n", plan.seed, finding,
             last.value_or("?"), Describe(shrunk));
}

int Run(const Options& options) {
  const HarnessCase harness = IdealHarness();
  std::array<std::uint64_t, kRobotErrorCount> errors{};
  std::uint64_t cycles = 0;
  std::uint64_t good_ends = 0;
  std::uint64_t refused = 0;
  std::uint64_t broken = 0;
  for (std::uint64_t i = 0; i < options.streams; ++i) {
    const StreamPlan plan = DrawPlan(options.seed + i);
    const StreamResult result = RunStream(plan, harness);
    cycles += result.cycles;
    good_ends += result.started && !result.aborted ? 1 : 0;
    refused += result.started ? 0 : 1;
    for (std::size_t e = 0; e < errors.size(); ++e) errors[e] += result.errors.test(e) ? 1 : 0;
    if (!result.finding) continue;
    if (++broken <= kMostReports) Report(plan, harness, *result.finding);
  }
  const double share = static_cast<double>(good_ends) / static_cast<double>(options.streams);
  fmt::print(
      "{} streams from seed {}, {} cycles; {} broke a rule; {} could not start; "
      "{:.1f} % ended without abort\n",
      options.streams, options.seed, cycles, broken, refused, 100 * share);
  for (std::size_t e = 0; e < errors.size(); ++e) {
    if (errors[e] == 0) continue;
    fmt::print("  {:7} {}\n", errors[e], Name(static_cast<RobotError>(e)));
  }
  const bool too_few = options.streams >= 100 && share < kLeastGoodEnds;
  if (too_few) fmt::print("too few streams come to a good end\n");
  return broken > 0 || too_few ? 1 : 0;
}

int Main(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string_view name = argv[i];
    const std::uint64_t value = std::strtoull(argv[i + 1], nullptr, 10);
    if (name == "--streams") options.streams = value;
    if (name == "--seed") options.seed = value;
  }
  return Run(options);
}

}  // namespace
}  // namespace twin::test

int main(int argc, char** argv) {
  return twin::test::Main(argc, argv);
}
