// Compares the closed form of the viable set with one found without it: the largest invariant set,
// as a polytope, by iteration. For each joint of the Panda and each n a line of a table.
//   viability_fixed_point [--states N] [--seed S] [--joints 1,2,...] [--lost 0,3,...]
//                         [--least-range]
// With --least-range a second table: the smallest range in which a joint never has to brake both
// ways at once, and what ViableAxis asks for. Exits with 1 when the two sets disagree on a state,
// or a range is admitted that is too small; with 2 for arguments that it does not know.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "reference/fixed_point/fixed_point.h"
#include "support/panda_limits.h"
#include "twin/reference/viability_filter.h"

namespace twin::reference {
namespace {

struct Arguments {
  std::uint64_t states = 1'000'000;
  std::uint64_t seed = 1;
  std::vector<int> joints = {1, 2, 3, 4, 5, 6, 7};
  std::vector<int> lost = {0, 3, 19, 20};
  bool least_range = false;
};

/// @returns the numbers of "1,2,3"; none when one is outside [low, high].
std::vector<int> Numbers(const char* text, int low, int high) {
  std::vector<int> numbers;
  for (const char* at = text;;) {
    char* end = nullptr;
    const long number = std::strtol(at, &end, 10);
    if (end == at || number < low || number > high || (*end != ',' && *end != '\0')) return {};
    numbers.push_back(static_cast<int>(number));
    if (*end == '\0') return numbers;
    at = end + 1;
  }
}

bool Parse(int argc, char** argv, Arguments& arguments) {
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--least-range") {
      arguments.least_range = true;
      continue;
    }
    if (++i == argc) return false;
    if (name == "--states") {
      arguments.states = std::strtoull(argv[i], nullptr, 10);
    } else if (name == "--seed") {
      arguments.seed = std::strtoull(argv[i], nullptr, 10);
    } else if (name == "--joints") {
      arguments.joints = Numbers(argv[i], 1, kJoints);
    } else if (name == "--lost") {
      arguments.lost = Numbers(argv[i], 0, ViableAxis::kMostLost);
    } else {
      return false;
    }
  }
  return arguments.states > 0 && !arguments.joints.empty() && !arguments.lost.empty();
}

AxisBounds BoundsOfJoint(int joint) {
  return BoundsOf(test::PandaLimits(), static_cast<std::size_t>(joint - 1));
}

bool CompareAll(const Arguments& arguments) {
  std::printf(
      "| joint | n | steps | faces | residual | states | viable | near the border |"
      " disagree | differ within |\n|---|---|---|---|---|---|---|---|---|---|\n");
  bool agree = true;
  for (const int joint : arguments.joints) {
    for (const int lost : arguments.lost) {
      const ViableAxis axis(BoundsOfJoint(joint), lost, "joint");
      const FixedPoint found = FixedPointOf(axis.kept(), lost);
      const Agreement agreement = Compare(found, axis, arguments.states, arguments.seed);
      const auto share = [&](std::uint64_t of) {
        return 100 * static_cast<double>(of) / static_cast<double>(agreement.states);
      };
      std::printf("| %d | %d | %d | %zu | %.0e | %llu | %.0f %% | %.0f %% | %llu | %.0e |\n", joint,
                  lost, found.steps, found.set.rows().size(), found.residual,
                  static_cast<unsigned long long>(agreement.states), share(agreement.viable),
                  share(agreement.near_border),
                  static_cast<unsigned long long>(agreement.disagreements),
                  agreement.differ_within);
      std::fflush(stdout);
      agree = agree && agreement.disagreements == 0;
    }
  }
  return agree;
}

bool CompareRanges(const Arguments& arguments) {
  std::printf(
      "\n| joint | n | least range, rad | asked for, rad | range, rad |\n"
      "|---|---|---|---|---|\n");
  bool admitted = true;
  for (const int joint : arguments.joints) {
    for (const int lost : arguments.lost) {
      const ViableAxis axis(BoundsOfJoint(joint), lost, "joint");
      const double least = LeastRange(axis.kept(), lost);
      std::printf("| %d | %d | %.4g | %.4g | %.4g |\n", joint, lost, least, axis.least_range(),
                  axis.kept().q_max - axis.kept().q_min);
      std::fflush(stdout);
      admitted = admitted && least <= axis.least_range() * (1 + 1e-5);
    }
  }
  return admitted;
}

}  // namespace
}  // namespace twin::reference

int main(int argc, char** argv) {
  twin::reference::Arguments arguments;
  if (!twin::reference::Parse(argc, argv, arguments)) {
    std::fprintf(stderr,
                 "usage: viability_fixed_point [--states N] [--seed S] [--joints 1,2,...] "
                 "[--lost 0,3,...] [--least-range]\n");
    return 2;
  }
  const bool agree = twin::reference::CompareAll(arguments);
  const bool admitted = !arguments.least_range || twin::reference::CompareRanges(arguments);
  return agree && admitted ? 0 : 1;
}
