// Drives the viability filter with hostile wishes and losses for as many joint-cycles as are asked
// for: viability_streams [--cycles N] [--seed S]. Each joint of the Panda with n of 0, 3, 19 and 20
// gets its share, and one of the FR3 a quarter more; then all joints of late clients, with one and
// two commands in flight, a tenth of it more. Exits with 1 at the first limit that is broken, and
// says where; and when a joint never came near its border, for then nothing was shown.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "reference/hostile_world.h"
#include "reference/late_world.h"
#include "support/fr3_limits.h"
#include "support/panda_limits.h"
#include "twin/reference/viability_filter.h"

namespace twin::reference {
namespace {

constexpr int kLosses[] = {0, 3, 19, 20};

/// @returns whether the bounds were kept, and the border was reached.
bool Drive(const JointLimits& limits, std::size_t joint, int lost, std::uint64_t cycles,
           std::uint64_t seed) {
  const AxisBounds bounds = BoundsOf(limits, joint);
  const ViableAxis axis(bounds, lost, "joint");
  HostileWorld world(lost, seed);
  AxisState x{(bounds.q_min + bounds.q_max) / 2, 0, 0};
  double nearest = 1;
  for (std::uint64_t k = 0; k < cycles; ++k) {
    const double jerk = world.Loses() ? 0 : axis.Nearest(x, world.Wish(x, bounds));
    x = ViableAxis::Step(x, jerk);
    if (!KeepsGiven(x, jerk, bounds)) {
      std::printf(
          "joint %zu, n = %d, seed %llu, cycle %llu: q %.17g, dq %.17g, ddq %.17g, jerk %.17g\n",
          joint + 1, lost, static_cast<unsigned long long>(seed),
          static_cast<unsigned long long>(k), x.q, x.dq, x.ddq, jerk);
      return false;
    }
    if (k % 16 == 0) nearest = std::min(nearest, axis.Margin(x));
  }
  if (nearest > 1e-4) std::printf("joint %zu, n = %d: never near its border\n", joint + 1, lost);
  return nearest <= 1e-4;
}

/// @returns whether a late client kept all limits in each of the worlds, reached the border, and
/// was silent no longer than it may be.
bool DriveLate(int in_flight, std::uint64_t cycles, std::uint64_t seed) {
  const ViabilityInFlight filter(test::PandaLimits(), in_flight);
  std::uint64_t sent = 0;
  double nearest = 1;
  const std::vector<LateWorldOptions> worlds = AllLateWorlds();
  for (std::size_t w = 0; w < worlds.size(); ++w) {
    HostileLateWorld world(filter, worlds[w], seed + 100 * w);
    for (std::uint64_t k = 0; k < cycles; ++k) {
      if (!world.Advance() || world.world().silent() > in_flight ||
          world.world().held() > filter.axis(0).lost()) {
        std::printf("d = %d, world %zu, seed %llu, cycle %llu: broken\n", in_flight, w,
                    static_cast<unsigned long long>(seed), static_cast<unsigned long long>(k));
        return false;
      }
      if (k % 16 == 0) nearest = std::min(nearest, world.Margin());
    }
    sent += world.sent();
  }
  const auto all = static_cast<double>(cycles * worlds.size());
  std::printf("d = %d: %.0f joint-cycles, every limit kept; sent in %.0f %% of the cycles\n",
              in_flight, all * static_cast<double>(kJoints), 100 * static_cast<double>(sent) / all);
  if (nearest > 1e-4) std::printf("d = %d: never near its border\n", in_flight);
  return nearest <= 1e-4;
}

int Run(std::uint64_t cycles, std::uint64_t seed) {
  const unsigned long long each = cycles / (kJoints * std::size(kLosses)) + 1;
  const unsigned long long of_all = each * kJoints;
  for (const int lost : kLosses) {
    for (std::size_t joint = 0; joint < kJoints; ++joint) {
      const std::uint64_t own = seed + 1000 * static_cast<std::uint64_t>(lost) + joint;
      if (!Drive(test::PandaLimits(), joint, lost, each, own)) return 1;
      if (!Drive(test::Fr3Limits(), joint, lost, each / 4 + 1, own)) return 1;
    }
    std::printf("n = %2d: %llu joint-cycles and a quarter of it, every limit kept\n", lost, of_all);
    std::fflush(stdout);
  }
  const std::uint64_t late = cycles / (10 * 2 * kJoints * AllLateWorlds().size()) + 1;
  for (const int in_flight : {1, 2}) {
    if (!DriveLate(in_flight, late, seed)) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace twin::reference

int main(int argc, char** argv) {
  std::uint64_t cycles = 10'000'000;
  std::uint64_t seed = 1;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--cycles") == 0) cycles = std::strtoull(argv[i + 1], nullptr, 10);
    if (std::strcmp(argv[i], "--seed") == 0) seed = std::strtoull(argv[i + 1], nullptr, 10);
  }
  return twin::reference::Run(cycles, seed);
}
