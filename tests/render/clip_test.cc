#include "twin/render/clip.h"

#include <gtest/gtest.h>

#include <stop_token>
#include <thread>
#include <vector>

#include "render/test_model.h"
#include "support/peak_memory.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/render/image.h"
#include "twin/render/renderer.h"

namespace twin::render::clip_test {
namespace {

using std::chrono::milliseconds;

/// Advances by a second at each reading.
class CountingClock final : public Clock {
 public:
  [[nodiscard]] Time Now() const noexcept override {
    return Time(std::chrono::seconds(++seconds_));
  }

 private:
  mutable int seconds_ = 0;
};

/// Eleven frames of the arm of kArmMjcf, swinging.
class ClipTest : public testing::Test {
 protected:
  ClipTest() : model_(kArmMjcf), recorder_(milliseconds(400), 25, model_.qpos_size()) {
    for (int t = 0; t <= 400; ++t) {
      model_.SetQpos(0, 2e-3 * t);
      recorder_.Capture(Time(milliseconds(t)), model_);
    }
    settings_.film.render.width = 160;
    settings_.film.render.height = 120;
    settings_.film.render.camera = "side";
    settings_.film.view = {.kind = ViewKind::kScene, .name = "side", .orbit = {}};
    settings_.sheet_pictures = 4;
    settings_.sheet.columns = 2;
    settings_.sheet.border_px = 2;
  }

  /// @returns the memory that rendering so many frames takes at most, bytes.
  std::size_t PeakOf(std::int64_t frames) {
    SnapshotRecorder recorder(milliseconds(40 * (frames - 1)), 25, model_.qpos_size());
    for (std::int64_t i = 0; i < frames; ++i) recorder.Capture(Time(milliseconds(40 * i)), model_);
    test::ResetPeakMemory();
    RenderClip({&model_.model(), &recorder.snapshots()}, settings_,
               {folder_ / "a.mp4", folder_ / "a.png"}, CountingClock());
    return test::PeakMemory();
  }

  ClipStats RenderTo(const ClipPaths& paths, const ClipProgress& progress = {}) {
    return RenderClip({&model_.model(), &recorder_.snapshots()}, settings_, paths, CountingClock(),
                      progress);
  }

  TestModel model_;
  SnapshotRecorder recorder_;
  ClipSettings settings_;
  test::TemporaryFolder folder_;
};

// Mesa's contexts are not independent: where they drew at the same time, one run in 20 crashed.
TEST_F(ClipTest, IsTheSameBytesWhileOthersDraw) {
  RenderTo({folder_ / "a.mp4", folder_ / "a.png"});
  {
    std::vector<std::jthread> others;
    others.reserve(2);
    for (int i = 0; i < 2; ++i) {
      others.emplace_back([&](const std::stop_token& stop) {
        Renderer renderer(model_.model(), settings_.film.render);
        const auto qpos = recorder_.snapshots().qpos(0);
        while (!stop.stop_requested()) static_cast<void>(renderer.Render(qpos, "other"));
      });
    }
    RenderTo({folder_ / "b.mp4", folder_ / "b.png"});
  }
  EXPECT_GT(test::ReadText(folder_ / "a.mp4").size(), 1000U);
  EXPECT_EQ(test::ReadText(folder_ / "a.mp4"), test::ReadText(folder_ / "b.mp4"));
  EXPECT_EQ(test::ReadText(folder_ / "a.png"), test::ReadText(folder_ / "b.png"));
}

TEST_F(ClipTest, PutsEvenlySpacedFramesOnTheSheetFirstAndLastIncluded) {
  RenderTo({{}, folder_ / "sheet.png"});
  Renderer renderer(model_.model(), settings_.film.render);
  std::vector<Image> expected;
  for (const auto& [frame, caption] :
       {std::pair{0, "t = 0.00 s"}, {3, "t = 0.12 s"}, {6, "t = 0.24 s"}, {10, "t = 0.40 s"}}) {
    const auto qpos = recorder_.snapshots().qpos(static_cast<std::size_t>(frame));
    expected.push_back(HalveImage(renderer.Render(qpos, caption)));
  }
  EXPECT_EQ(ReadPng(folder_ / "sheet.png"), ComposeContactSheet(expected, settings_.sheet));
}

// 760 frames more are 44 MB of pictures and 1.3 MB of snapshots.
TEST_F(ClipTest, TakesNoMoreMemoryForMoreFrames) {
  const std::size_t few = PeakOf(40);
  const std::size_t many = PeakOf(800);
  EXPECT_LT(many, few + 10'000'000);
}

TEST_F(ClipTest, OverlaysAndInsetsAreTheSameBytesAgain) {
  settings_.film.insets = {{.view = {.kind = ViewKind::kScene, .name = "wrist", .orbit = {}}}};
  settings_.film.overlays.contacts = true;
  settings_.film.overlays.forces = true;
  settings_.film.view = {.kind = ViewKind::kOrbit, .name = {}, .orbit = {}, .turn_deg_per_s = 30};
  for (const char* name : {"a.mkv", "b.mkv"}) RenderTo({folder_ / name, {}});
  EXPECT_GT(test::ReadText(folder_ / "a.mkv").size(), 1000U);
  EXPECT_EQ(test::ReadText(folder_ / "a.mkv"), test::ReadText(folder_ / "b.mkv"));
}

TEST_F(ClipTest, ReportsEveryFrameInOrderAndTheTimeByTheClockGiven) {
  std::vector<std::size_t> done;
  const ClipStats stats =
      RenderTo({{}, folder_ / "sheet.png"}, [&](std::size_t n, std::size_t total) {
        done.push_back(n);
        EXPECT_EQ(total, 11U);
      });
  ASSERT_EQ(done.size(), 11U);
  for (std::size_t i = 0; i < done.size(); ++i) EXPECT_EQ(done[i], i + 1);
  EXPECT_EQ(stats.frames, 11U);
  EXPECT_EQ(stats.seconds, 1);
}

TEST_F(ClipTest, PassesOnWhatTheDrawingThreadThrows) {
  settings_.film.view.name = "no such camera";
  EXPECT_THROW(RenderTo({{}, folder_ / "sheet.png"}), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "sheet.png"));
}

TEST_F(ClipTest, StopsItsThreadWhenFfmpegFails) {
  settings_.ffmpeg = "false";
  EXPECT_THROW(RenderTo({folder_ / "a.mp4", {}}), EnvironmentError);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.mp4"));
}

TEST_F(ClipTest, IsMadeOfWhateverDraws) {
  const auto picture = [](std::size_t frame) {
    return Image(32, 16, {static_cast<std::uint8_t>(40 * frame), 100, 200});
  };
  settings_.sheet_pictures = 3;
  RenderClip(
      ClipFrames{.count = 3, .width = 32, .height = 16, .new_drawer = [&] { return picture; }},
      settings_, {{}, folder_ / "sheet.png"}, CountingClock());
  std::vector<Image> expected;
  for (std::size_t i = 0; i < 3; ++i) expected.push_back(HalveImage(picture(i)));
  EXPECT_EQ(ReadPng(folder_ / "sheet.png"), ComposeContactSheet(expected, settings_.sheet));
}

TEST_F(ClipTest, RefusesSettingsOutOfRange) {
  settings_.sheet_pictures = 0;
  EXPECT_THROW(RenderTo({{}, folder_ / "sheet.png"}), InputError);
}

}  // namespace
}  // namespace twin::render::clip_test
