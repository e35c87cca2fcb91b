#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/backend/faulty_backend.h"
#include "twin/core/error.h"

namespace twin::backend::backend_fault_plan_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

FaultPlan PlanOf(FaultSchedule FaultPlan::*fault, FaultSchedule schedule, std::uint64_t seed = 1) {
  FaultPlan plan;
  plan.seed = seed;
  plan.*fault = std::move(schedule);
  return plan;
}

constexpr FaultSchedule FaultPlan::*kSchedules[] = {
    &FaultPlan::command_duplicated, &FaultPlan::command_swapped, &FaultPlan::command_delayed,
    &FaultPlan::command_garbage};

/// The text a plan is refused with; empty when it is accepted.
std::string RefusalOf(const FaultPlan& plan) {
  try {
    plan.Validate();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(FaultPlanTest, RefusesAProbabilityOutsideItsRangeByName) {
  const char* names[] = {"command_duplicated", "command_swapped", "command_delayed",
                         "command_garbage"};
  for (std::size_t i = 0; i < std::size(names); ++i) {
    for (const double bad : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
      EXPECT_THAT(RefusalOf(PlanOf(kSchedules[i], {.probability = bad})),
                  HasSubstr(std::string("faults.") + names[i] + ".probability"));
    }
    EXPECT_THAT(RefusalOf(PlanOf(kSchedules[i], {.messages = {3, 9, 9}})),
                AllOf(HasSubstr(names[i]), HasSubstr("messages[2] is 9")));
    EXPECT_THAT(RefusalOf(PlanOf(kSchedules[i], {.messages = {3, 2}})), HasSubstr("messages[1]"));
    EXPECT_EQ(RefusalOf(PlanOf(kSchedules[i], {.probability = 1, .messages = {3, 9}})), "");
  }
  EXPECT_EQ(RefusalOf(FaultPlan()), "");
}

TEST(FaultPlanTest, RefusesAFaultOfCommandsThatAreAllLost) {
  for (const faults::LossModel& all :
       {faults::LossModel(faults::IndependentLoss{1}),
        faults::LossModel(faults::GilbertElliottLoss{0.1, 0.1, 1, 1})}) {
    for (const auto fault : kSchedules) {
      FaultPlan plan = PlanOf(fault, {.probability = 0.1});
      plan.command_loss = all;
      EXPECT_THAT(RefusalOf(plan), HasSubstr("can never strike"));
    }
    EXPECT_EQ(RefusalOf(FaultPlan{.command_loss = all}), "");
  }
}

TEST(FaultPlanTest, RefusesAListedFaultOfACommandThatTheScriptLoses) {
  for (const auto fault : kSchedules) {
    FaultPlan plan = PlanOf(fault, {.messages = {2, 12}});
    plan.command_loss = faults::LossModel(faults::ScriptedLoss{{{10, 5}}});
    EXPECT_THAT(RefusalOf(plan), HasSubstr("messages has 12"));
    plan.command_loss = faults::LossModel(faults::ScriptedLoss{{{13, 5}}});
    EXPECT_EQ(RefusalOf(plan), "");
  }
}

TEST(FaultPlanTest, RefusesWhatASwapLeavesNoRoomFor) {
  EXPECT_THAT(RefusalOf(PlanOf(&FaultPlan::command_swapped, {.messages = {4, 5}})),
              HasSubstr("4 and 5"));
  FaultPlan plan = PlanOf(&FaultPlan::command_swapped, {.messages = {4}});
  for (const std::uint64_t taken : {4, 5}) {
    plan.command_delayed = {.messages = {taken}};
    EXPECT_THAT(RefusalOf(plan),
                HasSubstr("command_delayed.messages has " + std::to_string(taken)));
  }
  plan.command_delayed = {.probability = 0.5, .messages = {3, 6}};
  EXPECT_EQ(RefusalOf(plan), "");
  plan.command_swapped = {.probability = 1};
  EXPECT_THAT(RefusalOf(plan), HasSubstr("command_delayed can never strike"));
}

}  // namespace
}  // namespace twin::backend::backend_fault_plan_test
