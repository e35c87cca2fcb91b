#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "page/operator_server.h"
#include "twin/page/page_device.h"

namespace twin::page::page_operator_server_test {
namespace {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr const char* kHello = R"({"type":"hello","token":"secret"})";
constexpr const char* kTake = R"({"type":"take"})";
constexpr const char* kStop = R"({"type":"stop"})";

struct SetClock final : Clock {
  [[nodiscard]] Time Now() const noexcept override { return now; }
  Time now{};
};

/// A browser that keeps what it is sent.
struct Browser final : Connection {
  void Send(SharedFrame frame) override { got.push_back(frame->bytes); }
  [[nodiscard]] std::size_t waiting() const noexcept override { return behind; }
  void Authenticate() override { authenticated = true; }
  void Close(std::string_view reason) override { closed = reason; }
  std::vector<std::string> got;
  std::size_t behind = 0;
  bool authenticated = false;
  std::string closed;
};

class OperatorServerTest : public testing::Test {
 protected:
  OperatorServerTest() { server.emplace(Config(), Calls(), channel, clock); }

  static OperatorServerConfig Config() { return {.token = "secret", .welcome = R"("title":"x")"}; }
  OperatorServerCallbacks Calls() {
    return {.status = [] { return R"("t":0)"; },
            .now = [this] { return run_time; },
            .stop = [this] { ++stops; },
            .choose_camera = [this](std::size_t number) { camera = number; },
            .visited = [this] { ++visits; },
            .watched = [this](bool wanted) { watched = wanted; },
            .poses = [this] { return poses; }};
  }
  void Come(Browser& browser, const char* hello = kHello) {
    server->OnConnect(browser);
    server->OnText(browser, hello);
  }
  void Hands(Browser& browser, const std::string& ahead) {
    server->OnText(browser, R"({"type":"hands","axes":[)" + ahead +
                                R"(,0,0,0,0,0],"engaged":true,"sent_ms":7})");
  }
  void Pass(Duration time) {
    clock.now += time;
    server->OnTick();
  }

  SetClock clock;
  Time run_time{};
  OperatorChannel channel;
  PageDevice device{channel, "here", PageDevice::Presses::kAll};
  int stops = 0;
  std::size_t camera = 0;
  int visits = 0;
  bool watched = false;
  std::string poses = R"("bodies":[1])";
  std::optional<OperatorServer> server;
  Browser first;
  Browser second;
};

TEST_F(OperatorServerTest, WelcomesWhoKnowsTheToken) {
  Come(first);
  EXPECT_THAT(first.got, Contains(HasSubstr(R"("type":"welcome","you":1)")));
  EXPECT_THAT(first.closed, IsEmpty());
}

TEST_F(OperatorServerTest, SendsAwayWhoDoesNot) {
  Come(first, R"({"type":"hello","token":"Secret"})");
  EXPECT_EQ(first.closed, "wrong token");
  EXPECT_THAT(first.got, Not(Contains(HasSubstr("welcome"))));
}

TEST_F(OperatorServerTest, WantsTheTokenBeforeAnythingElse) {
  Come(first, kStop);
  EXPECT_EQ(first.closed, "the token comes first");
  EXPECT_EQ(stops, 0);
}

TEST_F(OperatorServerTest, SendsAwayWhoSaysNothing) {
  server->OnConnect(first);
  Pass(milliseconds(4900));
  EXPECT_THAT(first.closed, IsEmpty());
  Pass(milliseconds(200));
  EXPECT_EQ(first.closed, "no token came");
}

TEST_F(OperatorServerTest, TellsNothingToWhoHasNotShownTheToken) {
  server->OnConnect(first);
  Come(second);
  Pass(milliseconds(100));
  EXPECT_THAT(first.got, IsEmpty());
}

TEST_F(OperatorServerTest, EndsTheConnectionOfWhoTalksNonsense) {
  Come(first);
  Come(second);
  server->OnText(first, "nonsense");
  EXPECT_THAT(first.closed, HasSubstr("no message"));
  EXPECT_THAT(second.closed, IsEmpty());
}

TEST_F(OperatorServerTest, HandsOfTheOperatorAreSamples) {
  Come(first);
  server->OnText(first, kTake);
  Hands(first, "0.5");
  const auto sample = device.Read({});
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->axes[0], 0.5);
  EXPECT_EQ(sample->sequence, 1U);
  EXPECT_FALSE(device.Read({}));  // each is read once
}

TEST_F(OperatorServerTest, HandsOfAWatcherAreNone) {
  Come(first);
  Come(second);
  server->OnText(first, kTake);
  Hands(second, "0.5");
  EXPECT_FALSE(device.Read({}));
}

TEST_F(OperatorServerTest, OneOperatesAtATime) {
  Come(first);
  Come(second);
  server->OnText(first, kTake);
  server->OnText(second, kTake);
  EXPECT_THAT(second.got, Contains(HasSubstr(R"("type":"refused","text":"connection 1 operates)")));
  Hands(second, "0.5");
  EXPECT_FALSE(device.Read({}));
}

TEST_F(OperatorServerTest, ControlThatIsGivenBackMayBeTaken) {
  Come(first);
  Come(second);
  server->OnText(first, kTake);
  server->OnText(first, R"({"type":"give_back"})");
  server->OnText(second, kTake);
  Hands(second, "0.25");
  EXPECT_EQ(device.Read({})->axes[0], 0.25);
}

TEST_F(OperatorServerTest, HandsOffWhenTheOperatorGoes) {
  Come(first);
  server->OnText(first, kTake);
  Hands(first, "1");
  server->OnDisconnect(first);
  const auto sample = device.Read({});
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->axes, Vector6{});
  EXPECT_FALSE(sample->engaged);
}

TEST_F(OperatorServerTest, NoSampleComesWithoutAHeartbeat) {
  Come(first);
  server->OnText(first, kTake);
  Hands(first, "1");
  static_cast<void>(device.Read({}));
  Pass(milliseconds(300));
  EXPECT_FALSE(device.Read({}));
}

TEST_F(OperatorServerTest, SilenceOfTwoSecondsTakesControlAway) {
  Come(first);
  Come(second);
  server->OnText(first, kTake);
  Hands(first, "1");
  Pass(milliseconds(1900));
  server->OnText(second, kTake);
  EXPECT_THAT(second.got, Contains(HasSubstr("refused")));
  Pass(milliseconds(200));
  second.got.clear();
  server->OnText(second, kTake);
  EXPECT_THAT(second.got, Not(Contains(HasSubstr("refused"))));
}

TEST_F(OperatorServerTest, AnyoneMayStop) {
  Come(first);
  Come(second);
  server->OnText(first, kTake);
  Hands(first, "1");
  static_cast<void>(device.Read({}));
  server->OnText(second, kStop);
  const auto sample = device.Read({});
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->stop_presses, 1U);
  EXPECT_EQ(sample->axes, Vector6{});
  EXPECT_EQ(stops, 1);
}

TEST_F(OperatorServerTest, OnlyTheOperatorPressesButtons) {
  Come(first);
  Come(second);
  server->OnText(first, kTake);
  server->OnText(second, R"({"type":"press","button":"gripper"})");
  EXPECT_FALSE(device.Read({}));
  server->OnText(first, R"({"type":"press","button":"gripper"})");
  EXPECT_EQ(device.Read({})->gripper_presses, 1U);
}

TEST_F(OperatorServerTest, StopBeforeTheDeviceIsThereStopsIt) {
  Come(first);
  server->OnText(first, kStop);
  PageDevice later(channel, "here", PageDevice::Presses::kAll);
  EXPECT_EQ(later.Read({})->stop_presses, 1U);
}

TEST_F(OperatorServerTest, DeviceOfALaterSessionIsToldOfNoEarlierPress) {
  Come(first);
  server->OnText(first, kTake);
  server->OnText(first, R"({"type":"press","button":"gripper"})");
  PageDevice later(channel, "here", PageDevice::Presses::kFromNow);
  EXPECT_FALSE(later.Read({}));
  server->OnText(first, R"({"type":"press","button":"gripper"})");
  EXPECT_EQ(later.Read({})->gripper_presses, 1U);
}

TEST_F(OperatorServerTest, SessionThatEndsWithItsOperatorIsToldTheEndLast) {
  OperatorServerCallbacks calls = Calls();
  std::vector<std::uint32_t> ends;
  calls.control = [&](bool wanted) {
    const auto sample = device.Read({});
    if (!wanted) ends.push_back(sample ? sample->end_presses : 0);
  };
  server.emplace(Config(), calls, channel, clock);
  Come(first);
  server->OnText(first, kTake);
  server->OnText(first, R"({"type":"give_back"})");
  EXPECT_EQ(ends, std::vector<std::uint32_t>{0});
  EXPECT_EQ(device.Read({})->end_presses, 1U);
}

TEST_F(OperatorServerTest, SessionGoesOnWithoutAnOperatorElsewhere) {
  Come(first);
  server->OnText(first, kTake);
  server->OnText(first, R"({"type":"give_back"})");
  EXPECT_EQ(device.Read({})->end_presses, 0U);
}

/// A server of a robot that stays when a session ends.
class ResumingServerTest : public OperatorServerTest {
 protected:
  ResumingServerTest() {
    OperatorServerCallbacks calls = Calls();
    calls.resume = {.phase = [this] { return phase; },
                    .recover = [this] { return Take(recoveries); },
                    .home = [this] { return Take(homes); }};
    server.emplace(Config(), calls, channel, clock);
    Come(first);
  }
  bool Take(int& requests) {
    requests += grants ? 1 : 0;
    return grants;
  }

  LedSession phase = LedSession::kRests;
  bool grants = true;
  int recoveries = 0;
  int homes = 0;
};

TEST_F(ResumingServerTest, TellsWhatTheSessionDoes) {
  EXPECT_THAT(first.got, Contains(HasSubstr(R"("may_resume":true)")));
  phase = LedSession::kGoesHome;
  Pass(milliseconds(100));
  EXPECT_THAT(first.got, Contains(HasSubstr(R"("session":"goes home","teleop":null)")));
}

TEST_F(ResumingServerTest, OnlyTheOperatorRecoversAndSendsHome) {
  server->OnText(first, R"({"type":"recover"})");
  server->OnText(first, R"({"type":"home"})");
  EXPECT_EQ(recoveries + homes, 0);
  server->OnText(first, kTake);
  server->OnText(first, R"({"type":"recover"})");
  server->OnText(first, R"({"type":"home"})");
  EXPECT_EQ(recoveries, 1);
  EXPECT_EQ(homes, 1);
}

TEST_F(ResumingServerTest, HomeEndsTheSessionThatLeads) {
  server->OnText(first, kTake);
  phase = LedSession::kLeads;
  server->OnText(first, R"({"type":"home"})");
  EXPECT_EQ(device.Read({})->end_presses, 1U);
}

TEST_F(ResumingServerTest, RequestThatIsNotGrantedIsRefusedAndEndsNothing) {
  server->OnText(first, kTake);
  phase = LedSession::kLeads;
  grants = false;
  server->OnText(first, R"({"type":"home"})");
  server->OnText(first, R"({"type":"recover"})");
  EXPECT_FALSE(device.Read({}));
  EXPECT_THAT(first.got, Contains(HasSubstr("wait until the robot leads or rests")));
  EXPECT_THAT(first.got, Contains(HasSubstr("the robot is led already")));
}

TEST_F(OperatorServerTest, RunThatLeadsOnceRefusesToResume) {
  Come(first);
  server->OnText(first, kTake);
  server->OnText(first, R"({"type":"home"})");
  EXPECT_THAT(first.got, Contains(HasSubstr("leads its robot once")));
  EXPECT_THAT(first.got, Contains(HasSubstr(R"("may_resume":false)")));
}

/// A server of a run whose clock may stand.
class PausingServerTest : public OperatorServerTest {
 protected:
  PausingServerTest() {
    OperatorServerCallbacks calls = Calls();
    calls.run_clock = {.is_paused = [this] { return paused; },
                       .pause = [this](bool on) { paused = on; },
                       .why_not = {}};
    server.emplace(Config(), calls, channel, clock);
    Come(first);
    Come(second);
  }
  static constexpr const char* kPause = R"({"type":"pause","on":true})";
  bool paused = false;
};

TEST_F(PausingServerTest, AnyoneWhoWatchesPausesAndResumes) {
  EXPECT_THAT(first.got, Contains(HasSubstr(R"("no_pause":"")")));
  server->OnText(second, kPause);
  EXPECT_TRUE(paused);
  server->OnTick();
  EXPECT_THAT(first.got, Contains(HasSubstr(R"("paused":true)")));
  server->OnText(first, R"({"type":"pause","on":false})");
  EXPECT_FALSE(paused);
}

TEST_F(PausingServerTest, WithAnOperatorOnlyTheOperatorPauses) {
  server->OnText(first, kTake);
  server->OnText(second, kPause);
  EXPECT_FALSE(paused);
  EXPECT_THAT(second.got, Contains(HasSubstr("the operator pauses the run")));
  server->OnText(first, kPause);
  EXPECT_TRUE(paused);
}

TEST_F(PausingServerTest, StopEndsAPause) {
  server->OnText(first, kTake);
  server->OnText(first, kPause);
  server->OnText(second, kStop);
  EXPECT_FALSE(paused);
  EXPECT_EQ(device.Read({})->stop_presses, 1U);
}

TEST_F(OperatorServerTest, RunWhoseClockNeverStandsSaysWhy) {
  OperatorServerCallbacks calls = Calls();
  calls.run_clock.why_not = "it is the wall's";
  server.emplace(Config(), calls, channel, clock);
  Come(first);
  EXPECT_THAT(first.got, Contains(HasSubstr(R"("no_pause":"it is the wall's")")));
  server->OnText(first, R"({"type":"pause","on":true})");
  EXPECT_THAT(first.got, Contains(HasSubstr(R"("type":"refused","text":"it is the wall's")")));
}

TEST_F(OperatorServerTest, TellsTheDeviceWhichJointTurnsAlone) {
  Come(first);
  server->OnText(first, kTake);
  server->OnText(first,
                 R"({"type":"hands","axes":[-1,0,0,0,0,0],"joint":4,"engaged":true,"sent_ms":1})");
  const auto sample = device.Read({});
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->joint, 4);
  EXPECT_EQ(sample->axes[0], -1);
}

TEST_F(OperatorServerTest, EverySampleIsShownToWhoRecords) {
  OperatorServerCallbacks calls = Calls();
  std::vector<std::uint64_t> kept;
  calls.sample = [&](const teleop::OperatorSample& sample) { kept.push_back(sample.sequence); };
  server.emplace(Config(), calls, channel, clock);
  Come(first);
  server->OnText(first, kTake);
  Hands(first, "1");
  server->OnText(first, R"({"type":"press","button":"mode"})");
  EXPECT_EQ(kept, (std::vector<std::uint64_t>{1, 2}));
}

TEST_F(OperatorServerTest, NobodyOperatesWhereOneMayOnlyWatch) {
  OperatorServerConfig config = Config();
  config.watch_only = "a real arm";
  server.emplace(config, Calls(), channel, clock);
  Come(first);
  server->OnText(first, kTake);
  Hands(first, "1");
  EXPECT_FALSE(device.Read({}));
  EXPECT_THAT(first.got, Contains(HasSubstr(R"("refused","text":"a real arm")")));
}

TEST_F(OperatorServerTest, OnlyTheOperatorPointsTheCamera) {
  Come(first);
  Come(second);
  server->OnText(first, kTake);
  server->OnText(second, R"({"type":"camera","number":3})");
  EXPECT_EQ(camera, 0U);
  server->OnText(first, R"({"type":"camera","number":2})");
  EXPECT_EQ(camera, 2U);
}

TEST_F(OperatorServerTest, NextPictureGoesToWhoHasShownTheLast) {
  const auto picture = std::make_shared<const Frame>(Frame{"jpeg", false});
  Come(first);
  Come(second);
  server->OnPicture(picture);
  server->OnText(second, R"({"type":"shown"})");
  server->OnPicture(picture);
  EXPECT_EQ(std::ranges::count(first.got, "jpeg"), 1);
  EXPECT_EQ(std::ranges::count(second.got, "jpeg"), 2);
}

TEST_F(OperatorServerTest, WhoShowsTheSceneGetsPosesAndWantsNoPictures) {
  constexpr const char* kPoses = R"({"type":"poses","bodies":[1]})";
  Come(first, R"({"type":"hello","token":"secret","of":"scene"})");
  Come(second);
  server->OnText(second, R"({"type":"view","of":"scene"})");
  server->OnText(second, R"({"type":"shown"})");  // a picture that was on its way
  EXPECT_EQ(visits, 2);
  Pass(milliseconds(100));
  EXPECT_FALSE(watched);
  server->OnPicture(std::make_shared<const Frame>(Frame{"jpeg", false}));
  EXPECT_THAT(first.got, AllOf(Contains(kPoses), Not(Contains("jpeg"))));
  EXPECT_THAT(second.got, AllOf(Contains(kPoses), Not(Contains("jpeg"))));
}

TEST_F(OperatorServerTest, WhoShowsPicturesGetsNoPoses) {
  Come(first, R"({"type":"hello","token":"secret","of":"scene"})");
  server->OnText(first, R"({"type":"view","of":"pictures"})");
  server->OnConnect(second);  // has not shown the token
  server->OnText(second, R"({"type":"view","of":"scene"})");
  Pass(milliseconds(100));
  EXPECT_TRUE(watched);
  EXPECT_THAT(first.got, Not(Contains(HasSubstr("poses"))));
  EXPECT_THAT(second.got, IsEmpty());
}

TEST_F(OperatorServerTest, NoPosesAreSentBeforeThereIsAScene) {
  poses.clear();
  Come(first, R"({"type":"hello","token":"secret","of":"scene"})");
  Pass(milliseconds(100));
  EXPECT_THAT(first.got, Not(Contains(HasSubstr("poses"))));
}

TEST_F(OperatorServerTest, SkipsPosesForWhoIsBehind) {
  Come(first, R"({"type":"hello","token":"secret","of":"scene"})");
  first.behind = 4;
  Pass(milliseconds(100));
  EXPECT_THAT(first.got, Not(Contains(HasSubstr("poses"))));
}

TEST_F(OperatorServerTest, NoPictureIsWantedWhenNobodyWaitsForOne) {
  Come(first);
  Pass(milliseconds(20));
  EXPECT_TRUE(watched);
  server->OnPicture(std::make_shared<const Frame>(Frame{"jpeg", false}));
  Pass(milliseconds(20));
  EXPECT_FALSE(watched);
}

TEST_F(OperatorServerTest, StatesAreLeftOutForWhoIsBehind) {
  Come(first);
  Come(second);
  first.behind = 10;
  Pass(milliseconds(100));
  EXPECT_THAT(first.got, Not(Contains(HasSubstr(R"("type":"state")"))));
  EXPECT_THAT(second.got, Contains(HasSubstr(R"("type":"state","operator":0,"clients":2)")));
}

TEST_F(OperatorServerTest, FeedbackIsToldWithTheTimeOfTheSampleItAnswers) {
  Come(first);
  server->OnText(first, kTake);
  Hands(first, "1");
  device.Feel({.sequence = 1, .echo = 1, .mode = teleop::Mode::kBase});
  Pass(milliseconds(100));
  EXPECT_THAT(first.got, Contains(HasSubstr(R"("mode":"base")")));
  EXPECT_THAT(first.got, Contains(HasSubstr(R"("echo_ms":7.0)")));
}

TEST_F(OperatorServerTest, WhoComesLaterHearsWhatHappened) {
  run_time = Time(milliseconds(1500));
  server->Tell("error", "joint 3");
  Come(first);
  EXPECT_THAT(first.got, Contains(R"({"type":"event","t":1.500,"kind":"error","text":"joint 3"})"));
}

TEST_F(OperatorServerTest, EveryEventHasTheTimeOfTheRun) {
  Come(first);
  clock.now = Time(std::chrono::seconds(900));  // the server's own clock is not shown
  run_time = Time(milliseconds(2500));
  server->OnText(first, kTake);
  run_time = Time(milliseconds(3500));
  server->OnText(first, kStop);
  EXPECT_THAT(first.got, Contains(HasSubstr(R"("t":2.500,"kind":"control")")));
  EXPECT_THAT(first.got, Contains(HasSubstr(R"("t":3.500,"kind":"stop")")));
}

TEST_F(OperatorServerTest, TheEndIsToldAndNobodyStays) {
  Come(first);
  server->End("it went well", RunEnd::kDone);
  EXPECT_THAT(first.got, Contains(R"({"type":"end","text":"it went well","is_failure":false})"));
  EXPECT_EQ(first.closed, "the run is over");
}

}  // namespace
}  // namespace twin::page::page_operator_server_test
