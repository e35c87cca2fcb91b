#include "twin/fci/hand_session.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/fci/frame_reader.h"

namespace twin::fci::fci_hand_session_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// A hand that does one thing at a time, until it is told how it ended.
class FakeHand final : public HandService {
 public:
  HandStart Start(const HandCommand& command) override {
    if (refuses) return {0, BadValue{"width", {}, {}, "in [0, 0.081] m"}};
    if (running != 0) results[running] = HandResult::kAborted;
    running = ++tickets;
    started.push_back(command);
    if (std::holds_alternative<hand::Stop>(command)) End(HandResult::kSuccess);
    return {tickets, {}};
  }
  std::optional<HandResult> Outcome(HandTicket ticket) override {
    const auto found = results.find(ticket);
    return found == results.end() ? std::nullopt : std::optional(found->second);
  }
  void End(HandResult result) { results[std::exchange(running, 0)] = result; }

  bool refuses = false;
  HandTicket tickets = 0;
  HandTicket running = 0;
  std::map<HandTicket, HandResult> results;
  std::vector<HandCommand> started;
};

/// An answer as a client sees it: command, command_id, status.
struct Seen {
  int command = 0;
  int id = 0;
  int status = 0;
  bool operator==(const Seen&) const = default;
};
std::ostream& operator<<(std::ostream& out, const Seen& seen) {
  return out << "{command " << seen.command << ", id " << seen.id << ", status " << seen.status
             << "}";
}

constexpr int kHoming = 1;
constexpr int kGrasp = 2;
constexpr int kMove = 3;
constexpr int kStop = 4;

class HandSessionTest : public ::testing::Test {
 protected:
  explicit HandSessionTest(HandDevice device = HandDevice::kFrankaHand)
      : device_(device),
        session_(
            hand_,
            [this](std::span<const std::byte> bytes) {
              frames_.emplace_back(bytes.begin(), bytes.end());
            },
            device) {}

  std::optional<std::string> Ask(std::uint32_t id, const HandRequest& request) {
    const std::vector<std::byte> frame = device_ == HandDevice::kCobotPump
                                             ? EncodeVacuumRequest(id, request)
                                             : EncodeRequest(id, request);
    FrameReader reader(HeadKind::kHand, 4096);
    std::ranges::copy(frame, reader.Room().begin());
    reader.Received(frame.size());
    return session_.OnFrame(*reader.Next());
  }
  void ConnectIt() {
    ASSERT_EQ(Ask(0, Connect{3, 43210}), std::nullopt);
    frames_.clear();
  }
  std::vector<Seen> TakeSeen() {
    std::vector<Seen> seen;
    for (const auto& frame : std::exchange(frames_, {})) {
      EXPECT_EQ(std::to_integer<std::size_t>(frame[6]), frame.size());
      seen.push_back({std::to_integer<int>(frame[0]), std::to_integer<int>(frame[2]),
                      std::to_integer<int>(frame[10])});
    }
    return seen;
  }

  const HandDevice device_;
  FakeHand hand_;
  std::vector<std::vector<std::byte>> frames_;
  HandSession session_;
};

TEST_F(HandSessionTest, ConnectIsAnsweredWithOurVersionAndOpensTheSession) {
  EXPECT_EQ(Ask(0, Connect{3, 43210}), std::nullopt);
  EXPECT_EQ(session_.udp_port(), 43210);
  ASSERT_EQ(frames_.size(), 1u);
  ASSERT_EQ(frames_[0].size(), 14u);
  EXPECT_EQ(std::to_integer<int>(frames_[0][10]), 0);
  EXPECT_EQ(std::to_integer<int>(frames_[0][12]), 3);
}

TEST_F(HandSessionTest, AnotherVersionIsToldOursAndSentAway) {
  EXPECT_NE(Ask(0, Connect{2, 43210}), std::nullopt);
  EXPECT_EQ(session_.udp_port(), std::nullopt);
  ASSERT_EQ(frames_.size(), 1u);
  EXPECT_EQ(std::to_integer<int>(frames_[0][10]), 1);
  EXPECT_EQ(std::to_integer<int>(frames_[0][12]), 3);
}

TEST_F(HandSessionTest, ClosesAConnectionThatDoesNotBeginWithConnectOrConnectsTwiceOrNowhere) {
  EXPECT_NE(Ask(0, HandCommand(hand::Homing{})), std::nullopt);
  EXPECT_NE(Ask(0, HandCommand(hand::Stop{})), std::nullopt);
  EXPECT_NE(Ask(0, Connect{3, 0}), std::nullopt);
  EXPECT_THAT(hand_.started, IsEmpty());
  ConnectIt();
  EXPECT_NE(Ask(1, Connect{3, 43210}), std::nullopt);
}

TEST_F(HandSessionTest, AnswersWhenTheActionIsOver) {
  ConnectIt();
  const std::vector<std::pair<HandCommand, int>> commands{{hand::Homing{}, kHoming},
                                                          {hand::Grasp{0.02, 0.05, 30}, kGrasp},
                                                          {hand::Move{0.05, 0.1}, kMove}};
  int id = 0;
  for (const HandResult result :
       {HandResult::kSuccess, HandResult::kFail, HandResult::kUnsuccessful, HandResult::kAborted}) {
    for (const auto& [command, number] : commands) {
      EXPECT_EQ(Ask(static_cast<std::uint32_t>(++id), command), std::nullopt);
      session_.OnProgress();
      EXPECT_THAT(TakeSeen(), IsEmpty());
      EXPECT_TRUE(session_.has_pending());
      hand_.End(result);
      session_.OnProgress();
      EXPECT_THAT(TakeSeen(), ElementsAre(Seen{number, id, static_cast<int>(result)}));
      EXPECT_FALSE(session_.has_pending());
    }
  }
}

TEST_F(HandSessionTest, ARefusedCommandFailsAtOnce) {
  ConnectIt();
  hand_.refuses = true;
  EXPECT_EQ(Ask(1, HandCommand(hand::Move{7, 0.1})), std::nullopt);
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kMove, 1, 1}));
  EXPECT_FALSE(session_.has_pending());
}

TEST_F(HandSessionTest, StopIsReadWhileACommandRunsAndAbortsIt) {
  ConnectIt();
  EXPECT_EQ(Ask(1, HandCommand(hand::Homing{})), std::nullopt);
  EXPECT_EQ(Ask(2, HandCommand(hand::Stop{})), std::nullopt);
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kHoming, 1, 3}, Seen{kStop, 2, 0}));
  EXPECT_FALSE(session_.has_pending());
}

TEST_F(HandSessionTest, StopOfNothingIsASuccess) {
  ConnectIt();
  EXPECT_EQ(Ask(1, HandCommand(hand::Stop{})), std::nullopt);
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kStop, 1, 0}));
}

TEST_F(HandSessionTest, ACommandAbortsTheOneBeforeIt) {
  ConnectIt();
  EXPECT_EQ(Ask(1, HandCommand(hand::Move{0.05, 0.1})), std::nullopt);
  EXPECT_EQ(Ask(2, HandCommand(hand::Grasp{0.02, 0.05, 30})), std::nullopt);
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kMove, 1, 3}));
  hand_.End(HandResult::kUnsuccessful);
  session_.OnProgress();
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kGrasp, 2, 2}));
}

class VacuumSessionTest : public HandSessionTest {
 protected:
  VacuumSessionTest() : HandSessionTest(HandDevice::kCobotPump) {}
};

TEST_F(VacuumSessionTest, SpeaksVersionOneOnly) {
  EXPECT_NE(Ask(0, Connect{3, 43210}), std::nullopt);
  ASSERT_EQ(frames_.size(), 1u);
  EXPECT_EQ(std::to_integer<int>(frames_[0][10]), 1);
  EXPECT_EQ(std::to_integer<int>(frames_[0][12]), 1);
  frames_.clear();
  EXPECT_EQ(Ask(0, Connect{1, 43210}), std::nullopt);
  EXPECT_EQ(session_.udp_port(), 43210);
  ASSERT_EQ(frames_[0].size(), 14u);
  EXPECT_EQ(std::to_integer<int>(frames_[0][10]), 0);
}

TEST_F(VacuumSessionTest, AnswersWithItsOwnNumbersWhenTheActionIsOver) {
  EXPECT_EQ(Ask(1, HandCommand(hand::DropOff{})), "Drop Off before Connect");
  ASSERT_EQ(Ask(0, Connect{1, 43210}), std::nullopt);
  frames_.clear();
  const hand::Vacuum vacuum{.vacuum = 60, .profile = 2, .timeout_ms = 700};
  EXPECT_EQ(Ask(1, HandCommand(vacuum)), std::nullopt);
  ASSERT_EQ(hand_.started.size(), 1u);
  EXPECT_EQ(hand_.started[0], HandCommand(vacuum));
  EXPECT_THAT(TakeSeen(), IsEmpty());
  hand_.End(HandResult::kUnsuccessful);
  session_.OnProgress();
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{1, 1, 2}));
  EXPECT_EQ(Ask(2, HandCommand(hand::DropOff{300})), std::nullopt);
  EXPECT_EQ(Ask(3, HandCommand(hand::Stop{})), std::nullopt);
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{2, 2, 3}, Seen{3, 3, 0}));
}

TEST_F(HandSessionTest, FiguresReachTheHand) {
  ConnectIt();
  EXPECT_EQ(Ask(1, HandCommand(hand::Grasp{0.02, 0.05, 30, 0.001, 0.002})), std::nullopt);
  ASSERT_EQ(hand_.started.size(), 1u);
  EXPECT_EQ(hand_.started[0], HandCommand(hand::Grasp{0.02, 0.05, 30, 0.001, 0.002}));
}

}  // namespace
}  // namespace twin::fci::fci_hand_session_test
