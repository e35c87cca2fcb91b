#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/sweep/result.h"

namespace twin::sweep::sweep_address_test {
namespace {

namespace fs = std::filesystem;

const fs::path kModels = fs::path(TWIN_SOURCE_DIR) / "models";

/// The address of a run of a sweep with these axes, of a scenario.
std::string AddressOf(const std::string& axes, std::uint64_t run,
                      const std::string& scenario = test::ReadText(kModels /
                                                                   "scenarios/smoke.yaml")) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "base.yaml") << scenario;
  std::ofstream(folder / "s.yaml") << "name: s\nscenario: base.yaml\naxes:\n" << axes;
  const Sweep sweep(folder / "s.yaml", kModels);
  const run::RunFiles files{.models = kModels, .mesh_package = {}, .cache = {}};
  return CaseMaker(sweep, files).AddressOf(sweep.CaseAt(run));
}

constexpr const char* kLoss = "  - {key: link.command_loss, values: [0 %, 1 %]}\n";
constexpr const char* kLambda = "  - {key: tick.lambda, values: [0.01, 0.02]}\n";

TEST(SweepAddressTest, IsThatOfTheRunAndNotOfItsPlaceInTheSweep) {
  const std::string one = AddressOf(kLoss, 1);
  EXPECT_EQ(AddressOf("  - {key: link.command_loss, values: [1 %]}\n", 0), one);
  EXPECT_EQ(AddressOf("  - {key: link.command_loss, values: [1 %, {scripted: "
                      "[{at: 700 ms, count: 5}]}]}\n",
                      0),
            one);
  EXPECT_EQ(AddressOf(std::string(kLoss) + kLambda, 1), AddressOf(std::string(kLambda) + kLoss, 2));
  const std::string smoke = test::ReadText(kModels / "scenarios/smoke.yaml");
  EXPECT_EQ(AddressOf(kLoss, 1, "# a comment\n" + smoke + "seed: 7\n"), one);
}

TEST(SweepAddressTest, ChangesWithWhatTheRunHangsOn) {
  const std::string smoke = test::ReadText(kModels / "scenarios/smoke.yaml");
  const std::string both = std::string(kLoss) + kLambda;
  const std::string maps = "  - {key: tick, values: [{lambda: 0.01}, {lambda: 0.02}]}\n";
  const std::set<std::string> addresses{AddressOf(kLoss, 0),
                                        AddressOf(kLoss, 1),
                                        AddressOf(std::string(kLoss) + "seeds: 2\n", 1),
                                        AddressOf(kLoss, 0, smoke + "controller: {rate: 500 Hz}\n"),
                                        AddressOf(both, 0),
                                        AddressOf(both, 1),
                                        AddressOf(both, 2),
                                        AddressOf(maps, 0),
                                        AddressOf(maps, 1)};
  EXPECT_EQ(addresses.size(), 9U);
}

TEST(SweepAddressTest, OfAScenarioThatNeedsTheNumberIsOfItsWhole) {
  const std::string wrong =
      test::ReadText(kModels / "scenarios/smoke.yaml") + "link: {command_loss: 1}\n";
  EXPECT_NE(AddressOf(kLoss, 0, wrong), AddressOf(kLoss, 1, wrong));
  EXPECT_THROW(static_cast<void>(AddressOf(kLambda, 0, wrong)), InputError);
}

}  // namespace
}  // namespace twin::sweep::sweep_address_test
