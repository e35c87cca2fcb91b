#include "twin/replay/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "replay/sample_log.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::replay::replay_recording_test {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::SizeIs;

/// A log of `cycles` milliseconds, closed. @param more  adds what else there is.
template <class More>
std::filesystem::path WriteLog(const twin::test::TemporaryFolder& folder,
                               const scenario::Scenario& scenario, std::uint64_t cycles,
                               More&& more) {
  std::filesystem::path path = folder / "run.mcap";
  record::Recorder recorder(path, test::InfoOf(scenario), record::FullRing::kWait);
  for (std::uint64_t k = 0; k < cycles; ++k) recorder.Put(test::CycleAt(k));
  more(recorder);
  recorder.Finish();
  return path;
}

void Nothing(record::Recorder& /*recorder*/) {}

std::string FailureOf(const std::filesystem::path& log) {
  try {
    const Recording recording(log, test::Files());
  } catch (const InputError& error) {
    return error.what();
  }
  return "no failure";
}

std::vector<double> Positions(std::span<const double> qpos) {
  return {qpos.begin(), qpos.end()};
}

TEST(RecordingTest, GivesTheScenesAsTheyWereRecorded) {
  const twin::test::TemporaryFolder folder;
  const plant::CompiledModel model = test::ModelOf(test::Sample());
  record::SceneRecord touched = test::SceneAt(Time(milliseconds(80)), model);
  touched.contacts = 1;
  touched.contact[0] = {{1, 2, 3}, {4, 5, 6}};
  const auto log = WriteLog(folder, test::Sample(), 100, [&](record::Recorder& recorder) {
    recorder.Put(test::SceneAt(Time(), model));
    recorder.Put(test::SceneAt(Time(milliseconds(40)), model));
    recorder.Put(touched);
  });
  const Recording recording(log, test::Files());
  EXPECT_EQ(recording.source(), FrameSource::kScenes);
  EXPECT_FALSE(recording.truncated());
  ASSERT_EQ(recording.snapshots().size(), 3U);
  EXPECT_EQ(recording.snapshots().time(2), touched.at);
  EXPECT_EQ(Positions(recording.snapshots().qpos(2)), Positions(touched.Positions()));
  EXPECT_EQ(recording.snapshots().scene(2).Contacts()[0].force_W, (Vector3{4, 5, 6}));
}

TEST(RecordingTest, SamplesTheArmWhereThereAreNoScenes) {
  const twin::test::TemporaryFolder folder;
  scenario::Scenario scenario = test::Sample();
  scenario.render.fps = 30;
  const Recording recording(WriteLog(folder, scenario, 1001, Nothing), test::Files());
  EXPECT_EQ(recording.source(), FrameSource::kStates);
  EXPECT_EQ(recording.snapshots().fps(), 30);
  ASSERT_EQ(recording.snapshots().size(), 31U) << "at 0, 1/30, ... 1 s";
  // The first cycle at or after 4/30 s = 133.3 ms.
  EXPECT_EQ(recording.snapshots().time(4), Time(milliseconds(134)));
}

TEST(RecordingTest, PutsTheArmAndAllElseWhereThePlantHasThem) {
  const twin::test::TemporaryFolder folder;
  const scenario::Scenario scenario = test::Sample();
  const Recording recording(WriteLog(folder, scenario, 500, Nothing), test::Files());
  const scenario::RobotData robot =
      scenario::LoadRobotData(test::Files().models, scenario.robot.model, scenario.robot.hand);
  const auto plant =
      plant::MujocoPlant::Create(run::MakeRobotConfig(scenario, robot, test::Files()).plant);
  const std::size_t last = recording.snapshots().size() - 1;
  plant->Reset(test::ArmAt(recording.snapshots().time(last)));
  std::vector<double> expected(plant->qpos_size());
  plant->CopyQpos(expected);
  EXPECT_EQ(Positions(recording.snapshots().qpos(last)), expected);
}

TEST(RecordingTest, SamplesAsOftenAsIsAskedForWhereThereAreNoScenes) {
  const twin::test::TemporaryFolder folder;
  const auto log = WriteLog(folder, test::Sample(), 101, Nothing);
  const Recording recording(log, test::Files(), 200);
  EXPECT_EQ(recording.snapshots().fps(), 200);
  EXPECT_EQ(recording.snapshots().size(), 21U);
}

TEST(RecordingTest, RefusesATimeThatWouldFillTheMemory) {
  const twin::test::TemporaryFolder folder;
  const auto log = WriteLog(folder, test::Sample(), 10, [](record::Recorder& recorder) {
    recorder.Put(test::CycleAt(100'000'000'000));
  });
  EXPECT_THAT(FailureOf(log), HasSubstr("its cycles span 100000000 s"));
}

TEST(RecordingTest, FilmsPlansAsGoalsAndSaysWhatHappened) {
  const twin::test::TemporaryFolder folder;
  const record::PlanRecord plan{.id = "goal",
                                .caption = "Round the box; right, when it is done",
                                .from = Time(milliseconds(20)),
                                .until = Time(milliseconds(70)),
                                .q = JointVector{1, 2, 3},
                                .path = {{0.1, 0.2, 0.3}}};
  const auto log = WriteLog(folder, test::Sample(), 100, [&](record::Recorder& recorder) {
    recorder.Event(Time(milliseconds(10)), "session", "motion 1: goal");
    recorder.Event(Time(milliseconds(30)), "step", "grasp: done, 3 N, \xc2\xb1 1 N");
    recorder.Event(Time(milliseconds(40)), "error", std::string(100, 'x'));
    recorder.Event(Time(milliseconds(50)), "step",
                   "lift: failed, it is \xc3\xbc"
                   "ber");
    recorder.Add(plan);
  });
  const Recording recording(log, test::Files());
  const render::Film film = recording.Film();
  EXPECT_THAT(film.title, testing::StartsWith("smoke\n"));
  ASSERT_THAT(film.goals, SizeIs(1));
  EXPECT_EQ(film.goals[0].from, plan.from);
  EXPECT_EQ(film.goals[0].until, plan.until);
  EXPECT_EQ(film.goals[0].q, plan.q);
  EXPECT_EQ(film.goals[0].path, plan.path);
  ASSERT_THAT(film.notes, SizeIs(4));
  EXPECT_EQ(film.notes[0].text, "Round the box");
  EXPECT_EQ(film.notes[1].text, "step: grasp: done");
  EXPECT_EQ(film.notes[2].text, "error: " + std::string(38, 'x') + "...");
  EXPECT_EQ(film.notes[3].text, "step: lift: failed, it is ?ber");
}

TEST(RecordingTest, NamesTheScenariosControllerOnlyWhereAWorkstationRan) {
  const twin::test::TemporaryFolder folder;
  EXPECT_EQ(Recording(WriteLog(folder, test::Sample(), 10, Nothing), test::Files()).Film().title,
            "smoke\nserved, led by its client\nnot recorded: hand, objects, base");
  const auto led = WriteLog(folder, test::Sample(), 10,
                            [](record::Recorder& recorder) { recorder.Put(record::TickRecord()); });
  EXPECT_THAT(Recording(led, test::Files()).Film().title,
              testing::StartsWith("smoke\njoint_trajectory\n"));
}

TEST(RecordingTest, ReadsWhatAKilledRunLeft) {
  const twin::test::TemporaryFolder folder;
  {
    record::Recorder recorder(folder / "run.mcap", test::InfoOf(test::Sample()),
                              record::FullRing::kWait);
    for (std::uint64_t k = 0; k < 100; ++k) recorder.Put(test::CycleAt(k));
  }
  const Recording recording(folder / "run.mcap.partial", test::Files());
  EXPECT_TRUE(recording.truncated());
  EXPECT_GT(recording.snapshots().size(), 1U);
}

TEST(RecordingTest, SaysWhenALogTellsNoScenario) {
  const twin::test::TemporaryFolder folder;
  record::RunInfo info = test::InfoOf(test::Sample());
  info.scenario_yaml.clear();
  record::Recorder(folder / "run.mcap", info, record::FullRing::kWait).Finish();
  EXPECT_THAT(FailureOf(folder / "run.mcap"), HasSubstr("run.mcap: the log holds no scenario"));
}

TEST(RecordingTest, SaysWhenNothingMoved) {
  const twin::test::TemporaryFolder folder;
  EXPECT_THAT(FailureOf(WriteLog(folder, test::Sample(), 0, Nothing)),
              HasSubstr("holds no state of the robot"));
}

TEST(RecordingTest, SaysWhenTheScenesAreOfAnotherModel) {
  const twin::test::TemporaryFolder folder;
  scenario::Scenario without = test::Sample();
  without.objects.clear();
  const plant::CompiledModel model = test::ModelOf(without);
  const auto log = WriteLog(folder, test::Sample(), 1, [&](record::Recorder& recorder) {
    recorder.Put(test::SceneAt(Time(), model));
  });
  EXPECT_THAT(FailureOf(log), HasSubstr("a scene in the log has 9 positions, and the model made of "
                                        "its scenario has 16"));
}

}  // namespace
}  // namespace twin::replay::replay_recording_test
