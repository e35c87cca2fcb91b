// What a video costs against its stages, each measured alone in the same run with the same threads:
// frames/s once it runs, at three sizes.
//
//   Whole     RenderClip to an MP4
//   Draw      RenderClip to nothing: the same threads draw and read back
//   ReadBack  the same threads read back one picture over and over
//   Encode    VideoWriter, pictures that are already there
//   Plain     Whole, of Franka's meshes as they are without shadows
//
//   pipeline  Whole over the slowest stage, at each size             at least 0.9
//   quality   Whole over Plain, at 640x480                           at least 0.8
//
// Repetitions are interleaved, ratios are of medians. Exits with 1 when one is too small: what a
// shared machine does to times, it does to both. Without Franka's meshes there is no Plain.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "render/drawn_model.h"
#include "render/scene_renderer.h"
#include "support/temporary_folder.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/render/clip.h"
#include "twin/render/frame_painter.h"
#include "twin/render/video_writer.h"

namespace twin::render {
namespace {

constexpr double kLeastPipeline = 0.9;
constexpr double kLeastQuality = 0.8;
constexpr std::array<std::pair<int, int>, 3> kSizes{{{320, 240}, {640, 480}, {1280, 720}}};
constexpr int kFps = 25;
/// Frames until all threads are busy; not counted.
constexpr std::size_t kStart = 8;

std::size_t FramesAt(int width) {
  return kStart + static_cast<std::size_t>(width < 640 ? 160 : width < 1280 ? 80 : 40);
}

/// The arm, waving, as films of any size.
class Stage {
 public:
  explicit Stage(double visual_error) {
    plant::MujocoPlantOptions options;
    options.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
    options.scene = TWIN_SOURCE_DIR "/models/scenes/floor.xml";
    options.mesh_package = TWIN_SOURCE_DIR "/.data/panda_description";
    options.visual_error = visual_error;
    plant_ = plant::MujocoPlant::Create(options);
  }

  [[nodiscard]] bool has_meshes() const { return plant_->uses_meshes(); }
  [[nodiscard]] const mjModel& model() const { return plant_->model(); }

  [[nodiscard]] Snapshots Film(std::size_t frames) {
    Snapshots snapshots(kFps, plant_->qpos_size());
    for (std::size_t i = 0; i < frames; ++i) {
      const double s = 0.3 * std::sin(0.1 * static_cast<double>(i));
      plant_->Reset({s, -M_PI / 4 + s, 0, -3 * M_PI / 4, s, M_PI / 2, M_PI / 4});
      rt::SceneRecord scene;
      scene.at = Time(std::chrono::milliseconds(40 * i));
      scene.positions = plant_->qpos_size();
      plant_->CopyQpos(std::span(scene.qpos).first(scene.positions));
      snapshots.Append(scene);
    }
    return snapshots;
  }

 private:
  std::unique_ptr<plant::MujocoPlant> plant_;
};

ClipSettings SettingsAt(int width, int height) {
  ClipSettings settings;
  settings.film.render.width = width;
  settings.film.render.height = height;
  settings.film.view = {.kind = ViewKind::kScene, .name = "overview", .orbit = {}};
  return settings;
}

using SteadyClock = std::chrono::steady_clock;

double SecondsSince(SteadyClock::time_point begin) {
  return std::chrono::duration<double>(SteadyClock::now() - begin).count();
}

/// Renders clips and counts the frames after the start.
void RenderClips(benchmark::State& state, Stage& stage, ClipSettings settings, bool video) {
  const test::TemporaryFolder folder;
  const std::size_t frames = FramesAt(settings.film.render.width);
  const Snapshots snapshots = stage.Film(frames);
  const MonotonicClock clock;
  for (auto _ : state) {
    SteadyClock::time_point begin;
    const ClipPaths paths{video ? folder / "clip.mp4" : std::filesystem::path(), {}};
    RenderClip({&stage.model(), &snapshots}, settings, paths, clock,
               [&begin](std::size_t done, std::size_t) {
                 if (done == kStart) begin = SteadyClock::now();
               });
    state.SetIterationTime(SecondsSince(begin));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(frames - kStart));
}

Stage& Default() {
  static Stage stage(plant::MujocoPlantOptions{}.visual_error);
  return stage;
}

void Whole(benchmark::State& state) {
  RenderClips(state, Default(), SettingsAt(state.range(0), state.range(1)), true);
}

void Draw(benchmark::State& state) {
  RenderClips(state, Default(), SettingsAt(state.range(0), state.range(1)), false);
}

void Plain(benchmark::State& state) {
  static Stage stage(0);
  if (!stage.has_meshes()) return state.SkipWithError("no meshes: scripts/setup fetches them");
  ClipSettings settings = SettingsAt(state.range(0), state.range(1));
  settings.film.render.shadows = false;
  RenderClips(state, stage, settings, true);
}

void ReadBack(benchmark::State& state) {
  const ClipSettings settings = SettingsAt(state.range(0), state.range(1));
  const DrawnModel model(Default().model(), settings.film.render);
  const std::size_t frames = FramesAt(state.range(0));
  const auto read = [&] {
    const DrawnModel::DataPointer data = model.NewData();
    SceneRenderer scene(model.get(), settings.film.render);
    const SceneRenderer::Current current = scene.Use();
    const auto begin = SteadyClock::now();
    for (std::size_t i = 0; i < frames; ++i) benchmark::DoNotOptimize(scene.Read());
    return SecondsSince(begin);
  };
  for (auto _ : state) {
    std::vector<double> seconds(static_cast<std::size_t>(settings.render_threads));
    {
      std::vector<std::jthread> threads;
      for (double& mine : seconds) threads.emplace_back([&mine, &read] { mine = read(); });
    }
    state.SetIterationTime(*std::max_element(seconds.begin(), seconds.end()));
  }
  state.SetItemsProcessed(state.iterations() * settings.render_threads *
                          static_cast<std::int64_t>(frames));
}

void Encode(benchmark::State& state) {
  const test::TemporaryFolder folder;
  const ClipSettings settings = SettingsAt(state.range(0), state.range(1));
  const std::size_t frames = FramesAt(state.range(0));
  const Snapshots snapshots = Default().Film(frames);
  FramePainter painter({&Default().model(), &snapshots}, settings.film);
  std::vector<Image> images;
  for (std::size_t i = 0; i < frames; ++i) images.push_back(painter.Paint(i));
  VideoSettings video;
  video.width = state.range(0);
  video.height = state.range(1);
  for (auto _ : state) {
    VideoWriter writer(folder / "clip.mp4", video);
    SteadyClock::time_point begin;
    for (std::size_t i = 0; i < frames; ++i) {
      if (i == kStart) begin = SteadyClock::now();
      writer.Write(images[i]);
    }
    writer.Finish();
    state.SetIterationTime(SecondsSince(begin));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(frames - kStart));
}

/// Prints as usual and keeps the median frames/s of each case.
class MedianReporter final : public benchmark::ConsoleReporter {
 public:
  MedianReporter() : ConsoleReporter(OO_Tabular) {}

  void ReportRuns(const std::vector<Run>& runs) override {
    benchmark::ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Aggregate || run.aggregate_name != "median") continue;
      const auto items = run.counters.find("items_per_second");
      if (items == run.counters.end()) continue;
      frames_per_second[run.run_name.function_name + "/" + run.run_name.args] = items->second.value;
    }
  }
  std::map<std::string, double> frames_per_second;
};

/// Prints a ratio. @returns whether it is large enough.
bool Demand(const std::string& name, double ratio, double least) {
  std::printf("%-22s %.3f (at least %.1f)\n", name.c_str(), ratio, least);
  return ratio >= least;
}

bool Verdict(const std::map<std::string, double>& rates) {
  bool good = true;
  for (const auto& [width, height] : kSizes) {
    const std::string size = "/" + std::to_string(width) + "/" + std::to_string(height);
    const double slowest =
        std::min({rates.at("Draw" + size), rates.at("ReadBack" + size), rates.at("Encode" + size)});
    good = Demand("pipeline" + size, rates.at("Whole" + size) / slowest, kLeastPipeline) && good;
  }
  const auto plain = rates.find("Plain/640/480");
  if (plain == rates.end()) return good;
  return Demand("quality/640/480", rates.at("Whole/640/480") / plain->second, kLeastQuality) &&
         good;
}

void Register() {
  using Function = void (*)(benchmark::State&);
  const std::array<std::pair<const char*, Function>, 4> cases{
      {{"Whole", Whole}, {"Draw", Draw}, {"ReadBack", ReadBack}, {"Encode", Encode}}};
  for (const auto& [name, function] : cases) {
    for (const auto& [width, height] : kSizes) {
      benchmark::RegisterBenchmark(name, function)->Args({width, height})->UseManualTime();
    }
  }
  benchmark::RegisterBenchmark("Plain", Plain)->Args({640, 480})->UseManualTime();
}

}  // namespace
}  // namespace twin::render

int main(int argc, char** argv) {
  std::string repetitions = "--benchmark_repetitions=5";
  std::string interleave = "--benchmark_enable_random_interleaving=true";
  std::string min_time = "--benchmark_min_time=0.2";
  std::vector<char*> arguments(argv, argv + argc);
  for (std::string* flag : {&repetitions, &interleave, &min_time}) {
    arguments.insert(arguments.begin() + 1, flag->data());
  }
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  twin::render::Register();
  twin::render::MedianReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  return twin::render::Verdict(reporter.frames_per_second) ? 0 : 1;
}
