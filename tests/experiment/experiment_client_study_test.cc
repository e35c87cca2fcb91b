#include <filesystem>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiment/client_study.h"
#include "support/temporary_folder.h"
#include "twin/fci/datagrams.h"
#include "twin/record/pcapng_writer.h"

namespace twin::experiment::experiment_client_study_test {
namespace {

using std::chrono::microseconds;
using ::testing::ElementsAre;
using ::testing::SizeIs;

record::CycleRecord Cycle(std::uint64_t id, record::CommandFate fate,
                          std::uint32_t lost_in_row = 0) {
  record::CycleRecord record;
  record.state.message_id = id;
  record.state.robot_mode =
      fate == record::CommandFate::kNone ? RobotMode::kIdle : RobotMode::kMove;
  record.fate = fate;
  record.lost_in_row = lost_in_row;
  return record;
}

TEST(MotionTallyTest, TellsMotionsApartAndCountsEach) {
  MotionTally tally;
  tally.Put(Cycle(1, record::CommandFate::kNone));
  tally.Put(Cycle(2, record::CommandFate::kServed));
  tally.Put(Cycle(3, record::CommandFate::kHeld, 1));
  tally.Put(Cycle(4, record::CommandFate::kHeld, 2));
  tally.Put(Cycle(5, record::CommandFate::kServed));
  tally.Put(Cycle(6, record::CommandFate::kNone));
  tally.Put(Cycle(7, record::CommandFate::kServed));
  record::CycleRecord reflex = Cycle(8, record::CommandFate::kNone);
  reflex.state.robot_mode = RobotMode::kReflex;
  reflex.state.reflex_reason.set(static_cast<std::size_t>(RobotError::kCartesianReflex));
  tally.Put(reflex);

  ASSERT_THAT(tally.motions(), SizeIs(2));
  EXPECT_EQ(tally.motions()[0].counts.served, 2u);
  EXPECT_EQ(tally.motions()[0].counts.held, 2u);
  EXPECT_EQ(tally.motions()[0].HowItEnded(), "");
  EXPECT_EQ(tally.motions()[1].HowItEnded(), ", aborted by [\"cartesian_reflex\"]");
  EXPECT_EQ(tally.counts().longest_loss, 2u);
  EXPECT_DOUBLE_EQ(tally.counts().unserved_percent(), 40);
  EXPECT_THAT(tally.lost_in_row(), ElementsAre(0, 1, 2, 0, 0));
  EXPECT_FALSE(tally.is_full());
}

TEST(MotionTallyTest, ACommandBelongsToTheMotionWhoseNextCycleTakesIt) {
  MotionTally tally;
  tally.Put(Cycle(10, record::CommandFate::kServed));
  tally.Put(Cycle(11, record::CommandFate::kServed));
  EXPECT_FALSE(tally.IsInMotion(8));
  EXPECT_TRUE(tally.IsInMotion(9));
  EXPECT_TRUE(tally.IsInMotion(10));
  EXPECT_FALSE(tally.IsInMotion(11));
}

TEST(WireTimesTest, TakesTheFirstAnswerToEachState) {
  const twin::test::TemporaryFolder folder;
  const std::filesystem::path path = folder / "wire.pcapng";
  constexpr record::PacketEnd kServer{0x7f000001, 40000};
  constexpr record::PacketEnd kClient{0x7f000001, 40001};
  record::PcapngWriter writer(path);
  const auto state = [&](std::uint64_t id, int at_us) {
    RobotState sent;
    sent.message_id = id;
    fci::StateBytes bytes{};
    fci::Encode(sent, bytes);
    writer.Add({.at = Time(microseconds(at_us)), .from = kServer, .to = kClient, .bytes = bytes});
  };
  const auto command = [&](std::uint64_t id, int at_us) {
    RobotCommand answer;
    answer.message_id = id;
    fci::CommandBytes bytes{};
    fci::Encode(answer, bytes);
    writer.Add({.at = Time(microseconds(at_us)), .from = kClient, .to = kServer, .bytes = bytes});
  };
  state(1, 1000);
  command(1, 1100);
  command(1, 1200);  // again
  state(2, 2000);    // is never answered
  state(3, 3000);
  command(9, 3010);  // of no state
  command(3, 3050);
  writer.Finish();

  const std::vector<Answer> answers = AnswersOf(path);
  ASSERT_THAT(answers, SizeIs(2));
  EXPECT_EQ(answers[0].message_id, 1u);
  EXPECT_NEAR(answers[0].received_s - answers[0].sent_s, 100e-6, 1e-9);
  EXPECT_EQ(answers[1].message_id, 3u);
  EXPECT_NEAR(answers[1].received_s - answers[1].sent_s, 50e-6, 1e-9);
}

TEST(ClientProcessTest, TellsHowItEnded) {
  const auto end_of = [](const char* command) {
    ClientProcess client(command);
    while (!client.HasEnded()) {
    }
    return client.HowItEnded();
  };
  EXPECT_EQ(end_of("exit 3"), "exit code 3");
  EXPECT_EQ(end_of("kill -9 $$"), "signal 9");
  EXPECT_EQ(end_of("no_such_program_of_ours 2>/dev/null"), "exit code 127");
}

TEST(ClientProcessTest, IsEndedWithItsOwner) {
  { const ClientProcess client("exec sleep 1000"); }  // would hang here, were it not
}

}  // namespace
}  // namespace twin::experiment::experiment_client_study_test
