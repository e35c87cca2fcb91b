#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "application/performance.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/scenario/scenario.h"
#include "twin/teleop/device_registry.h"
#include "twin/teleop/teleoperator_config.h"

namespace twin::application::application_teleoperation_test {
namespace {

using testing::HasSubstr;

scenario::Scenario Shipped() {
  return scenario::Load(test::FileOf("teleoperation"));
}

/// The shipped one with another text in one place.
std::string Refusal(std::string_view from, std::string_view to) {
  std::string text = scenario::ToYaml(Shipped());
  text.replace(text.find(from), from.size(), to);
  try {
    (void)Make(scenario::Parse(text, "task.yaml"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(TeleoperationTest, FetchesTheCanAndSetsItDownOnTheMat) {
  const twin::test::TemporaryFolder folder;
  test::Performance performance(Shipped(), folder.path());
  performance.Perform();
  EXPECT_TRUE(performance.succeeded()) << performance.Story();
  EXPECT_EQ(performance.evaluation.figures.size(), 3U);
  EXPECT_EQ(performance.FiguresOnPage(), 3U);
  // To the can, down to it, up with it, to the mat, down to it, up again.
  EXPECT_EQ(performance.task_result.plans.size(), 6U);
}

TEST(TeleoperationTest, RefusesAScenarioThatNobodyLeads) {
  scenario::Scenario scenario = Shipped();
  scenario.operator_section.reset();
  EXPECT_THROW((void)Make(scenario), InputError);
}

TEST(TeleoperationTest, RefusesAnObjectThatIsNotThere) {
  EXPECT_THAT(Refusal("object: \"can\"", "object: \"cup\""),
              HasSubstr("none of the scenario's objects"));
}

TEST(TeleoperationTest, RefusesTheScriptedPersonOnTheWallClock) {
  EXPECT_THAT(Refusal("drive: lockstep", "drive: realtime"), HasSubstr("for drive: lockstep only"));
}

TEST(TeleoperationTest, TakesNoParametersOfTheScriptedPerson) {
  scenario::Scenario scenario = Shipped();
  scenario.operator_section->parameters = {{.key = "foo", .values = {"1"}}};
  EXPECT_THAT([&] { (void)Make(scenario); },
              testing::ThrowsMessage<InputError>(HasSubstr("operator.parameters.foo")));
}

TEST(TeleoperationTest, GivesAnyoneButTheScriptedPersonHalfAnHour) {
  scenario::Scenario scenario = Shipped();
  EXPECT_EQ(Make(scenario)->longest(scenario), std::chrono::seconds(250));
  scenario.operator_section->device = "evdev";
  EXPECT_EQ(Make(scenario)->longest(scenario), std::chrono::seconds(1810));
  scenario.application->parameters.push_back({.key = "longest", .values = {"60 s"}});
  EXPECT_EQ(Make(scenario)->longest(scenario), std::chrono::seconds(70));
}

TEST(TeleoperationTest, RefusesADeviceThatNobodyKnows) {
  scenario::Scenario scenario = Shipped();
  scenario.operator_section->device = "ouija";
  const teleop::DeviceRegistry devices;
  test::Performance performance(scenario, {}, {}, &devices);
  try {
    performance.Perform();
    FAIL() << "it was taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("\"ouija\" is unknown"));
  }
}

/// A block under the hand, and an operator whose hand holds a haptic device far away.
constexpr std::string_view kContact = R"(name: contact
seed: 4
scene: scenes/floor.xml
objects:
  - {name: block, shape: box, size: [0.3 m, 0.3 m, 0.3 m], on: ground, position: [0.40 m, 0 m, 0 m]}
robot:
  q_start: {unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}
onboard:
  collision_behavior:
    lower_torque: {unit: Nm, values: [10, 10, 10, 10, 8, 8, 8]}
    upper_torque: {unit: Nm, values: [60, 60, 60, 60, 40, 40, 40]}
    lower_force: {force: 10 N, moment: 8 Nm}
    upper_force: {force: 80 N, moment: 60 Nm}
operator:
  device: hand
  to_robot_delay: 300 ms
  to_robot_loss: 10 %
  from_robot_delay: 300 ms
  from_robot_loss: 10 %
  settings: {feedback: {scale: 1, most_force: 20 N, passive: true}, workspace: {touch: true}}
application:
  type: teleoperation
)";

/// What came of it, by the hand's own account.
struct Felt {
  double least_energy = 0;   ///< J, put in at the handle less what came out
  double largest_force = 0;  ///< N
  double swing = 0;          ///< of the handle in the last seconds of pressing, m/s
  double lowest = 0;         ///< of the handle, m
};

/// A hand that holds a handle of 0.3 kg, 120 N/m and 3 Ns/m stiff: it goes down onto the block,
/// presses for some seconds, comes up again and ends.
class HapticHand final : public teleop::Device {
 public:
  explicit HapticHand(Felt& felt) : felt_(felt) {}

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time now) noexcept override {
    constexpr double kT = kCycleSeconds;
    const double t = ToSeconds(now.time_since_epoch());
    // Quickly near it, slowly onto it: bare fingers are hard, and touch hard.
    const double down =
        std::min(0.06 * std::max(t - 1, 0.0), 0.165) + std::min(0.01 * std::max(t - 4, 0.0), 0.065);
    const double up = 0.06 * std::max(t - 18, 0.0);
    const double wanted = std::min(up - down, 0.0);
    v_ += kT * (120 * (wanted - x_) - 3 * v_ + f_) / 0.3;
    x_ += kT * v_;
    energy_ -= f_ * kT * v_;
    felt_.least_energy = std::min(felt_.least_energy, energy_);
    felt_.lowest = std::min(felt_.lowest, x_);
    if (t > 14 && t < 18) felt_.swing = std::max(felt_.swing, std::abs(v_));
    ++sample_.sequence;
    sample_.kind = teleop::AxisKind::kPose;
    sample_.axes[2] = x_;
    sample_.end_presses = t > 23 ? 1 : 0;
    return sample_;
  }
  void Feel(const teleop::OperatorFeedback& feedback) noexcept override {
    f_ = feedback.wrench[2];
    felt_.largest_force = std::max(felt_.largest_force, std::abs(f_));
  }
  [[nodiscard]] bool lost() const noexcept override { return false; }
  [[nodiscard]] std::string Describe() const override { return "a hand at a haptic device"; }

 private:
  Felt& felt_;
  teleop::OperatorSample sample_;
  double x_ = 0;
  double v_ = 0;
  double f_ = 0;
  double energy_ = 0;
};

struct Contact {
  Felt felt;
  bool succeeded = false;
  std::string story;
};

Contact Press(bool passive) {
  Contact contact;
  teleop::DeviceRegistry devices;
  devices.Add("hand", [&contact](const teleop::DeviceRequest&) {
    return std::make_unique<HapticHand>(contact.felt);
  });
  std::string text(kContact);
  if (!passive) text.replace(text.find("passive: true"), 13, "passive: false");
  test::Performance performance(scenario::Parse(text, "contact.yaml"), {}, {}, &devices);
  performance.Perform();
  contact.succeeded = performance.task_result.task.failure.empty();
  contact.story = performance.Story();
  std::printf(
      "passive %d: energy at the port %.2f mJ at least, %.1f N felt, swing %.4f m/s, down "
      "to %.3f m\n",
      static_cast<int>(passive), 1e3 * contact.felt.least_energy, contact.felt.largest_force,
      contact.felt.swing, contact.felt.lowest);
  return contact;
}

/// 300 ms each way and a tenth lost.
TEST(TeleoperationContactTest, StaysBoundedOverABadWire) {
  const Contact contact = Press(true);
  EXPECT_TRUE(contact.succeeded) << contact.story;
  EXPECT_GT(contact.felt.largest_force, 2);  // it was felt
  // Beyond the reserve only what a hand gets that turns around within a period, 20 N at 0.1 m/s.
  EXPECT_GE(contact.felt.least_energy, -teleop::FeedbackConfig().reserve - 2e-3);
  EXPECT_LT(contact.felt.swing, 0.02);
}

TEST(TeleoperationContactTest, WithoutThePassivePortTheHandIsDriven) {
  EXPECT_LT(Press(false).felt.least_energy, -2 * teleop::FeedbackConfig().reserve);
}

}  // namespace
}  // namespace twin::application::application_teleoperation_test
