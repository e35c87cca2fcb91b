#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "support/peak_memory.h"
#include "support/temporary_folder.h"
#include "twin/core/clock.h"
#include "twin/sweep/merge.h"

namespace twin::sweep::sweep_scale_test {
namespace {

namespace fs = std::filesystem;

const fs::path kModels = fs::path(TWIN_SOURCE_DIR) / "models";

class SweepScaleTest : public testing::Test {
 protected:
  Sweep SweepOf(int steps, int seeds) {
    const std::string range = ", steps: " + std::to_string(steps) + "}\n";
    std::ofstream(folder_ / "s.yaml")
        << "name: s\nscenario: smoke.yaml\naxes:\n"
        << "  - {key: link.command_loss, from: 0 %, to: 50 %" << range
        << "  - {key: tick.lambda, from: 0.001, to: 0.1" << range << "seeds: " << seeds << "\n";
    return {folder_ / "s.yaml", kModels};
  }

  /// Results as runs would have left them; one of four failed. @returns the mean size of a file.
  std::uintmax_t Invent(const Sweep& sweep) {
    CaseMaker maker(sweep, files_);
    std::uintmax_t bytes = 0;
    for (std::uint64_t run = 0; run < sweep.runs(); ++run) {
      const Case one = sweep.CaseAt(run);
      const std::string address = maker.AddressOf(one);
      const fs::path file = FileOf(folder_, address);
      fs::create_directories(file.parent_path());
      const bool failed = run % 4 == 3;
      const std::string text =
          ToJson({.address = address,
                  .outcome = failed ? "aborted" : "success",
                  .error = failed ? "communication_constraints_violation: 20 commands lost" : "",
                  .served = run,
                  .held = 0,
                  .final_error_rad = 1e-3 / static_cast<double>(run + 1),
                  .deviation_rad = 1.0 / static_cast<double>(run + 3),
                  .deviation_m = {},
                  .duration_s = static_cast<double>(run % 2000) / 1000,
                  .states_hash = "0123456789abcdef",
                  .version = "0.1.0"},
                 one, sweep.file().axes);
      std::ofstream(file) << text;
      bytes += text.size();
    }
    return bytes / sweep.runs();
  }

  const test::TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path();
  const run::RunFiles files_{.models = kModels, .mesh_package = {}, .cache = {}};
};

TEST_F(SweepScaleTest, MergesAMillionRowsInAMinuteAndAGigabyte) {
  const Sweep sweep = SweepOf(1000, 1);
  ASSERT_EQ(sweep.runs(), 1'000'000U);
  const std::uintmax_t bytes = Invent(sweep);
  test::ResetPeakMemory();
  const MonotonicClock clock;
  const Merged merged = Merge(sweep, files_, folder_);
  const double seconds = ToSeconds(clock.Now().time_since_epoch());
  const double megabytes = static_cast<double>(test::PeakMemory()) / 1e6;
  std::cout << "a million rows of " << bytes << " bytes: " << seconds << " s, " << megabytes
            << " MB\n";
  EXPECT_EQ(merged.runs, 1'000'000U);
  EXPECT_EQ(merged.failures, 250'000U);
  EXPECT_LT(seconds, 60);
  EXPECT_LT(megabytes, 1000);
  std::ifstream table(folder_ / "runs.csv");
  EXPECT_EQ(std::count(std::istreambuf_iterator<char>(table), {}, '\n'), 1'000'001);
}

}  // namespace
}  // namespace twin::sweep::sweep_scale_test
