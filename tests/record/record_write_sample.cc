// Writes the log that check_mcap.py checks: record_write_sample FILE.mcap CYCLES
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "record/sample_records.h"
#include "twin/record/recorder.h"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    twin::record::Recorder recorder(argv[1], twin::record::SampleRun(),
                                    twin::record::FullRing::kWait);
    const std::uint64_t cycles = std::strtoull(argv[2], nullptr, 10);
    for (std::uint64_t k = 0; k < cycles; ++k) {
      twin::record::CycleRecord cycle = twin::record::SampleCycle(k);
      // Numbers that the other side can compute too.
      for (std::size_t i = 0; i < twin::kJoints; ++i) {
        cycle.state.q[i] = 0.5 * static_cast<double>(k) + 0.125 * static_cast<double>(i);
      }
      recorder.Put(cycle);
      recorder.Put(twin::record::SampleTick(k));
      if (k % 40 == 0) recorder.Put(twin::record::SampleScene(k));
    }
    recorder.Event(twin::Time(twin::Duration(1)), "mode", "Idle \xe2\x86\x92 Move");
    recorder.Add(twin::record::SamplePlan());
    recorder.Finish();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
