// What a server does with time; sessions as a client sees them are in serve_test.py.

#include "twin/server/server.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "robot/robot_fixture.h"
#include "support/realtime_guard.h"
#include "twin/fci/requests.h"
#include "twin/fci/twin_sign.h"
#include "twin/robot/answer_paced_robot.h"
#include "twin/robot/robot_config.h"
#include "twin/robot/wall_clock_robot.h"

namespace twin::server::server_test {
namespace {

using std::chrono::milliseconds;

constexpr std::uint32_t kLoopback = 0x7f000001;
constexpr Duration kLong = std::chrono::seconds(60);

/// A served robot, its server on a thread of its own.
class ServerTest : public ::testing::Test {
 protected:
  ~ServerTest() override { End(); }

  static robot::RobotConfig Ideal() {
    robot::RobotConfig config = test::PandaRobot();
    config.link = {};
    config.plant_kind = robot::PlantKind::kIdeal;
    return config;
  }
  void Serve(std::unique_ptr<robot::ThreadedRobot> robot, Duration connect_timeout) {
    robot_ = std::move(robot);
    ServerConfig config;
    config.arm_port = 0;
    config.hand_port = 0;
    config.connect_timeout = connect_timeout;
    server_ = std::make_unique<Server>(config, *robot_, port_, changed_, clock_,
                                       [this](std::string_view line) {
                                         const std::scoped_lock lock(mutex_);
                                         lines_.emplace_back(line);
                                         told_.notify_all();
                                       });
    robot_->Begin();
    thread_ = std::jthread([this](const std::stop_token& stop) {
      server_->Run([&] { return stop.stop_requested(); });
    });
  }
  void ServeInLockstep(Duration connect_timeout = kLong) {
    Serve(std::make_unique<robot::AnswerPacedRobot>(
              Ideal(), robot::MakePlant(Ideal()).plant, port_, port_, clock_,
              rt::ThreadSettings{.lock_memory = false}, nullptr, robot::LockstepOptions{}),
          connect_timeout);
  }
  void End() {
    if (!thread_.joinable()) return;
    thread_.request_stop();
    thread_.join();
    robot_->End();
  }

  /// What comes over the stream next: as many bytes, or fewer when it ends before.
  std::vector<std::byte> Receive(fci::TcpStream& stream, std::size_t count) {
    std::vector<std::byte> bytes;
    std::array<std::byte, 1> one{};
    while (bytes.size() < count) {
      std::size_t received = 0;
      const fci::StreamResult result = stream.Receive(one, received);
      if (result == fci::StreamResult::kPending) {
        std::this_thread::sleep_for(milliseconds(1));
      } else if (result != fci::StreamResult::kDone) {
        break;
      } else {
        bytes.push_back(one[0]);
      }
    }
    return bytes;
  }
  void Send(fci::TcpStream& stream, const std::vector<std::byte>& frame) {
    std::size_t sent = 0;
    EXPECT_EQ(stream.Send(frame, sent), fci::StreamResult::kDone);
    EXPECT_EQ(sent, frame.size());
  }
  fci::TcpStream Connect() { return fci::TcpStream::Connect(server_->arm(), kLong); }
  /// A session whose states come to `udp_`.
  fci::TcpStream Session() {
    fci::TcpStream stream = Connect();
    Send(stream, fci::EncodeRequest(0, fci::ArmRequest(fci::Connect{5, udp_.local().port})));
    EXPECT_EQ(Receive(stream, 15).size(), 15u);
    return stream;
  }
  /// Waits for the line: the server may answer its client before it says so.
  bool WasTold(std::string_view what) {
    std::unique_lock lock(mutex_);
    return told_.wait_for(lock, kLong, [&] {
      return std::ranges::any_of(
          lines_, [&](const std::string& line) { return line.find(what) != std::string::npos; });
    });
  }

  const MonotonicClock clock_;
  WakeEvent changed_;
  UdpPort port_{clock_, kLoopback, changed_};
  fci::UdpSocket udp_{clock_, {kLoopback, 0}};
  std::mutex mutex_;
  std::condition_variable told_;
  std::vector<std::string> lines_;
  std::unique_ptr<robot::ThreadedRobot> robot_;
  std::unique_ptr<Server> server_;
  std::jthread thread_;
};

TEST_F(ServerTest, AConnectionThatSaysNothingIsDropped) {
  ServeInLockstep(milliseconds(30));
  fci::TcpStream silent = Connect();
  fci::TcpStream half = Connect();
  Send(half, std::vector<std::byte>(7));
  EXPECT_TRUE(Receive(silent, 1).empty());
  EXPECT_TRUE(Receive(half, 1).empty());
  EXPECT_TRUE(WasTold("no Connect within 0.03 s"));
}

TEST_F(ServerTest, ASessionThatSaysNothingIsNot) {
  ServeInLockstep(milliseconds(30));
  fci::TcpStream session = Session();
  std::this_thread::sleep_for(milliseconds(100));
  Send(session, fci::EncodeRequest(1, fci::ArmRequest(fci::StopMove{})));
  EXPECT_EQ(Receive(session, 13).size(), 13u);
}

TEST_F(ServerTest, SaysThatItIsATwinInLockstepToWhoeverAsksAndHasNoOtherWall) {
  ServeInLockstep();
  fci::TcpStream session = Session();
  const auto sent = [&](std::uint32_t id, std::int32_t wall) {
    Send(session, fci::EncodeRequest(id, fci::ArmRequest(fci::GetCartesianLimit{wall})));
    const auto expected = fci::EncodeCartesianLimitAnswer(
        id, SetterStatus::kSuccess,
        wall == fci::kTwinSign ? fci::TwinSign(fci::TwinKind::kInLockstep) : fci::CartesianLimit());
    return std::pair(Receive(session, expected.size()), expected);
  };
  for (const std::int32_t wall : {0, 1, fci::kTwinSign, -1}) {
    const auto [answer, expected] = sent(static_cast<std::uint32_t>(wall), wall);
    EXPECT_EQ(answer, expected) << wall;
  }
}

TEST_F(ServerTest, SilentConnectionsDoNotKeepClientsOut) {
  ServeInLockstep();
  std::vector<fci::TcpStream> silent;
  silent.reserve(10);
  for (int i = 0; i < 10; ++i) silent.push_back(Connect());
  fci::TcpStream session = Session();
  EXPECT_TRUE(WasTold("connected"));
}

TEST_F(ServerTest, TooManySilentConnectionsKeepNobodyOut) {
  ServeInLockstep();
  std::vector<fci::TcpStream> silent;
  silent.reserve(16);
  for (int i = 0; i < 16; ++i) silent.push_back(Connect());
  fci::TcpStream session = Session();
  EXPECT_TRUE(Receive(silent.front(), 1).empty()) << "the oldest makes room";
  EXPECT_TRUE(WasTold("too many connections"));
}

TEST_F(ServerTest, AnEndWithNothingPendingIsAnOrderlyOne) {
  ServeInLockstep();
  fci::TcpStream session = Session();
  End();
  std::array<std::byte, 1> one{};
  std::size_t received = 0;
  EXPECT_EQ(session.Receive(one, received), fci::StreamResult::kClosed);
}

/// The ideal plant, with something to do at every step, on the robot's thread.
class HookedPlant final : public plant::Plant {
 public:
  explicit HookedPlant(std::function<void(int step)> hook) : hook_(std::move(hook)) {}
  void Reset(const JointVector& q) override { ideal_.Reset(q); }
  std::unique_ptr<const State> Save() const override { return ideal_.Save(); }
  void Restore(const State& state) override { ideal_.Restore(state); }
  void Step(const JointDrive& drive) noexcept override {
    hook_(++steps_);
    ideal_.Step(drive);
  }
  const JointSensors& sensors() const noexcept override { return ideal_.sensors(); }

 private:
  std::function<void(int step)> hook_;
  int steps_ = 0;
  plant::IdealPlant ideal_;
};

TEST_F(ServerTest, TheRobotsThreadAllocatesAndLocksNothingWhileItIsServed) {
  std::optional<test::RealtimeGuard> guard;
  test::RealtimeGuard::Counts counts;
  std::atomic<int> steps = 0;
  const auto hook = [&](int step) {  // on the robot's thread
    if (step == 2) guard.emplace();
    if (step == 600) counts = guard->counts();
    steps = step;
  };
  robot::RobotConfig config = Ideal();
  config.onboard.abort_after_lost = 100'000;  // whatever the machine loses
  Serve(std::make_unique<robot::WallClockRobot>(config, std::make_unique<HookedPlant>(hook), port_,
                                                clock_, rt::ThreadSettings{.lock_memory = false},
                                                nullptr),
        kLong);
  fci::TcpStream session = Session();
  Send(session, fci::EncodeRequest(1, fci::ArmRequest(fci::Move{})));
  EXPECT_EQ(Receive(session, 13).size(), 13u);
  fci::StateBytes bytes;
  while (steps < 600) {
    ASSERT_TRUE(udp_.AwaitUntil(clock_.Now() + kLong));
    const auto datagram = udp_.Receive(bytes);
    RobotState state;
    if (!datagram || fci::Decode(datagram->bytes, state) != fci::DatagramFault::kNone) continue;
    RobotCommand command;
    command.message_id = state.message_id;
    command.q_c = test::kReady;
    fci::CommandBytes out;
    fci::Encode(command, out);
    udp_.Send(out, datagram->from);
  }
  End();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::server::server_test
