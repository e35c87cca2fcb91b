// Walks every word of losses from states at the border of the viable set, and looks whether every
// limit is kept in every cycle: with nothing in flight, for n of 0 to 3; and with commands in
// flight.
//   viability_words [--length L] [--late-length L] [--states S] [--joints N]
// Words of L cycles, S states of each of the first N joints. Exits with 1 at the first limit that
// is broken, and says where.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "reference/all_words.h"

namespace twin::reference {
namespace {

struct Arguments {
  int length = 20;
  int late_length = 14;
  int states = 16;
  std::size_t joints = kJoints;
};

bool Broken(std::size_t joint, int in_flight, int held, const AxisState& x) {
  std::printf("broken: joint %zu, d = %d, n = %d, from q %.17g, dq %.17g, ddq %.17g\n", joint + 1,
              in_flight, held, x.q, x.dq, x.ddq);
  return false;
}

bool WalkAll(const Arguments& arguments, int lost) {
  std::uint64_t walked = 0;
  for (std::size_t joint = 0; joint < arguments.joints; ++joint) {
    const AxisBounds bounds = BoundsOf(test::PandaLimits(), joint);
    const ViableAxis axis = PandaAxis(joint, lost);
    States states(axis, 31);
    for (int i = 0; i < arguments.states; ++i) {
      const AxisState x = states.NextAtBorder();
      for (const Wishes wishes : {Wishes::kUp, Wishes::kDown, Wishes::kSwitching}) {
        AllWords words(wishes, arguments.length);
        if (!words.Walk(axis, bounds, x)) return Broken(joint, 0, lost, x);
        walked += words.walked();
      }
    }
  }
  std::printf("nothing in flight, n = %d: %llu words of %d cycles, every limit kept\n", lost,
              static_cast<unsigned long long>(walked), arguments.length);
  std::fflush(stdout);
  return true;
}

bool WalkAllLate(const Arguments& arguments, int in_flight, int held) {
  std::uint64_t walked = 0;
  const ViabilityInFlight filter(test::PandaLimits(), in_flight, held);
  for (std::size_t joint = 0; joint < arguments.joints; ++joint) {
    States states(filter.axis(joint), 37);
    for (int i = 0; i < arguments.states; ++i) {
      const AxisState x = states.NextAtBorder();
      const LateWorld world(filter, AtBorder(joint, x), false);
      for (const Wishes wishes : {Wishes::kUp, Wishes::kDown, Wishes::kSwitching, Wishes::kGentleUp,
                                  Wishes::kGentleDown}) {
        AllWords words(wishes, arguments.late_length);
        if (!words.Walk(filter, world, joint)) return Broken(joint, in_flight, held, x);
        walked += words.walked();
      }
    }
  }
  std::printf("%d in flight, n = %d: %llu words of %d cycles, every limit kept\n", in_flight, held,
              static_cast<unsigned long long>(walked), arguments.late_length);
  std::fflush(stdout);
  return true;
}

bool Run(const Arguments& arguments) {
  for (const int lost : {0, 1, 2, 3}) {
    if (!WalkAll(arguments, lost)) return false;
  }
  for (const auto& [in_flight, held] : {std::pair{1, 3}, {1, 19}, {2, 5}, {2, 19}}) {
    if (!WalkAllLate(arguments, in_flight, held)) return false;
  }
  return true;
}

}  // namespace
}  // namespace twin::reference

int main(int argc, char** argv) {
  twin::reference::Arguments arguments;
  for (int i = 1; i + 1 < argc; i += 2) {
    const int number = std::atoi(argv[i + 1]);
    if (std::strcmp(argv[i], "--length") == 0) arguments.length = number;
    if (std::strcmp(argv[i], "--late-length") == 0) arguments.late_length = number;
    if (std::strcmp(argv[i], "--states") == 0) arguments.states = number;
    if (std::strcmp(argv[i], "--joints") == 0 && number > 0 && number < 8) {
      arguments.joints = static_cast<std::size_t>(number);
    }
  }
  return twin::reference::Run(arguments) ? 0 : 1;
}
