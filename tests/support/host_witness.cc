// The witness as a program, for tests that are scripts (witness.py): watches until its standard
// input ends, then says what it saw.
//
//   host_witness FIFO_PRIORITY

#include <sys/mman.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "support/witness.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  static_cast<void>(mlockall(MCL_CURRENT | MCL_FUTURE));  // its own page faults are not the host's
  twin::test::Witness witness(std::atoi(argv[1]));
  std::puts("watching");
  std::fflush(stdout);
  while (std::getchar() != EOF) {
  }
  const twin::test::Lateness lateness = witness.End();
  const std::chrono::duration<double, std::milli> most = lateness.most;
  std::printf("{\"in_row\": %lld, \"of_500\": %lld, \"latest_ms\": %.3f}\n",
              static_cast<long long>(lateness.spoilt_in_row),
              static_cast<long long>(lateness.spoilt_of_500), most.count());
}
