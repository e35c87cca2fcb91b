#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "record/log_fields.h"
#include "record/log_text.h"
#include "record/sample_records.h"
#include "record/temporary_folder.h"
#include "support/panda_limits.h"
#include "twin/core/error.h"
#include "twin/record/log_reader.h"
#include "twin/record/mcap_writer.h"
#include "twin/record/recorder.h"

namespace twin::record::record_log_test {
namespace {

using ::testing::HasSubstr;

/// All entries of a log.
std::vector<LogEntry> Entries(const std::filesystem::path& path) {
  LogReader reader(path);
  std::vector<LogEntry> entries;
  LogEntry entry;
  while (reader.Next(entry)) entries.push_back(entry);
  return entries;
}

/// Compares bit by bit. The numbers of a robot state stand side by side without a gap, so that a
/// quantity which the log forgets is found without naming it here.
void ExpectSame(const record::CycleRecord& a, const record::CycleRecord& b) {
  constexpr std::size_t kBegin = offsetof(RobotState, O_T_EE);
  constexpr std::size_t kEnd = offsetof(RobotState, accelerometer_bottom) + sizeof(Accelerations);
  const auto bytes = [](const RobotState& state) {
    return std::string(reinterpret_cast<const char*>(&state) + kBegin, kEnd - kBegin);
  };
  EXPECT_EQ(bytes(a.state), bytes(b.state));
  EXPECT_EQ(a.at, b.at);
  EXPECT_EQ(a.state.message_id, b.state.message_id);
  EXPECT_EQ(a.state.robot_mode, b.state.robot_mode);
  EXPECT_EQ(a.state.motion_generator_mode, b.state.motion_generator_mode);
  EXPECT_EQ(a.state.controller_mode, b.state.controller_mode);
  EXPECT_EQ(a.state.errors, b.state.errors);
  EXPECT_EQ(a.state.reflex_reason, b.state.reflex_reason);
  EXPECT_EQ(a.state.control_command_success_rate, b.state.control_command_success_rate);
  EXPECT_EQ((std::bit_cast<std::array<std::uint64_t, kJoints>>(a.dddq_d)),
            (std::bit_cast<std::array<std::uint64_t, kJoints>>(b.dddq_d)));
  EXPECT_EQ(a.fate, b.fate);
  EXPECT_EQ(a.lost_in_row, b.lost_in_row);
  EXPECT_EQ(a.dropped, b.dropped);
  EXPECT_EQ(a.violated, b.violated);
  EXPECT_EQ(a.violation.error, b.violation.error);
  EXPECT_EQ(a.violation.axis, b.violation.axis);
  EXPECT_EQ(a.violation.value, b.violation.value);
  EXPECT_EQ(a.violation.limit, b.violation.limit);
  EXPECT_EQ(a.violation.message_id, b.violation.message_id);
  EXPECT_EQ(a.base, b.base);
}

void ExpectSame(const record::TickRecord& a, const record::TickRecord& b) {
  EXPECT_EQ(a.message_id, b.message_id);
  EXPECT_EQ(a.read, b.read);
  EXPECT_EQ(a.written, b.written);
  EXPECT_EQ(a.action, b.action);
  EXPECT_EQ(a.skipped_states, b.skipped_states);
  EXPECT_EQ(a.deposit_time, b.deposit_time);
  EXPECT_EQ(a.q_ext, b.q_ext);
  EXPECT_EQ(a.dq_ext, b.dq_ext);
  EXPECT_EQ(a.margin, b.margin);
  EXPECT_EQ(a.kept_back, b.kept_back);
  EXPECT_EQ(a.stalled, b.stalled);
  EXPECT_EQ(a.command.message_id, b.command.message_id);
  EXPECT_EQ(a.command.q_c, b.command.q_c);
  EXPECT_EQ(a.command.dq_c, b.command.dq_c);
  EXPECT_EQ(a.command.O_T_EE_c, b.command.O_T_EE_c);
  EXPECT_EQ(a.command.O_dP_EE_c, b.command.O_dP_EE_c);
  EXPECT_EQ(a.command.elbow_c, b.command.elbow_c);
  EXPECT_EQ(a.command.valid_elbow, b.command.valid_elbow);
  EXPECT_EQ(a.command.motion_generation_finished, b.command.motion_generation_finished);
  EXPECT_EQ(a.command.tau_J_d, b.command.tau_J_d);
}

void ExpectSame(std::span<const record::PointForce> a, std::span<const record::PointForce> b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].p_W, b[i].p_W);
    EXPECT_EQ(a[i].force_W, b[i].force_W);
  }
}

void ExpectSame(const record::SceneRecord& a, const record::SceneRecord& b) {
  EXPECT_EQ(a.at, b.at);
  EXPECT_TRUE(std::ranges::equal(a.Positions(), b.Positions()));
  ExpectSame(a.Contacts(), b.Contacts());
  ExpectSame(a.Pushes(), b.Pushes());
}

void ExpectSame(const PlanRecord& a, const PlanRecord& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.caption, b.caption);
  EXPECT_EQ(a.from, b.from);
  EXPECT_EQ(a.until, b.until);
  EXPECT_EQ(a.q, b.q);
  EXPECT_EQ(a.path, b.path);
  EXPECT_EQ(a.object, b.object);
  EXPECT_EQ(a.O_T_object, b.O_T_object);
}

/// Records one cycle and reads it back.
record::CycleRecord ThereAndBack(const record::CycleRecord& cycle) {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
  recorder.Put(cycle);
  recorder.Finish();
  return std::get<record::CycleRecord>(Entries(folder / "a.mcap").at(0));
}

TEST(LogReaderTest, GivesBackEveryRecordBitByBitInOrder) {
  const TemporaryFolder folder;
  constexpr int kCycles = 1200;
  {
    Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
    for (int k = 0; k < kCycles; ++k) {
      recorder.Put(SampleCycle(static_cast<std::uint64_t>(k)));
      recorder.Put(SampleTick(static_cast<std::uint64_t>(k)));
    }
    recorder.Finish();
  }
  const auto entries = Entries(folder / "a.mcap");
  ASSERT_EQ(entries.size(), 2U * kCycles);
  for (std::size_t k = 0; k < kCycles; ++k) {
    ExpectSame(std::get<record::CycleRecord>(entries[2 * k]), SampleCycle(k));
    ExpectSame(std::get<record::TickRecord>(entries[2 * k + 1]), SampleTick(k));
    ASSERT_FALSE(HasFailure()) << "cycle " << k;
  }
}

TEST(LogReaderTest, GivesBackScenesBitByBitAmongTheCycles) {
  const TemporaryFolder folder;
  constexpr std::uint64_t kScenes = 9;
  {
    Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
    for (std::uint64_t k = 0; k < kScenes; ++k) {
      recorder.Put(SampleCycle(k));
      recorder.Put(SampleScene(k));
    }
    recorder.Finish();
  }
  const auto entries = Entries(folder / "a.mcap");
  ASSERT_EQ(entries.size(), 2 * kScenes);
  for (std::size_t k = 0; k < kScenes; ++k) {
    ExpectSame(std::get<record::SceneRecord>(entries[2 * k + 1]), SampleScene(k));
  }
}

TEST(LogReaderTest, GivesBackTheFullestScene) {
  record::SceneRecord scene;
  scene.positions = record::SceneRecord::kMostPositions;
  scene.contacts = record::SceneRecord::kMostContacts;
  scene.pushes = record::SceneRecord::kMostPushes;
  scene.qpos.back() = -0.0;
  scene.contact.back() = {{1, 2, 3}, {4, 5, 6}};
  scene.push.back() = {{0, 0, 0}, {0, 0, -9}};
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
  recorder.Put(scene);
  recorder.Finish();
  ExpectSame(std::get<record::SceneRecord>(Entries(folder / "a.mcap").at(0)), scene);
}

TEST(LogReaderTest, GivesBackPlansAfterAllElse) {
  const PlanRecord whole = SamplePlan();
  const PlanRecord bare{.id = "stay", .caption = {}};
  PlanRecord at_zero = bare;
  at_zero.q = JointVector{};
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
  for (const PlanRecord& plan : {whole, bare, at_zero}) recorder.Add(plan);
  recorder.Put(SampleCycle(0));
  recorder.Finish();
  const auto entries = Entries(folder / "a.mcap");
  ASSERT_EQ(entries.size(), 4U);
  ExpectSame(std::get<PlanRecord>(entries[1]), whole);
  ExpectSame(std::get<PlanRecord>(entries[2]), bare);
  ExpectSame(std::get<PlanRecord>(entries[3]), at_zero);
}

TEST(LogReaderTest, GivesBackDefaultsAndZerosWithTheirSign) {
  record::CycleRecord cycle;
  cycle.state.q[0] = -0.0;
  cycle.state.m_ee = -0.0;
  cycle.state.O_T_EE_c = {};
  cycle.state.dq[2] = std::numeric_limits<double>::denorm_min();
  ExpectSame(ThereAndBack(cycle), cycle);
}

TEST(LogReaderTest, GivesBackWhatIsNotANumberWithItsBits) {
  record::CycleRecord cycle;
  cycle.state.q.fill(std::numeric_limits<double>::quiet_NaN());
  cycle.dddq_d[6] = -std::numeric_limits<double>::infinity();
  ExpectSame(ThereAndBack(cycle), cycle);
}

/// A log with these limits. @returns what it says about its run.
RunInfo InfoThereAndBack(const RunInfo& info) {
  const TemporaryFolder folder;
  Recorder(folder / "a.mcap", info, FullRing::kWait).Finish();
  return LogReader(folder / "a.mcap").run();
}

TEST(LogReaderTest, GivesBackTheLimitsExactly) {
  RunInfo info = SampleRun();
  EXPECT_FALSE(InfoThereAndBack(info).limits) << "none were given";
  RunLimits limits{test::PandaLimits(), test::PandaCartesianLimits()};
  limits.joints.q_max[3] = 1.0 / 3;
  limits.cartesian.elbow.dddp_max = 1e4 / 7;
  info.limits = limits;
  const auto back = InfoThereAndBack(info).limits;
  ASSERT_TRUE(back);
  EXPECT_EQ(LimitsToMetadata(*back), LimitsToMetadata(limits));
  EXPECT_EQ(back->joints.q_min, limits.joints.q_min);
  EXPECT_EQ(back->joints.q_max, limits.joints.q_max);
  EXPECT_EQ(back->joints.dq_max, limits.joints.dq_max);
  EXPECT_EQ(back->joints.ddq_max, limits.joints.ddq_max);
  EXPECT_EQ(back->joints.dddq_max, limits.joints.dddq_max);
  EXPECT_EQ(back->joints.tau_max, limits.joints.tau_max);
  EXPECT_EQ(back->joints.dtau_max, limits.joints.dtau_max);
  EXPECT_EQ(back->cartesian.translation.dp_max, limits.cartesian.translation.dp_max);
  EXPECT_EQ(back->cartesian.rotation.ddp_max, limits.cartesian.rotation.ddp_max);
  EXPECT_EQ(back->cartesian.elbow.dddp_max, limits.cartesian.elbow.dddp_max);
}

TEST(LogLimitsTest, WhatIsNoLimitIsRefusedByName) {
  const Metadata good = LimitsToMetadata({test::PandaLimits(), test::PandaCartesianLimits()});
  EXPECT_NO_THROW(static_cast<void>(LimitsFromMetadata(good)));
  for (const char* bad : {"", "1 2 3", "1 2 3 4 5 6 7 8", "1 2 3 4 5 6 x", "1 2 3 4 5 6 7 ",
                          "1  2 3 4 5 6 7", "1,2,3,4,5,6,7", "1 2 3 4 5 6 nan", "1 2 3 4 5 6 0"}) {
    Metadata spoilt = good;
    spoilt["joint.dq_max"] = bad;
    try {
      static_cast<void>(LimitsFromMetadata(spoilt));
      ADD_FAILURE() << "'" << bad << "' was taken";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("dq_max")) << bad;
    }
  }
  for (const auto& [key, value] : good) {
    Metadata spoilt = good;
    spoilt.erase(key);
    EXPECT_THROW(static_cast<void>(LimitsFromMetadata(spoilt)), InputError) << key;
  }
}

TEST(LogReaderTest, TellsWhatWasRun) {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
  recorder.Event(Time(Duration(5)), "mode", "Idle -> Move");
  recorder.Event(Time(Duration(6)), "\x1b[2Jmode", "\x1b]0;title\a");
  recorder.Finish();
  const LogReader reader(folder / "a.mcap");
  EXPECT_EQ(reader.run().scenario, "sample");
  EXPECT_EQ(reader.run().seed, 18446744073709551615ULL);
  EXPECT_EQ(reader.run().version, "0.1.0");
  EXPECT_EQ(reader.run().drive, "lockstep");
  EXPECT_EQ(reader.run().scenario_yaml, SampleRun().scenario_yaml);
  const auto event = std::get<EventRecord>(Entries(folder / "a.mcap").at(0));
  EXPECT_EQ(event.at, Time(Duration(5)));
  EXPECT_EQ(event.kind, "mode");
  EXPECT_EQ(event.text, "Idle -> Move");
  const auto escapes = std::get<EventRecord>(Entries(folder / "a.mcap").at(1));
  EXPECT_EQ(escapes.kind, "?[2Jmode");
  EXPECT_EQ(escapes.text, "?]0;title?");
}

/// A file with one message of the given bytes.
std::string FailureOf(std::string_view topic, std::string_view type, std::string_view data) {
  const TemporaryFolder folder;
  McapWriter writer(folder / "a.mcap");
  writer.AddMetadata(kRunMetadata, {{kSeedKey, "1"}});
  const auto schema = writer.AddSchema(type, "protobuf", "");
  const auto channel = writer.AddChannel(schema, topic, "protobuf");
  std::memcpy(writer.AddMessage(channel, 0, data.size()).data(), data.data(), data.size());
  writer.Finish();
  try {
    Entries(folder / "a.mcap");
  } catch (const InputError& error) {
    return error.what();
  }
  return "no failure";
}

TEST(LogReaderTest, NamesTheFieldOfAMessageThatIsNotAcceptable) {
  pb::Cycle cycle;
  EXPECT_EQ(FailureOf(kCycleTopic, "panda_twin.Cycle", cycle.SerializeAsString()), "no failure");
  cycle.add_q(1);
  EXPECT_THAT(FailureOf(kCycleTopic, "panda_twin.Cycle", cycle.SerializeAsString()),
              HasSubstr("message 1 of the file, on topic /robot/cycle: q has 1 values; it must "
                        "have 7 or none"));
  cycle.Clear();
  cycle.set_fate(static_cast<pb::CommandFate>(3));
  EXPECT_THAT(FailureOf(kCycleTopic, "panda_twin.Cycle", cycle.SerializeAsString()),
              HasSubstr("fate has the unknown value 3"));
  cycle.Clear();
  cycle.add_errors(static_cast<pb::RobotError>(41));
  EXPECT_THAT(FailureOf(kCycleTopic, "panda_twin.Cycle", cycle.SerializeAsString()),
              HasSubstr("an error has the unknown value 41"));
  cycle.Clear();
  cycle.mutable_violation()->set_axis(7);
  EXPECT_THAT(FailureOf(kCycleTopic, "panda_twin.Cycle", cycle.SerializeAsString()),
              HasSubstr("axis of a violation is 7; it must be in [-1, 6]"));
  cycle.Clear();
  cycle.set_at_ns(std::numeric_limits<std::int64_t>::max());
  EXPECT_THAT(FailureOf(kCycleTopic, "panda_twin.Cycle", cycle.SerializeAsString()),
              HasSubstr("a time of 9223372036854775807 ns"));
  EXPECT_THAT(FailureOf(kCycleTopic, "panda_twin.Cycle", "\xff\xff"),
              HasSubstr("not a message of type panda_twin.Cycle"));
  EXPECT_THAT(FailureOf(kCycleTopic, "panda_twin.Tick", ""), HasSubstr("panda_twin.Tick"));
  EXPECT_THAT(FailureOf(kCycleTopic, "panda_twin.Cycle", std::string(70'000, 'x')),
              HasSubstr("at most 65536"));
}

TEST(LogReaderTest, KeepsBackNoJointThatIsNotThere) {
  pb::Tick tick;
  tick.set_kept_back(127);
  EXPECT_EQ(FailureOf(kTickTopic, "panda_twin.Tick", tick.SerializeAsString()), "no failure");
  tick.set_kept_back(128);
  EXPECT_THAT(FailureOf(kTickTopic, "panda_twin.Tick", tick.SerializeAsString()),
              HasSubstr("kept_back is 128; at most 127, a bit for each of 7 joints"));
}

TEST(LogReaderTest, NamesWhatIsTooMuchForAScene) {
  const auto failure = [](const pb::Scene& scene) {
    return FailureOf(kSceneTopic, "panda_twin.Scene", scene.SerializeAsString());
  };
  pb::Scene scene;
  for (int i = 0; i < 96; ++i) scene.add_qpos(i);
  for (int i = 0; i < 16; ++i) scene.add_contacts();
  for (int i = 0; i < 4; ++i) scene.add_pushes();
  EXPECT_EQ(failure(scene), "no failure");
  pb::Scene more = scene;
  more.add_qpos(1);
  EXPECT_THAT(failure(more), HasSubstr("values of qpos are 97; at most 96 are accepted"));
  more = scene;
  more.add_contacts();
  EXPECT_THAT(failure(more), HasSubstr("contacts are 17; at most 16"));
  more = scene;
  more.add_pushes();
  EXPECT_THAT(failure(more), HasSubstr("pushes are 5; at most 4"));
  scene.mutable_contacts(3)->add_p_w(1);
  EXPECT_THAT(failure(scene), HasSubstr("p_W has 1 values; it must have 3 or none"));
}

TEST(LogReaderTest, NamesWhatIsWrongWithAPlan) {
  const auto failure = [](const pb::Plan& plan) {
    return FailureOf(kPlanTopic, "panda_twin.Plan", plan.SerializeAsString());
  };
  pb::Plan plan;
  for (int i = 0; i < 1200; ++i) plan.add_way(i);
  EXPECT_EQ(failure(plan), "no failure");
  plan.add_way(1);
  EXPECT_THAT(failure(plan), HasSubstr("way has 1201 values; it must have 3 for each point"));
  plan.add_way(1);
  plan.add_way(1);
  EXPECT_THAT(failure(plan), HasSubstr("points of way are 401; at most 400"));
  plan.Clear();
  plan.add_q(1);
  EXPECT_THAT(failure(plan), HasSubstr("q has 1 values"));
  plan.Clear();
  plan.add_o_t_object(1);
  EXPECT_THAT(failure(plan), HasSubstr("O_T_object has 1 values"));
}

TEST(LogReaderTest, PassesOverTopicsItDoesNotKnow) {
  EXPECT_EQ(FailureOf("/other", "other.Type", "whatever"), "no failure");
}

TEST(LogReaderTest, RefusesAnMcapFileThatIsNoLog) {
  const TemporaryFolder folder;
  McapWriter(folder / "a.mcap").Finish();
  EXPECT_THROW(LogReader(folder / "a.mcap"), InputError);
}

// The schema is what other programs decode a log by: its enumerators must be those of core.
TEST(LogSchemaTest, NumbersErrorsAsTheRobotDoes) {
  ASSERT_EQ(pb::RobotError_descriptor()->value_count(), static_cast<int>(kRobotErrorCount));
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
    const auto* value = pb::RobotError_descriptor()->FindValueByNumber(static_cast<int>(i));
    ASSERT_NE(value, nullptr);
    EXPECT_EQ(value->name(), twin::Name(static_cast<RobotError>(i)));
  }
}

TEST(LogSchemaTest, NumbersModesAndFatesAsCoreAndRtDo) {
  EXPECT_EQ(pb::COMMAND_FATE_HELD, static_cast<int>(record::CommandFate::kHeld));
  EXPECT_EQ(pb::TICK_ACTION_SKIPPED, static_cast<int>(record::TickAction::kSkipped));
  EXPECT_EQ(pb::ROBOT_MODE_AUTOMATIC_ERROR_RECOVERY,
            static_cast<int>(RobotMode::kAutomaticErrorRecovery));
  EXPECT_EQ(pb::MOTION_GENERATOR_MODE_NONE, static_cast<int>(MotionGeneratorMode::kNone));
  EXPECT_EQ(pb::CONTROLLER_MODE_OTHER, static_cast<int>(ControllerMode::kOther));
}

TEST(Utf8Test, KeepsWellFormedTextAndReplacesTheRest) {
  EXPECT_EQ(ToUtf8("a \xc3\xbc \xe2\x82\xac \xf0\x9f\xa4\x96"),
            "a \xc3\xbc \xe2\x82\xac \xf0\x9f\xa4\x96");
  EXPECT_EQ(ToUtf8("cut \xe2\x82"), "cut ??");
  EXPECT_EQ(ToUtf8("latin \xfc, stray \x80"), "latin ?, stray ?");
  EXPECT_EQ(ToUtf8("overlong \xc0\xaf \xe0\x80\x80"), "overlong ?? ???");
  EXPECT_EQ(ToUtf8("surrogate \xed\xa0\x80"), "surrogate ???");
  EXPECT_EQ(ToUtf8("too high \xf4\x90\x80\x80"), "too high ????");
}

TEST(PrintableTest, ReplacesWhatATerminalObeys) {
  EXPECT_EQ(ToPrintable("a\n\tb \xc3\xbc"), "a\n\tb \xc3\xbc");
  EXPECT_EQ(ToPrintable("\x1b[2J \x7f \r"), "?[2J ? ?");
  EXPECT_EQ(ToPrintable("\xc2\x9b"
                        "2J \xc2\xa0"),
            "??2J \xc2\xa0")
      << "U+009B begins an escape sequence, U+00A0 is a space";
}

}  // namespace
}  // namespace twin::record::record_log_test
