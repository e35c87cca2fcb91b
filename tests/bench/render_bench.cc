// What a video costs against its stages, each measured alone in the same round: frames/s
// once it runs.
//
//   whole      RenderClip to an MP4
//   draw       RenderClip to nothing: draws and reads back
//   encode     VideoWriter, pictures that are already there
//   plain      whole, of Franka's meshes as they are without shadows
//
//   pipeline   whole over the slowest stage         at least 0.9
//   quality    whole over plain at 640x480          at least 0.8
//
// What is compared is measured in turn in each of several rounds, and the median of the rounds'
// ratios counts: what a shared machine does to times, it does to both. Exits with 1 when a ratio is
// too small. Mesa's own threads are off, so that drawing leaves a processor to encoding; with one
// processor nothing is demanded of the pipeline. Without Franka's meshes, no quality.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
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
  return kStart + static_cast<std::size_t>(width < 640 ? 80 : width < 1280 ? 50 : 30);
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
      record::SceneRecord scene;
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

double RateOfClip(Stage& stage, const ClipSettings& settings, bool video) {
  const test::TemporaryFolder folder;
  const std::size_t frames = FramesAt(settings.film.render.width);
  const Snapshots snapshots = stage.Film(frames);
  SteadyClock::time_point begin;
  const ClipPaths paths{video ? folder / "clip.mp4" : std::filesystem::path(), {}};
  RenderClip({&stage.model(), &snapshots}, settings, paths, MonotonicClock(),
             [&begin](std::size_t done, std::size_t) {
               if (done == kStart) begin = SteadyClock::now();
             });
  return static_cast<double>(frames - kStart) / SecondsSince(begin);
}

double RateOfEncoding(const std::vector<Image>& images) {
  const test::TemporaryFolder folder;
  VideoSettings video;
  video.width = images.front().width;
  video.height = images.front().height;
  VideoWriter writer(folder / "clip.mp4", video);
  SteadyClock::time_point begin;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (i == kStart) begin = SteadyClock::now();
    writer.Write(images[i]);
  }
  writer.Finish();
  return static_cast<double>(images.size() - kStart) / SecondsSince(begin);
}

std::vector<Image> Pictures(Stage& stage, const ClipSettings& settings) {
  const std::size_t frames = FramesAt(settings.film.render.width);
  const Snapshots snapshots = stage.Film(frames);
  FramePainter painter({&stage.model(), &snapshots}, settings.film);
  std::vector<Image> images;
  for (std::size_t i = 0; i < frames; ++i) images.push_back(painter.Paint(i));
  return images;
}

Stage& Default() {
  static Stage stage(plant::MujocoPlantOptions{}.visual_error);
  return stage;
}

/// Width and height are the arguments.
ClipSettings SettingsOf(const benchmark::State& state) {
  return SettingsAt(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
}

/// One round: the whole and its stages, in turn.
void Clip(benchmark::State& state) {
  const ClipSettings settings = SettingsOf(state);
  const std::vector<Image> images = Pictures(Default(), settings);
  for (auto _ : state) {
    const double whole = RateOfClip(Default(), settings, true);
    const double draw = RateOfClip(Default(), settings, false);
    const double encode = RateOfEncoding(images);
    state.counters["whole"] = whole;
    state.counters["draw"] = draw;
    state.counters["encode"] = encode;
    state.counters["pipeline"] = whole / std::min(draw, encode);
  }
}

void Quality(benchmark::State& state) {
  static Stage plain(0);
  if (!plain.has_meshes()) return state.SkipWithError("no meshes: scripts/setup fetches them");
  const ClipSettings settings = SettingsOf(state);
  ClipSettings without_shadows = settings;
  without_shadows.film.render.shadows = false;
  for (auto _ : state) {
    const double whole = RateOfClip(Default(), settings, true);
    const double reference = RateOfClip(plain, without_shadows, true);
    state.counters["whole"] = whole;
    state.counters["plain"] = reference;
    state.counters["quality"] = whole / reference;
  }
}

/// Prints as usual and keeps the medians of what is demanded.
class MedianReporter final : public benchmark::ConsoleReporter {
 public:
  MedianReporter() : ConsoleReporter(OO_Tabular) {}

  void ReportRuns(const std::vector<Run>& runs) override {
    benchmark::ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Aggregate || run.aggregate_name != "median") continue;
      for (const auto& [name, counter] : run.counters) {
        medians[run.run_name.function_name + "/" + run.run_name.args][name] = counter.value;
      }
    }
  }
  std::map<std::string, std::map<std::string, double>> medians;
};

/// @returns whether a ratio is large enough, and prints it.
bool Demand(const std::string& what, double ratio, double least) {
  std::printf("%-28s %.3f (at least %.1f)\n", what.c_str(), ratio, least);
  return ratio >= least;
}

std::string NameOf(const char* what, int width, int height) {
  return std::string(what) + "/" + std::to_string(width) + "/" + std::to_string(height);
}

void Register() {
  for (const auto& [width, height] : kSizes) {
    benchmark::RegisterBenchmark("Clip", Clip)->Args({width, height})->Iterations(1);
  }
  benchmark::RegisterBenchmark("Quality", Quality)->Args({640, 480})->Iterations(1);
}

bool Verdict(const MedianReporter& reporter) {
  bool good = true;
  const auto demand = [&](const std::string& name, const char* ratio, double least) {
    good = Demand(name + " " + ratio, reporter.medians.at(name).at(ratio), least) && good;
  };
  for (const auto& [width, height] : kSizes) {
    if (std::thread::hardware_concurrency() == 1) break;
    demand(NameOf("Clip", width, height), "pipeline", kLeastPipeline);
  }
  const std::string quality = NameOf("Quality", 640, 480);
  if (reporter.medians.contains(quality)) demand(quality, "quality", kLeastQuality);
  return good;
}

}  // namespace
}  // namespace twin::render

int main(int argc, char** argv) {
  setenv("LP_NUM_THREADS", "0", /*overwrite=*/1);
  std::string repetitions = "--benchmark_repetitions=7";
  std::string aggregates = "--benchmark_display_aggregates_only=true";
  std::vector<char*> arguments(argv, argv + argc);
  for (std::string* flag : {&repetitions, &aggregates}) {
    arguments.insert(arguments.begin() + 1, flag->data());
  }
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  twin::render::Register();
  twin::render::MedianReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  return twin::render::Verdict(reporter) ? 0 : 1;
}
