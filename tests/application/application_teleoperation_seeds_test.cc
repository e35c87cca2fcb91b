// What teleoperation bears: fifty drawn tasks; and over a wire that is late and loses.
#include <gtest/gtest.h>

#include "application/seeds.h"
#include "twin/scenario/scenario.h"

namespace twin::application::application_teleoperation_seeds_test {
namespace {

using std::chrono::milliseconds;
using test::Draw;

scenario::Scenario Shipped() {
  return scenario::Load(test::FileOf("teleoperation"));
}

TEST(TeleoperationSeedsTest, AllDrawnTasksSucceed) {
  EXPECT_EQ(Draw(Shipped(), "shipped", 50).succeeded, 50);
}

TEST(TeleoperationSeedsTest, AllWhenTheWireIsLateAndLoses) {
  scenario::Scenario scenario = Shipped();
  for (scenario::DirectionSection* direction :
       {&scenario.operator_section->to_robot, &scenario.operator_section->from_robot}) {
    direction->delay.law = faults::ConstantDelay{milliseconds(300)};
    direction->loss.law = scenario::IndependentLoss{10};
  }
  EXPECT_EQ(Draw(scenario, "300 ms and 10 % lost each way", 10).succeeded, 10);
}

}  // namespace
}  // namespace twin::application::application_teleoperation_seeds_test
