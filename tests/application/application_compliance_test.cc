// The application `compliance`, in lockstep.

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "application/performance.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/scenario/scenario.h"

namespace twin::application::application_compliance_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

scenario::Scenario Shipped() {
  return scenario::Load(test::FileOf("compliance"));
}

/// The same with other parameters.
scenario::Scenario With(const std::string& parameters) {
  std::string text = scenario::ToYaml(Shipped());
  const std::size_t begin = text.find("  parameters: {", text.find("application:"));
  text.replace(begin, text.find('\n', begin) - begin, "  parameters: {" + parameters + "}");
  return scenario::Parse(text, "task.yaml");
}

plant::Push& PushAt(scenario::Scenario& scenario, std::uint32_t motion) {
  const auto found = std::ranges::find_if(scenario.perturbations, [motion](const auto& one) {
    return std::get<plant::Push>(one).motion == motion;
  });
  return std::get<plant::Push>(*found);
}

double ValueOf(const test::Performance& performance, std::string_view quantity) {
  const Finding* found = performance.Find(quantity);
  return found != nullptr ? found->value : std::nan("");
}

TEST(ComplianceApplicationTest, GivesWayAsItsSpringsSay) {
  const twin::test::TemporaryFolder folder;
  test::Performance performance(Shipped(), folder.path());
  performance.Perform();
  EXPECT_TRUE(performance.succeeded()) << performance.Story();
  EXPECT_EQ(performance.task_result.task.steps.size(), 13U);
  EXPECT_EQ(performance.task_result.plans.size(), 5U);
  EXPECT_EQ(performance.evaluation.figures.size(), 7U);
  EXPECT_EQ(performance.FiguresOnPage(), 7U);
  const report::Figure& friction = performance.evaluation.figures.back();
  EXPECT_EQ(friction.id, "friction");
  EXPECT_EQ(friction.values.at("percent"), 30);
  // 10 N against 1000 and 100 N/m.
  EXPECT_NEAR(ValueOf(performance, "A: deflection under the constant force"), 10, 1);
  EXPECT_NEAR(ValueOf(performance, "B: deflection under the constant force"), 100, 10);
  EXPECT_NEAR(ValueOf(performance, "C: deflection under the constant force"), 10, 1);
  EXPECT_NEAR(ValueOf(performance, "D: deflection under the constant force"), 100, 10);
  // What the robot feels of it.
  EXPECT_NEAR(ValueOf(performance, "D: force of the push, estimated by the robot"), 10, 2);
}

TEST(ComplianceApplicationTest, ASoftArmThatShouldBeStiffIsFound) {
  const twin::test::TemporaryFolder folder;
  test::Performance performance(
      With("stiff: {stiffness: {translation: 100 N/m, rotation: 10 Nm/rad}, damping: {translation: "
           "10 Ns/m, rotation: 5 Nms/rad}}, compliant: {stiffness: {translation: 1000 N/m, "
           "rotation: 100 Nm/rad}, damping: {translation: 100 Ns/m, rotation: 10 Nms/rad}}"),
      folder.path());
  performance.Perform();
  EXPECT_FALSE(performance.succeeded());
  EXPECT_EQ(performance.task_result.task.failure, "");
  for (const char* quantity :
       {"A: largest deflection / that of B", "C: largest deflection / that of D",
        "C0: tracking error, largest"}) {
    const Finding* finding = performance.Find(quantity);
    ASSERT_NE(finding, nullptr) << quantity << '\n' << performance.Story();
    EXPECT_EQ(finding->met, false) << quantity << ": " << finding->value;
  }
}

TEST(ComplianceApplicationTest, RefusesParametersThatAreNotAsTheyShouldBe) {
  const auto refusal = [](const std::string& parameters) -> std::string {
    try {
      (void)Make(With(parameters));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal("speed: 3"), HasSubstr("application.parameters.speed"));
  EXPECT_THAT(refusal("stiff: {stiffness: {translation: 9000 N/m}}"),
              HasSubstr("application.parameters.stiff.stiffness.translation"));
  EXPECT_THAT(refusal("k0: 1 N"), HasSubstr("task.yaml:"));
  EXPECT_THAT(refusal("null_space: {duration: 2 s}"), HasSubstr("null_space.duration"));
}

TEST(ComplianceApplicationTest, RefusesPushesThatCannotBeCompared) {
  const auto refusal = [](const auto& change) -> std::string {
    scenario::Scenario scenario = Shipped();
    change(scenario);
    test::Performance performance(scenario);
    try {
      performance.Perform();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  using scenario::Scenario;
  EXPECT_THAT(refusal([](Scenario& s) { s.perturbations.clear(); }),
              AllOf(HasSubstr("case A"), HasSubstr("has no push")));
  EXPECT_THAT(refusal([](Scenario& s) { s.perturbations.push_back(s.perturbations.front()); }),
              HasSubstr("case A has two pushes"));
  EXPECT_THAT(refusal([](Scenario& s) {
                PushAt(s, 3).force = {0, 11, 0};
              }),
              HasSubstr("A and B differ"));
  EXPECT_THAT(refusal([](Scenario& s) { PushAt(s, 7).motion = 5; }), HasSubstr("leave it out"));
  EXPECT_THAT(refusal([](Scenario& s) {
                PushAt(s, 1).duration = PushAt(s, 3).duration = std::chrono::seconds(2);
              }),
              HasSubstr("at least 2 s, to settle"));
  EXPECT_THAT(refusal([](Scenario& s) { s.record = false; }), HasSubstr("judged by its log"));
}

}  // namespace
}  // namespace twin::application::application_compliance_test
