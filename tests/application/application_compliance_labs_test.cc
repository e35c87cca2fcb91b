// The application `compliance` at both labs, with several seeds.

#include <cstdint>
#include <cstdio>
#include <string>
#include <tuple>

#include <gtest/gtest.h>

#include "application/performance.h"
#include "support/temporary_folder.h"

namespace twin::application::application_compliance_labs_test {
namespace {

class ComplianceLabsTest : public ::testing::TestWithParam<std::tuple<std::string, std::uint64_t>> {
};

TEST_P(ComplianceLabsTest, MeetsEveryDemandThere) {
  const auto& [lab, seed] = GetParam();
  scenario::Scenario scenario = scenario::Load(test::FileOf("compliance"));
  scenario::ApplyLab(scenario::FindLab(lab, test::Models()), scenario);
  scenario.seed = seed;
  const twin::test::TemporaryFolder folder;
  test::Performance performance(scenario, folder.path());
  performance.Perform();
  EXPECT_TRUE(performance.succeeded()) << "seed " << seed;
  std::printf("lab %s, seed %d\n%s", lab.c_str(), static_cast<int>(seed),
              performance.Story().c_str());
}

INSTANTIATE_TEST_SUITE_P(LabsAndSeeds, ComplianceLabsTest,
                         ::testing::Combine(::testing::Values("a", "b"),
                                            ::testing::Values(1U, 2U, 3U)));

}  // namespace
}  // namespace twin::application::application_compliance_labs_test
