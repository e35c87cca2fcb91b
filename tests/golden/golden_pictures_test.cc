#include "twin/golden/pictures.h"

#include <gtest/gtest.h>

#include "render/test_model.h"
#include "twin/core/error.h"
#include "twin/golden/comparison.h"
#include "twin/render/frame_painter.h"

namespace twin::golden::golden_pictures_test {
namespace {

using std::chrono::milliseconds;

/// Eleven frames, 40 ms apart, of an arm that swings.
class PicturesTest : public testing::Test {
 protected:
  PicturesTest() : model_(render::kArmMjcf), recorder_(milliseconds(400), 25, model_.qpos_size()) {
    for (int t = 0; t <= 400; t += 40) {
      model_.SetQpos(0, 2e-3 * t);
      recorder_.Capture(Time(milliseconds(t)), model_);
    }
    ViewPlan& view = plan_.views.emplace_back();
    view.name = "side";
    view.settings.render.width = 160;
    view.settings.render.height = 120;
    view.settings.view = {.kind = render::ViewKind::kScene, .name = "side", .orbit = {}};
    plan_.every = 2;
    plan_.key_frames = 3;
  }

  [[nodiscard]] render::Film Film() const { return {&model_.model(), &recorder_.snapshots()}; }

  render::TestModel model_;
  render::SnapshotRecorder recorder_;
  PicturePlan plan_;
};

TEST(HashOfTest, TellsBytesAndShapesApart) {
  render::Image image(4, 2, {1, 2, 3});
  const std::uint64_t hash = HashOf(image);
  EXPECT_NE(HashOf(render::Image(2, 4, {1, 2, 3})), hash);
  image.rgb[5] ^= 1;
  EXPECT_NE(HashOf(image), hash);
}

TEST_F(PicturesTest, KeepEverySecondFrameAndTheKeyPicturesOfThem) {
  const Pictures pictures = TakePictures(Film(), plan_);
  EXPECT_EQ(pictures.frames, 6U);
  EXPECT_DOUBLE_EQ(pictures.interval_s, 0.08);
  EXPECT_EQ(pictures.bodies, (std::vector<std::string>{"world", "lower", "upper"}));
  const ViewPictures& view = pictures.views.at(0);
  EXPECT_EQ(view.hashes.size(), 6U);
  EXPECT_EQ(view.signatures.size(), 6U);
  ASSERT_EQ(view.keys.size(), 3U);
  render::FramePainter painter(Film(), plan_.views[0].settings);
  EXPECT_EQ(view.keys[1].frame, 2U);
  EXPECT_EQ(view.keys[1].colour, painter.Paint(4));
  EXPECT_EQ(view.keys[1].depth, painter.Depth(4));
  EXPECT_EQ(view.keys[1].bodies, painter.Segment(4));
}

TEST_F(PicturesTest, TakeTheKeyPicturesAsked) {
  const Pictures pictures = TakePictures(Film(), plan_, std::vector<std::size_t>{1, 99});
  ASSERT_EQ(pictures.views[0].keys.size(), 1U) << "there are no 99 frames";
  EXPECT_EQ(pictures.views[0].keys[0].frame, 1U);
}

TEST_F(PicturesTest, AFilmOfAnotherModelIsNotTheSame) {
  const Pictures before = TakePictures(Film(), plan_);
  Golden golden{before, {7}, {{before.views[0].hashes}}, {}};
  std::string mjcf(render::kArmMjcf);
  mjcf.replace(mjcf.find("size=\"0.04\""), 11, "size=\"0.03\"");
  const render::TestModel thinner(mjcf);
  const Pictures after = TakePictures({&thinner.model(), &recorder_.snapshots()}, plan_);
  const Comparison comparison = Compare(golden, {&after, 7, {}});
  EXPECT_EQ(comparison.verdict, Verdict::kRenderingChanged);
  EXPECT_EQ(comparison.FirstFailure()->first->body, "upper");
  EXPECT_EQ(Compare(golden, {&before, 7, {}}).verdict, Verdict::kSame);
}

TEST_F(PicturesTest, RefuseWhatCannotBeKept) {
  plan_.views[0].settings.render.width = 30;
  EXPECT_THROW(static_cast<void>(TakePictures(Film(), plan_)), InputError);
  const render::Snapshots none(25, model_.qpos_size());
  EXPECT_THROW(static_cast<void>(TakePictures({&model_.model(), &none}, plan_)), InputError);
}

TEST(RelabelTest, TellsBodiesByAnotherListAndAppendsWhatItLacks) {
  Pictures pictures{1, 1, {"world", "a", "b"}, {{"view", 3, 1, {}, {}, {{}}}}};
  pictures.views[0].keys[0].bodies = {3, 1, {-1, 1, 2}};
  Relabel(pictures, {"world", "b"});
  EXPECT_EQ(pictures.bodies, (std::vector<std::string>{"world", "b", "a"}));
  EXPECT_EQ(pictures.views[0].keys[0].bodies.body, (std::vector<std::int32_t>{-1, 2, 1}));
}

}  // namespace
}  // namespace twin::golden::golden_pictures_test
