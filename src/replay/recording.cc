#include "twin/replay/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <variant>

#include "twin/core/error.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"
#include "twin/plant/compiled_model.h"
#include "twin/record/log_reader.h"
#include "twin/replay/time_line.h"

namespace twin::replay {
namespace {

constexpr int kMostFps = 1000;

/// The arm at an instant.
struct ArmSample {
  Time at{};
  JointVector q{};
  std::optional<BasePose> odometry;  ///< of a mobile base
};

ArmSample SampleOf(const record::CycleRecord& cycle) {
  ArmSample sample{cycle.at, cycle.state.q, {}};
  if (cycle.base) sample.odometry = cycle.base->odometry;
  return sample;
}

/// The parts of a log for rendering. Visitor of its records.
class Contents {
 public:
  /// @param fps  rate at which the arm is sampled. @param scenes  receives the scenes.
  /// @param log  for messages.
  Contents(int fps, render::Snapshots& scenes, const std::filesystem::path& log)
      : fps_(fps), scenes_(scenes), log_(log) {}

  void operator()(const record::CycleRecord& cycle) {
    while (arm.empty() || cycle.at >= Due()) {
      if (arm.size() == kMostFrames) {
        throw InputError(fmt::format(
            "{}: its cycles span {:.0f} s, too long for {} frames a second; is it damaged?",
            log_.string(), ToSeconds(cycle.at - arm.front().at), fps_));
      }
      arm.push_back(SampleOf(cycle));
    }
  }
  void operator()(const record::TickRecord& /*tick*/) { has_ticks = true; }
  void operator()(const record::EventRecord& event) { events.push_back(event); }
  void operator()(const record::SceneRecord& scene) {
    if (scene.positions != scenes_.qpos_size()) {
      throw InputError(fmt::format(
          "{}: a scene in the log has {} positions, and the model made of its scenario has {}: "
          "robot, scene file or program are not those of the run; name them with --data",
          log_.string(), scene.positions, scenes_.qpos_size()));
    }
    scenes_.Append(scene);
  }
  void operator()(const record::PlanRecord& plan) { plans.push_back(plan); }

  std::vector<ArmSample> arm;  ///< one per frame: the first cycle at or after its instant
  std::vector<record::PlanRecord> plans;
  std::vector<record::EventRecord> events;
  bool has_ticks = false;

 private:
  [[nodiscard]] Time Due() const {
    return arm.front().at + Duration(static_cast<std::int64_t>(arm.size()) * std::nano::den / fps_);
  }

  int fps_;
  render::Snapshots& scenes_;
  const std::filesystem::path& log_;
};

scenario::Scenario ScenarioOf(const std::filesystem::path& log, const record::RunInfo& run) {
  if (run.scenario_yaml.empty()) {
    throw InputError(fmt::format(
        "{}: the log holds no scenario, so there is nothing to draw; name the log of a run, of "
        "which more than the beginning was written",
        log.string()));
  }
  return scenario::Parse(run.scenario_yaml, log.string() + ": scenario.yaml");
}

plant::CompiledModel ModelOf(const scenario::Scenario& scenario, const scenario::RobotData& robot,
                             const run::RunFiles& files) {
  return plant::CompileModel(run::MakeRobotConfig(scenario, robot, files).plant);
}

}  // namespace

class Recording::Impl {
 public:
  Impl(const std::filesystem::path& log, const run::RunFiles& files, int least_fps)
      : Impl(log, record::LogReader(log), files, least_fps) {}

  const record::RunInfo run;
  const bool truncated;
  const scenario::Scenario scenario;
  const scenario::RobotData robot;
  const Transform F_T_EE;
  const plant::CompiledModel compiled;
  FrameSource source = FrameSource::kScenes;
  bool is_served = false;  ///< no workstation of ours led the robot
  std::vector<record::PlanRecord> plans;
  std::vector<record::EventRecord> events;
  std::optional<render::Snapshots> snapshots;  ///< always set after construction

 private:
  Impl(const std::filesystem::path& log, record::LogReader reader, const run::RunFiles& files,
       int least_fps)
      : run(reader.run()),
        truncated(reader.truncated()),
        scenario(ScenarioOf(log, run)),
        robot(scenario::LoadRobotData(files.models, scenario.robot.model, scenario.robot.hand)),
        F_T_EE(robot.F_T_EE(scenario.onboard.NE_T_EE)),
        compiled(ModelOf(scenario, robot, files)) {
    const int fps = std::max(scenario.render.fps, std::min(least_fps, kMostFps));
    snapshots.emplace(scenario.render.fps, plant::PositionsAt(compiled, {}).size());
    Contents contents(fps, *snapshots, log);
    record::LogEntry entry;
    while (reader.Next(entry)) std::visit(contents, entry);
    if (snapshots->size() == 0) TakeStates(contents.arm, fps, log);
    plans = std::move(contents.plans);
    events = std::move(contents.events);
    is_served = !contents.has_ticks;
  }

  void TakeStates(const std::vector<ArmSample>& arm, int fps, const std::filesystem::path& log) {
    if (arm.empty()) {
      throw InputError(fmt::format(
          "{} holds no state of the robot, so there is nothing to draw; name the log of a run that "
          "began",
          log.string()));
    }
    record::SceneRecord scene;
    if (snapshots->qpos_size() > scene.qpos.size()) {
      throw InputError(fmt::format("{}: its scene has {} positions; a picture takes {} at most",
                                   log.string(), snapshots->qpos_size(), scene.qpos.size()));
    }
    source = FrameSource::kStates;
    scene.positions = static_cast<std::uint32_t>(snapshots->qpos_size());
    snapshots.emplace(fps, snapshots->qpos_size());
    snapshots->Reserve(arm.size());
    for (const ArmSample& sample : arm) {
      scene.at = sample.at;
      std::vector<double> positions = plant::PositionsAt(compiled, sample.q);
      if (sample.odometry) plant::MoveBase(compiled, *sample.odometry, positions);
      std::ranges::copy(positions, scene.qpos.begin());
      snapshots->Append(scene);
    }
  }
};

Recording::Recording(const std::filesystem::path& log, const run::RunFiles& files, int least_fps)
    : impl_(std::make_unique<Impl>(log, files, least_fps)) {}

Recording::~Recording() = default;
Recording::Recording(Recording&&) noexcept = default;

const record::RunInfo& Recording::run() const noexcept {
  return impl_->run;
}

const scenario::Scenario& Recording::scenario() const noexcept {
  return impl_->scenario;
}

FrameSource Recording::source() const noexcept {
  return impl_->source;
}

bool Recording::truncated() const noexcept {
  return impl_->truncated;
}

const mjModel_& Recording::model() const noexcept {
  return *impl_->compiled.model;
}

const render::Snapshots& Recording::snapshots() const noexcept {
  return *impl_->snapshots;
}

JointVector Recording::ArmIn(std::span<const double> qpos) const {
  return plant::ArmIn(impl_->compiled, qpos);
}

Vector3 Recording::ToolAt(std::size_t frame) const {
  const std::span<const double> qpos = snapshots().qpos(frame);
  const Transform O_T_EE =
      model::ArmModel::Panda().Pose(model::Frame::kEndEffector, ArmIn(qpos), impl_->F_T_EE);
  const Transform W_T_EE = model::Multiply(plant::ArmBaseIn(impl_->compiled, qpos), O_T_EE);
  return {W_T_EE[12], W_T_EE[13], W_T_EE[14]};
}

const std::vector<record::PlanRecord>& Recording::plans() const noexcept {
  return impl_->plans;
}

const std::vector<record::EventRecord>& Recording::events() const noexcept {
  return impl_->events;
}

render::Film Recording::Film() const {
  render::Film film = FilmOfRun(model(), snapshots(), scenario(), plans(), events());
  if (impl_->is_served) {
    film.title = film.title.substr(0, film.title.find('\n')) + "\nserved, led by its client";
  }
  if (source() == FrameSource::kStates) film.title += "\nnot recorded: hand, objects, base";
  return film;
}

}  // namespace twin::replay
