#include <string>
#include <utility>

#include <gmock/gmock.h>

#include "devices/pipe_source.h"
#include "plugins/devices/evdev_profile.h"
#include "plugins/devices/evdev_sampler.h"
#include "twin/core/error.h"

namespace twin::devices::devices_evdev_profile_test {
namespace {

using namespace std::chrono_literals;
using teleop::OperatorSample;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(EvdevKindTest, KnowsWhatOneCanLeadWith) {
  EXPECT_EQ(KindOf(SpaceMouse()), EvdevKind::kSpaceMouse);
  EXPECT_EQ(KindOf(Gamepad()), EvdevKind::kGamepad);
}

TEST(EvdevKindTest, KnowsASpaceMouseWhoseAxesAreCalledRelative) {
  EvdevCapabilities has;
  has.rel = {REL_X, REL_Y, REL_Z, REL_RX, REL_RY, REL_RZ};
  EXPECT_EQ(KindOf(has), EvdevKind::kSpaceMouse);
}

TEST(EvdevKindTest, PassesOverMiceAndKeyboards) {
  EvdevCapabilities mouse;
  mouse.rel = {REL_X, REL_Y, REL_WHEEL};
  mouse.keys = {BTN_LEFT, BTN_RIGHT};
  EXPECT_FALSE(KindOf(mouse).has_value());
  EvdevCapabilities keyboard;
  keyboard.keys = {KEY_A, KEY_ENTER};
  EXPECT_FALSE(KindOf(keyboard).has_value());
}

/// A sampler of a device as it usually is.
class Hands {
 public:
  explicit Hands(const EvdevCapabilities& has) : Hands(has, UsualProfile(*KindOf(has), has)) {}
  Hands(const EvdevCapabilities& has, EvdevProfile profile) : sampler_(has, std::move(profile)) {}

  Hands& Move(unsigned type, std::uint16_t code, int value) {
    static_cast<void>(sampler_.Take(Event(type, code, value), now_));
    return *this;
  }
  Hands& Press(std::uint16_t key) { return Move(EV_KEY, key, 1); }
  Hands& Let(std::uint16_t key) { return Move(EV_KEY, key, 0); }
  Hands& Wait(Duration time) {
    now_ += time;
    return *this;
  }
  OperatorSample Sample(bool is_stopped = false) { return sampler_.Sample(now_, is_stopped); }
  EvdevSampler& sampler() { return sampler_; }

 private:
  EvdevSampler sampler_;
  Time now_{};
};

TEST(SpaceMouseTest, TurnsItsAxesIntoTheOperators) {
  // Its own axes are right, towards the operator, down: ahead is -y, left -x, up -z, and so about
  // them.
  const std::pair<std::uint16_t, std::size_t> axes[] = {{ABS_Y, 0},  {ABS_X, 1},  {ABS_Z, 2},
                                                        {ABS_RY, 3}, {ABS_RX, 4}, {ABS_RZ, 5}};
  for (const auto& [code, axis] : axes) {
    Vector6 wanted{};
    wanted[axis] = -0.5;
    EXPECT_EQ(Hands(SpaceMouse()).Move(EV_ABS, code, 175).Sample().axes, wanted) << code;
  }
}

TEST(SpaceMouseTest, IsCutAtFullScale) {
  EXPECT_EQ(Hands(SpaceMouse()).Move(EV_ABS, ABS_X, 900).Sample().axes[1], -1);
}

TEST(SpaceMouseTest, IsInTheMiddleOnceARelativeAxisSaysNothing) {
  EvdevCapabilities has;
  has.rel = {REL_X, REL_Y, REL_Z, REL_RX, REL_RY, REL_RZ};
  Hands hands(has);
  hands.Move(EV_REL, REL_Z, -350);
  EXPECT_EQ(hands.Sample().axes[2], 1);
  EXPECT_EQ(hands.Wait(59ms).Sample().axes[2], 1);
  EXPECT_EQ(hands.Wait(1ms).Sample().axes[2], 0);
}

TEST(GamepadTest, ScalesBetweenItsFlatPartAndItsEnd) {
  // The middle of [-32768, 32767] is -0.5, half of it 32767.5, flat 4096.
  const double value = -0.5 + 4096 + 0.25 * (32767.5 - 4096);
  Hands hands(Gamepad());
  hands.Move(EV_ABS, ABS_Y, static_cast<int>(value));
  EXPECT_NEAR(hands.Sample().axes[0], -0.25, 1.0 / 28000);
}

TEST(GamepadTest, IsAtRestWithinItsFlatPart) {
  EXPECT_EQ(Hands(Gamepad()).Move(EV_ABS, ABS_Y, 4095).Sample().axes[0], 0);
}

TEST(GamepadTest, ReachesFullScaleAtBothEnds) {
  EXPECT_EQ(Hands(Gamepad()).Move(EV_ABS, ABS_RY, 32767).Sample().axes[2], -1);
  EXPECT_EQ(Hands(Gamepad()).Move(EV_ABS, ABS_RY, -32768).Sample().axes[2], 1);
}

TEST(GamepadTest, IsReadOnlyAtTheEndOfAReport) {
  EvdevSampler sampler(Gamepad(), UsualProfile(EvdevKind::kGamepad, Gamepad()));
  EXPECT_FALSE(sampler.Take(Event(EV_ABS, ABS_X, 5), {}));
  EXPECT_TRUE(sampler.Take(Event(EV_SYN, SYN_REPORT, 0), {}));
}

TEST(GamepadTest, HasAButtonForEverything) {
  const std::pair<std::uint16_t, std::uint32_t OperatorSample::*> buttons[] = {
      {BTN_Y, &OperatorSample::mode_presses},    {BTN_A, &OperatorSample::gripper_presses},
      {BTN_X, &OperatorSample::frame_presses},   {BTN_TR, &OperatorSample::scale_presses},
      {BTN_B, &OperatorSample::stop_presses},    {BTN_START, &OperatorSample::release_presses},
      {BTN_SELECT, &OperatorSample::end_presses}};
  for (const auto& [key, presses] : buttons) {
    Hands hands(Gamepad());
    EXPECT_EQ(hands.Press(key).Let(key).Press(key).Sample().*presses, 2u) << key;
  }
}

TEST(GamepadTest, CountsAKeyThatRepeatsItselfOnce) {
  Hands hands(Gamepad());
  EXPECT_EQ(hands.Press(BTN_A).Move(EV_KEY, BTN_A, 2).Press(BTN_A).Sample().gripper_presses, 1u);
}

TEST(GamepadTest, RecentresWhileItsShoulderIsHeld) {
  Hands hands(Gamepad());
  EXPECT_FALSE(hands.Press(BTN_TL).Sample().engaged);
  EXPECT_TRUE(hands.Let(BTN_TL).Sample().engaged);
}

TEST(GamepadTest, LetsEverythingGoWhenItIsUnplugged) {
  Hands hands(Gamepad());
  hands.Move(EV_ABS, ABS_Y, -32768).Press(BTN_TL).Press(BTN_A);
  hands.sampler().LetGo();
  const OperatorSample sample = hands.Sample();
  EXPECT_EQ(sample.axes, Vector6{});
  EXPECT_TRUE(sample.engaged);
  EXPECT_EQ(sample.gripper_presses, 1u);
}

TEST(TwoButtonsTest, GripAndSwitchWhenTheyAreLetGo) {
  Hands hands(SpaceMouse());
  EXPECT_EQ(hands.Press(BTN_0).Sample().gripper_presses, 0u);
  EXPECT_EQ(hands.Let(BTN_0).Sample().gripper_presses, 1u);
  EXPECT_EQ(hands.Press(BTN_1).Let(BTN_1).Sample().mode_presses, 1u);
}

TEST(TwoButtonsTest, StopAtOnceWhenBothAreDown) {
  EXPECT_EQ(Hands(SpaceMouse()).Press(BTN_0).Press(BTN_1).Sample().stop_presses, 1u);
}

TEST(TwoButtonsTest, SayNothingElseAfterAStop) {
  Hands hands(SpaceMouse());
  const OperatorSample sample = hands.Press(BTN_0).Press(BTN_1).Let(BTN_0).Let(BTN_1).Sample();
  EXPECT_EQ(sample.gripper_presses, 0u);
  EXPECT_EQ(sample.mode_presses, 0u);
}

TEST(TwoButtonsTest, ReleaseAStopOnlyWhenLeftIsHeldLong) {
  Hands hands(SpaceMouse());
  EXPECT_EQ(hands.Press(BTN_0).Wait(1999ms).Sample(true).release_presses, 0u);
  EXPECT_EQ(hands.Wait(1ms).Sample(true).release_presses, 1u);
  EXPECT_EQ(hands.Wait(5s).Sample(true).release_presses, 1u);
  EXPECT_EQ(hands.Let(BTN_0).Sample(true).gripper_presses, 0u);
}

TEST(TwoButtonsTest, EndTheSessionWhenRightIsHeldLongInAStop) {
  EXPECT_EQ(Hands(SpaceMouse()).Press(BTN_1).Wait(2s).Sample(true).end_presses, 1u);
}

TEST(TwoButtonsTest, MeanNothingMoreWhenHeldWithoutAStop) {
  const OperatorSample sample = Hands(SpaceMouse()).Press(BTN_1).Wait(9s).Sample(false);
  EXPECT_EQ(sample.end_presses, 0u);
}

TEST(TwoButtonsTest, DoNotReleaseWhatTheyHaveJustStopped) {
  Hands hands(SpaceMouse());
  EXPECT_EQ(hands.Press(BTN_0).Press(BTN_1).Wait(9s).Sample(true).release_presses, 0u);
}

/// The usual profile, changed by one parameter.
EvdevProfile With(const EvdevCapabilities& has, const std::string& key, const std::string& value) {
  EvdevProfile profile = UsualProfile(*KindOf(has), has);
  const control::Parameters parameters{{.key = key, .values = {value}}};
  control::ParameterReader reader(parameters, "operator.device");
  ApplyParameters(reader, has, profile);
  reader.RefuseUnread();
  return profile;
}

TEST(EvdevParametersTest, GiveAnAxisAnotherSource) {
  Hands hands(Gamepad(), With(Gamepad(), "axes.rx", "-ABS_X"));
  EXPECT_EQ(hands.Move(EV_ABS, ABS_X, 32767).Sample().axes[3], -1);
}

TEST(EvdevParametersTest, LeaveAnAxisOut) {
  Hands hands(Gamepad(), With(Gamepad(), "axes.y", "none"));
  EXPECT_EQ(hands.Move(EV_ABS, ABS_X, 32767).Sample().axes[1], 0);
}

TEST(EvdevParametersTest, GiveAButtonAnotherKey) {
  Hands hands(Gamepad(), With(Gamepad(), "buttons.stop", "BTN_SELECT"));
  EXPECT_EQ(hands.Press(BTN_B).Sample().stop_presses, 0u);
  EXPECT_EQ(hands.Press(BTN_SELECT).Sample().stop_presses, 1u);
}

TEST(EvdevParametersTest, TakeTwoButtonsTheirOtherMeanings) {
  Hands hands(SpaceMouse(), With(SpaceMouse(), "buttons.stop", "BTN_0"));
  EXPECT_EQ(hands.Press(BTN_0).Sample().stop_presses, 1u);
}

TEST(EvdevParametersTest, RefuseNamesThatAreNone) {
  EXPECT_THAT([] { With(Gamepad(), "axes.x", "sideways"); },
              ThrowsMessage<InputError>(HasSubstr("operator.device.axes.x: is no axis")));
  EXPECT_THAT([] { With(Gamepad(), "buttons.mode", "RED"); },
              ThrowsMessage<InputError>(HasSubstr("operator.device.buttons.mode: is no key")));
}

TEST(EvdevParametersTest, RefuseWhatTheDeviceDoesNotHave) {
  EXPECT_THAT([] { With(Gamepad(), "axes.x", "ABS_WHEEL"); },
              ThrowsMessage<InputError>(HasSubstr("\"Gamepad in a test\" has no such axis")));
  EXPECT_THAT([] { With(SpaceMouse(), "buttons.mode", "BTN_SOUTH"); },
              ThrowsMessage<InputError>(HasSubstr("has no such key")));
}

}  // namespace
}  // namespace twin::devices::devices_evdev_profile_test
