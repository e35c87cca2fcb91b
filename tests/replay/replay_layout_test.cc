#include "twin/replay/layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

#include "replay/sample_log.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/render/image_operations.h"
#include "twin/replay/plan_pictures.h"

namespace twin::replay::replay_layout_test {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

TEST(DistanceFromPathTest, IsThatFromTheNearestLine) {
  const std::vector<Vector3> path{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  EXPECT_NEAR(DistanceFromPath({0.5, 0, 0.2}, path), 0.2, 1e-15) << "above a line";
  EXPECT_NEAR(DistanceFromPath({1.3, 0.5, 0.4}, path), 0.5, 1e-15) << "beside the second";
  EXPECT_NEAR(DistanceFromPath({-3, 0, 4}, path), 5, 1e-15) << "before its beginning";
  EXPECT_NEAR(DistanceFromPath({1, 3, 0}, path), 2, 1e-15) << "after its end";
}

TEST(DistanceFromPathTest, OfOnePointIsThatFromThePoint) {
  const std::vector<Vector3> path{{1, 2, 3}};
  EXPECT_NEAR(DistanceFromPath({1, 2, 3.5}, path), 0.5, 1e-15);
}

/// A log of the sample arm with plans of these names, each 20 ms after the other.
class LayoutTest : public testing::Test {
 protected:
  LayoutTest() {
    settings_.render.width = 96;
    settings_.render.height = 72;
    settings_.render.shadow_size = 128;
    settings_.overlays.text = false;
  }

  [[nodiscard]] Recording With(const std::vector<std::string>& ids) {
    const std::filesystem::path path = folder_ / "run.mcap";
    record::Recorder recorder(path, test::InfoOf(test::Sample()), record::FullRing::kWait);
    for (std::uint64_t k = 0; k < 400; ++k) recorder.Put(test::CycleAt(k));
    Time from{};
    for (const std::string& id : ids) {
      record::PlanRecord plan{.id = id, .caption = id + ": a case", .from = from};
      from += milliseconds(40);
      plan.until = from;
      plan.q = test::ArmAt(from + std::chrono::seconds(8));
      recorder.Add(plan);
    }
    recorder.Finish();
    return {path, test::Files()};
  }

  [[nodiscard]] std::string FailureOf(Layout layout, const std::vector<std::string>& ids) {
    try {
      static_cast<void>(DrawLayout(With(ids), layout, settings_));
    } catch (const InputError& error) {
      return error.what();
    }
    return "no failure";
  }

  twin::test::TemporaryFolder folder_;
  render::FilmSettings settings_;
};

TEST_F(LayoutTest, TripleIsARowForEachPlan) {
  const Recording recording = With({"one", "two"});
  const render::Film film = recording.Film();
  PlanPictures pictures(film, settings_);
  std::vector<render::Image> expected;
  for (const render::PlannedGoal& plan : film.goals) {
    expected.push_back(pictures.Before(plan));
    expected.push_back(pictures.Planned(plan));
    expected.push_back(pictures.Done(plan));
  }
  EXPECT_NE(expected[0], expected[1]) << "the ghost";
  EXPECT_EQ(DrawLayout(recording, Layout::kTriple, settings_),
            render::ComposeContactSheet(expected, {.columns = 3}));
}

TEST_F(LayoutTest, StripTakesSixPlansEvenlySpacedPlannedAboveDoneBelow) {
  const Recording recording =
      With({"a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k"});  // the odd ones of eleven
  const render::Film film = recording.Film();
  PlanPictures pictures(film, settings_);
  std::vector<render::Image> expected;
  for (std::size_t i = 0; i < 11; i += 2) expected.push_back(pictures.Planned(film.goals[i]));
  for (std::size_t i = 0; i < 11; i += 2) expected.push_back(pictures.Done(film.goals[i]));
  EXPECT_EQ(DrawLayout(recording, Layout::kStrip, settings_),
            render::ComposeContactSheet(expected, {.columns = 6}));
}

TEST_F(LayoutTest, GridShowsEachCaseWhereTheArmIsFurthestOff) {
  const Recording recording = With({"D", "C", "B", "A"});
  const render::Film film = recording.Film();
  // The sample arm only ever moves on: furthest from where a plan found it is where that ends.
  PlanPictures pictures(film, settings_);
  std::vector<render::Image> expected;
  for (const std::size_t plan : {3U, 2U, 1U, 0U})
    expected.push_back(pictures.Done(film.goals[plan]));
  EXPECT_EQ(DrawLayout(recording, Layout::kGrid, settings_),
            render::ComposeContactSheet(expected, {.columns = 2}));
}

TEST_F(LayoutTest, SaysWhichPlansALogLacks) {
  EXPECT_THAT(FailureOf(Layout::kGrid, {"A", "B", "C"}),
              HasSubstr("it takes the plans A, B, C and D; the log of smoke has only A, B, C"));
  EXPECT_THAT(FailureOf(Layout::kStrip, {"A"}), HasSubstr("it takes six plans"));
  EXPECT_THAT(FailureOf(Layout::kTriple, {}), HasSubstr("has none"));
}

TEST(LayoutFromNameTest, NamesThoseThereAre) {
  EXPECT_EQ(LayoutFromName("strip"), Layout::kStrip);
  EXPECT_THROW(static_cast<void>(LayoutFromName("row")), InputError);
}

}  // namespace
}  // namespace twin::replay::replay_layout_test
