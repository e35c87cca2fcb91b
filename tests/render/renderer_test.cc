#include "twin/render/renderer.h"

#include <sys/wait.h>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <future>
#include <set>
#include <string>
#include <vector>

#include "render/test_model.h"
#include "twin/core/error.h"

namespace twin::render::renderer_test {
namespace {

RenderSettings SmallSettings(const std::string& camera = "side") {
  RenderSettings settings;
  settings.width = 160;
  settings.height = 120;
  settings.camera = camera;
  settings.shadow_size = 512;
  return settings;
}

/// Mean place of the pixels of a body, in continuous pixels.
PixelPoint Centroid(const SegmentationImage& image, std::int32_t body) {
  PixelPoint sum;
  double count = 0;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      if (image.at(column, row) != body) continue;
      sum.u += column + 0.5;
      sum.v += row + 0.5;
      ++count;
    }
  }
  return {sum.u / count, sum.v / count};
}

void ExpectColour(const Rgb& actual, const std::array<double, 3>& expected) {
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(actual[c], 255 * expected[c], 1.01);
}

// A box of 0.2 m whose near face is 1 m from the camera and square to it; the camera looks along y.
std::string FaceMjcf(const std::string& headlight, const std::string& material) {
  return R"(<mujoco><visual><headlight )" + headlight + R"(/></visual>
    <asset><material name="paint" rgba="0.8 0.4 0.2 1" )" +
         material + R"(/></asset>
    <worldbody>
      <camera name="side" pos="0 -1.1 0" xyaxes="1 0 0 0 0 1" fovy="60"/>
      <geom type="box" size="0.1 0.1 0.1" material="paint"/>
    </worldbody></mujoco>)";
}

TEST(RendererTest, RefusesToDrawInAForkOfAProcessThatHasDrawn) {
  const TestModel model(FaceMjcf(R"(ambient="0 0 0")", R"(emission="1")"));
  const Renderer renderer(model.model(), SmallSettings());
  const pid_t child = ::fork();
  if (child == 0) {
    try {
      const Renderer in_fork(model.model(), SmallSettings());
      ::_exit(1);
    } catch (const EnvironmentError&) {
      ::_exit(0);
    }
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

TEST(RendererTest, ShowsAGlowingFaceInExactlyItsColour) {
  const TestModel model(FaceMjcf(R"(ambient="0 0 0" diffuse="0 0 0" specular="0 0 0")",
                                 R"(emission="1" specular="0")"));
  const Image image = Renderer(model.model(), SmallSettings()).Render({});
  ExpectColour(image.at(80, 60), {0.8, 0.4, 0.2});
  ExpectColour(image.at(2, 2), {0, 0, 0});
}

TEST(RendererTest, LightsAFaceSquareToTheHeadlightByAmbientPlusDiffuse) {
  const TestModel model(FaceMjcf(R"(ambient="0.2 0.2 0.2" diffuse="0.5 0.6 0.7" specular="0 0 0")",
                                 R"(emission="0" specular="0")"));
  const Image image = Renderer(model.model(), SmallSettings()).Render({});
  ExpectColour(image.at(80, 60), {0.8 * 0.7, 0.4 * 0.8, 0.2 * 0.9});
}

TEST(RendererTest, HasTheTopRowFirst) {
  const TestModel model(kArmMjcf);
  Renderer renderer(model.model(), SmallSettings());
  const SegmentationImage image = renderer.Segment(model.Qpos());
  EXPECT_EQ(image.at(80, 0), SegmentationImage::kBackground);  // the sky
  EXPECT_EQ(image.at(80, 119), 0);                             // the floor
}

TEST(RendererTest, DrawsTheSameBytesOnEveryRendererAndThread) {
  const TestModel model(kArmMjcf);
  const std::vector<double> qpos{0.3, -0.4};
  const auto draw = [&] { return Renderer(model.model(), SmallSettings()).Render(qpos, "t = 1"); };
  const Image here = draw();
  auto first = std::async(std::launch::async, draw);
  auto second = std::async(std::launch::async, draw);
  EXPECT_EQ(first.get(), here);
  EXPECT_EQ(second.get(), here);
}

TEST(RendererTest, DrawsAFrameTheSameWhateverWasDrawnBefore) {
  const TestModel model(kArmMjcf);
  Renderer renderer(model.model(), SmallSettings());
  const std::vector<double> qpos{0.3, -0.4};
  const Image first = renderer.Render(qpos);
  (void)renderer.Render(std::vector<double>{-1.0, 1.0}, "caption");
  (void)renderer.Segment(qpos);
  EXPECT_EQ(renderer.Render(qpos), first);
}

TEST(RendererTest, MovesWithTheJoints) {
  const TestModel model(kArmMjcf);
  Renderer renderer(model.model(), SmallSettings());
  EXPECT_NE(renderer.Render(std::vector<double>{0, 0}),
            renderer.Render(std::vector<double>{0, 0.1}));
}

TEST(RendererTest, MayBeUsedFromAnotherThreadThanItWasMadeOn) {
  const TestModel model(kArmMjcf);
  Renderer renderer(model.model(), SmallSettings());
  const Image here = renderer.Render(model.Qpos());
  const auto there =
      std::async(std::launch::async, [&] { return renderer.Render(model.Qpos()); }).get();
  EXPECT_EQ(there, here);
}

TEST(RendererTest, SegmentsEveryBodyAndNothingElse) {
  const TestModel model(kArmMjcf);
  for (const int samples : {0, 4}) {
    RenderSettings settings = SmallSettings();
    settings.samples = samples;
    Renderer renderer(model.model(), settings);
    const SegmentationImage image = renderer.Segment(model.Qpos());
    const std::set<std::int32_t> seen(image.body.begin(), image.body.end());
    EXPECT_EQ(seen, (std::set<std::int32_t>{SegmentationImage::kBackground, 0,
                                            renderer.BodyId("lower"), renderer.BodyId("upper")}));
  }
}

/// Pixels at which two pictures differ, and which of these lie on a body.
struct Difference {
  std::size_t all = 0;
  std::size_t on_body = 0;
};

Difference Compare(const Image& a, const Image& b, const SegmentationImage& bodies,
                   std::int32_t body) {
  Difference difference;
  for (int row = 0; row < a.height; ++row) {
    for (int column = 0; column < a.width; ++column) {
      if (a.at(column, row) == b.at(column, row)) continue;
      ++difference.all;
      if (bodies.at(column, row) == body) ++difference.on_body;
    }
  }
  return difference;
}

TEST(RendererTest, DrawsAGhostBesideTheBodyThatIsReallyThere) {
  const TestModel model(kArmMjcf);
  RenderSettings settings = SmallSettings();
  settings.shadows = false;
  Renderer renderer(model.model(), settings);
  const std::vector<double> here{0, 0};
  const std::vector<double> there{0, -1.2};  // the upper link alone, clear of where it is
  const Image plain = renderer.Render(here);
  const Image with_ghost = renderer.Render(here, Ghost{.qpos = there});
  const SegmentationImage real = renderer.Segment(here);
  const SegmentationImage ghost = renderer.Segment(there);
  const std::int32_t upper = renderer.BodyId("upper");
  const std::int32_t lower = renderer.BodyId("lower");

  std::size_t ghost_pixels = 0;
  std::size_t changed = 0;
  for (int row = 0; row < plain.height; ++row) {
    for (int column = 0; column < plain.width; ++column) {
      if (ghost.at(column, row) != upper || real.at(column, row) == upper ||
          real.at(column, row) == lower) {
        continue;
      }
      ++ghost_pixels;
      const Rgb before = plain.at(column, row);
      const Rgb after = with_ghost.at(column, row);
      // Translucent blue: less red than what is behind, but not none.
      if (after != before && after[0] < before[0] && after[0] > 0) ++changed;
    }
  }
  EXPECT_GT(ghost_pixels, 80u);
  EXPECT_GT(static_cast<double>(changed), 0.95 * static_cast<double>(ghost_pixels));
  // What stands alike is drawn once, and as ever but for the ghost before it.
  EXPECT_EQ(renderer.Render(here, Ghost{.qpos = here}), plain);
  EXPECT_LT(Compare(plain, with_ghost, real, lower).on_body, 60u);
  EXPECT_EQ(renderer.Render(here), plain) << "nothing is left of it";
}

TEST(RendererTest, DrawsALineWhereItsPointsAre) {
  const TestModel model(kArmMjcf);
  RenderSettings settings = SmallSettings();
  settings.shadows = false;
  Renderer renderer(model.model(), settings);
  const std::vector<double> qpos{0, 0};
  Ghost ghost;
  ghost.radius = 0.03;
  ghost.line_colour = {1, 0, 0, 1};
  for (int i = 0; i < 5; ++i) ghost.line.push_back({-0.6 + 0.1 * i, 0, 0.9});
  const Image image = renderer.Render(qpos, ghost);
  for (const Vector3& point : ghost.line) {
    const auto pixel = renderer.Camera(qpos).Project(point);
    ASSERT_TRUE(pixel.has_value());
    const Rgb colour = image.at(static_cast<int>(pixel->u), static_cast<int>(pixel->v));
    EXPECT_GT(colour[0], 2 * colour[1]) << point[0];
  }
}

TEST(RendererTest, PutsOnlyAPandaElsewhere) {
  const TestModel model(kArmMjcf);
  const Renderer renderer(model.model(), SmallSettings());
  EXPECT_THROW((void)renderer.WithArmAt(model.Qpos(), JointVector{}), InputError);
}

TEST(RendererTest, HidesCollisionShapes) {
  const TestModel model(kArmMjcf);  // the sphere "hull" of group 3 would fill half the picture
  Renderer renderer(model.model(), SmallSettings());
  const SegmentationImage image = renderer.Segment(model.Qpos());
  const auto pixels = std::count(image.body.begin(), image.body.end(), renderer.BodyId("upper"));
  EXPECT_GT(pixels, 100);
  EXPECT_LT(pixels, 1000);
}

TEST(RendererTest, SegmentsABodyThatIsHiddenWhenTheOthersAreTakenAway) {
  const TestModel model(R"(<mujoco><worldbody>
      <camera name="side" pos="0 -1 0" xyaxes="1 0 0 0 0 1"/>
      <body name="near" pos="0 0 0"><geom type="box" size="0.2 0.01 0.2"/></body>
      <body name="far" pos="0 0.3 0"><geom type="box" size="0.1 0.01 0.1"/></body>
    </worldbody></mujoco>)");
  Renderer renderer(model.model(), SmallSettings());
  const std::array<int, 1> far{renderer.BodyId("far")};
  const auto count = [&](const SegmentationImage& image) {
    return std::count(image.body.begin(), image.body.end(), far[0]);
  };
  EXPECT_EQ(count(renderer.Segment({})), 0);
  EXPECT_GT(count(renderer.Segment({}, far)), 100);
}

TEST(RendererTest, AgreesWithOurOwnProjectionFromTheFreeCamera) {
  const TestModel model(R"(<mujoco><visual><global fovy="40"/></visual><statistic extent="2"/>
    <worldbody>
      <body name="ball"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
        <joint type="slide" axis="0 0 1"/><geom type="sphere" size="0.02"/></body>
    </worldbody></mujoco>)");
  RenderSettings settings;
  settings.free_camera = {130, -25, 2.0, {0.1, 0.2, 0.3}};
  Renderer renderer(model.model(), settings);
  for (const Vector3& p : {Vector3{0.1, 0.2, 0.3}, Vector3{0.5, 0.1, 0.6}, Vector3{-0.4, 0.5, 0}}) {
    const auto pixel = renderer.Camera(p).Project(p);
    const PixelPoint seen = Centroid(renderer.Segment(p), renderer.BodyId("ball"));
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(seen.u, pixel->u, 0.5);
    EXPECT_NEAR(seen.v, pixel->v, 0.5);
  }
}

TEST(RendererTest, AgreesWithOurOwnProjectionFromACameraOnAMovingBody) {
  const TestModel model(R"(<mujoco><statistic extent="2"/><worldbody>
      <body><joint axis="0 0 1"/><joint axis="1 0 0"/><geom size="0.01" rgba="0 0 0 0"/>
        <camera name="eye" pos="0.1 -0.2 0.05" euler="75 10 5" fovy="55"/></body>
      <body name="ball" pos="0.25 1 0.15"><geom type="sphere" size="0.02"/></body>
    </worldbody></mujoco>)");
  RenderSettings settings;
  settings.camera = "eye";
  Renderer renderer(model.model(), settings);
  for (const double angle : {-0.15, 0.0, 0.2}) {
    const std::vector<double> qpos{angle, 0.5 * angle};
    const auto pixel = renderer.Camera(qpos).Project({0.25, 1, 0.15});
    const PixelPoint seen = Centroid(renderer.Segment(qpos), renderer.BodyId("ball"));
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(seen.u, pixel->u, 0.5);
    EXPECT_NEAR(seen.v, pixel->v, 0.5);
  }
}

TEST(RendererTest, WritesTheCaptionIntoTheLowerLeftCornerOnly) {
  const TestModel model(kArmMjcf);
  Renderer renderer(model.model(), SmallSettings());
  const Image plain = renderer.Render(model.Qpos());
  const Image titled = renderer.Render(model.Qpos(), "t = 1.00 s");
  std::size_t changed = 0;
  for (int row = 0; row < plain.height; ++row) {
    for (int column = 0; column < plain.width; ++column) {
      if (plain.at(column, row) == titled.at(column, row)) continue;
      ++changed;
      EXPECT_GT(row, 85);
      EXPECT_LT(column, 130);
    }
  }
  EXPECT_GT(changed, 100U);
}

TEST(RendererTest, DrawsShadowsOnlyWhenAsked) {
  const TestModel model(kArmMjcf);
  RenderSettings settings = SmallSettings();
  settings.free_camera.elevation_deg = -40;
  settings.camera.clear();
  const Image with = Renderer(model.model(), settings).Render(model.Qpos());
  settings.shadows = false;
  const Image without = Renderer(model.model(), settings).Render(model.Qpos());
  std::size_t darker = 0;
  std::size_t brighter = 0;
  for (std::size_t i = 0; i < with.rgb.size(); ++i) {
    if (with.rgb[i] + 20 < without.rgb[i]) ++darker;
    if (with.rgb[i] > without.rgb[i] + 20) ++brighter;
  }
  EXPECT_GT(darker, 200U);
  EXPECT_EQ(brighter, 0U);
}

TEST(RendererTest, IsLargerThanTheModelsOwnOffscreenBuffer) {
  const TestModel model(kArmMjcf);  // MuJoCo's default buffer: 640 x 480
  RenderSettings settings = SmallSettings();
  settings.width = 1280;
  settings.height = 720;
  Renderer renderer(model.model(), settings);
  const SegmentationImage image = renderer.Segment(model.Qpos());
  EXPECT_EQ(image.body.size(), 1280U * 720U);
  EXPECT_EQ(image.at(5, 715), 0);  // floor in every lower corner
  EXPECT_EQ(image.at(1275, 715), 0);
}

TEST(RendererTest, OutlivesTheModelItWasMadeFrom) {
  auto model = std::make_unique<TestModel>(kArmMjcf);
  const std::vector<double> qpos = model->Qpos();
  Renderer renderer(model->model(), SmallSettings());
  const Image before = renderer.Render(qpos);
  model.reset();
  EXPECT_EQ(renderer.Render(qpos), before);
}

TEST(RendererTest, NamesTheCamerasAndBodiesThereAre) {
  const TestModel model(kArmMjcf);
  try {
    const Renderer renderer(model.model(), SmallSettings("front"));
    FAIL() << "nothing was thrown";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("\"front\""));
    EXPECT_THAT(e.what(), testing::HasSubstr("side, wrist"));
  }
  try {
    (void)Renderer(model.model(), SmallSettings()).BodyId("elbow");
    FAIL() << "nothing was thrown";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("world, lower, upper"));
  }
}

TEST(RendererTest, RefusesSettingsOutOfRangeNamingTheField) {
  const auto text = [](auto change) -> std::string {
    RenderSettings settings;
    change(settings);
    try {
      settings.Validate();
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_THAT(text([](auto& s) { s.width = 8; }), testing::HasSubstr("width"));
  EXPECT_THAT(text([](auto& s) { s.height = 5000; }), testing::HasSubstr("[16, 4096]"));
  EXPECT_THAT(text([](auto& s) { s.samples = 3; }), testing::HasSubstr("samples is 3"));
  EXPECT_THAT(text([](auto& s) { s.shadow_size = 1; }), testing::HasSubstr("shadow_size"));
  EXPECT_THAT(text([](auto& s) { s.free_camera.distance_m = 0; }), testing::HasSubstr("distance"));
  EXPECT_THAT(text([](auto& s) { s.free_camera.lookat_m[1] = std::nan(""); }),
              testing::HasSubstr("lookat"));
  EXPECT_EQ(text([](auto&) {}), "accepted");
}

}  // namespace
}  // namespace twin::render::renderer_test
