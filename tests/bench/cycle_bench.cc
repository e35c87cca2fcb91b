// What a cycle costs, as shares of a bare mj_step of the same model, measured in one run.
//
//   int_share    INT alone (cycle and state), no plant, its slowest mode    at most 0.4
//   cycle_share  tick + link + INT + plant + state, in lockstep    at most 1.6
//   record_share the same with every cycle and tick recorded, over cycle_share    at most 1.2
//   pair_share   an arm's cycle beside another arm in one model, over its cycle alone    at
//   most 1.3
//
// The repetitions are interleaved, the shares are of their medians. Exits with 1 when
// a share is too large: absolute times of a shared machine say little, ratios hold.

#include <benchmark/benchmark.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "plugins/backends.h"
#include "support/panda_limits.h"
#include "twin/loop/drive.h"
#include "twin/onboard/onboard_controller.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/plant/shared_model.h"
#include "twin/record/recorder.h"
#include "twin/rt/fiber.h"

namespace twin {
namespace {

constexpr double kMaxIntShare = 0.4;
constexpr double kMaxCycleShare = 1.6;
constexpr double kMaxRecordShare = 1.2;
constexpr double kMaxPairShare = 1.3;
constexpr int kBatch = 1000;
constexpr JointVector kReady{
    0, -0.785398163397, 0, -2.356194490192, 0, 1.570796326795, 0.785398163397};

robot::RobotConfig Robot() {
  robot::RobotConfig config;
  config.onboard.limits = test::PandaLimits();
  config.onboard.cartesian = test::PandaCartesianLimits();
  config.onboard.rotor_inertia = {0.605721456, 0.605721456, 0.462474144, 0.462474144,
                                  0.205544064, 0.205544064, 0.205544064};
  config.plant.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
  config.plant.hand = plant::HandKind::kNone;
  config.link.state.delay =
      faults::DelayModel(faults::LogNormalDelay{std::chrono::microseconds(80), 0.3, {}});
  config.link.command.delay =
      faults::DelayModel(faults::LogNormalDelay{std::chrono::microseconds(80), 0.3, {}});
  config.q_start = kReady;
  return config;
}

void BareMjStep(benchmark::State& state) {
  const auto plant = plant::MujocoPlant::Create(Robot().plant);
  const mjModel& model = plant->model();
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(&model), &mj_deleteData);
  const JointVector hold = plant->GravityTorque(kReady);
  for (auto _ : state) {
    mj_resetData(&model, data.get());
    for (std::size_t i = 0; i < kJoints; ++i) {
      data->qpos[i] = kReady[i];
      data->qfrc_applied[i] = hold[i];
    }
    for (int k = 0; k < kBatch; ++k) mj_step(&model, data.get());
  }
  state.SetItemsProcessed(state.iterations() * kBatch);
}

/// One second of commands that move and come back to rest: joint 3, and EE along z, by sin^4.
std::vector<RobotCommand> Commands() {
  const Transform O_T_EE = model::ArmModel::Panda().Pose(model::Frame::kEndEffector, kReady);
  std::vector<RobotCommand> commands(kBatch);
  double last = 0;
  for (int k = 0; k < kBatch; ++k) {
    const double part = std::pow(std::sin(std::numbers::pi * (k + 1) / kBatch), 4);
    RobotCommand& command = commands[static_cast<std::size_t>(k)];
    command.q_c = kReady;
    command.q_c[2] += 0.02 * part;
    command.dq_c[2] = 0.02 * (part - last) / kCycleSeconds;
    command.O_T_EE_c = O_T_EE;
    command.O_T_EE_c[14] += 0.01 * part;
    command.O_dP_EE_c[2] = 0.01 * (part - last) / kCycleSeconds;
    command.elbow_c = {kReady[2] + 0.02 * part, -1};
    command.valid_elbow = true;
    last = part;
  }
  return commands;
}

constexpr std::array kModes{
    MotionModes{ControllerMode::kJointImpedance, MotionGeneratorMode::kJointPosition},
    MotionModes{ControllerMode::kExternalController, MotionGeneratorMode::kJointVelocity},
    MotionModes{ControllerMode::kCartesianImpedance, MotionGeneratorMode::kJointPosition},
    MotionModes{ControllerMode::kJointImpedance, MotionGeneratorMode::kCartesianPosition},
    MotionModes{ControllerMode::kCartesianImpedance, MotionGeneratorMode::kCartesianPosition},
    MotionModes{ControllerMode::kCartesianImpedance, MotionGeneratorMode::kCartesianVelocity},
};

void IntAlone(benchmark::State& state) {
  onboard::OnboardController interface_controller(Robot().onboard, kReady);
  const JointSensors sensors{kReady,
                             {},
                             model::ArmModel::Panda().Gravity(kReady, Robot().onboard.end_effector),
                             kReady,
                             {}};
  const MotionModes& modes = kModes[static_cast<std::size_t>(state.range(0))];
  const std::vector<RobotCommand> commands = Commands();
  RobotState robot_state;
  interface_controller.FillState(sensors, robot_state);
  static_cast<void>(interface_controller.Move(modes));
  for (auto _ : state) {
    for (const RobotCommand& command : commands) {
      benchmark::DoNotOptimize(interface_controller.Cycle(&command, sensors));
      interface_controller.FillState(sensors, robot_state);
      benchmark::ClobberMemory();
    }
  }
  if (robot_state.robot_mode != RobotMode::kMove) state.SkipWithError("the motion was aborted");
  state.SetItemsProcessed(state.iterations() * kBatch);
}

/// Holds the arm and never ends.
class Hold final : public control::Controller {
 public:
  control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
  }
  void Activate(const RobotState&, Time) override {}
  void Update(const RobotState&, Time, control::ControllerOutput& output) noexcept override {
    output.target.joint.q = kReady;
  }
  void Deactivate() noexcept override {}
};

loop::RunReport HoldStill(loop::Drive& drive, record::RecordSink* sink) {
  Hold hold;
  return drive.Run({.backend = *drive.connection().backend,
                    .controller = hold,
                    .modes = {},
                    .kind = loop::LoopKind::kAsynchronous,
                    .tick = {},
                    .controller_loop = {},
                    .seed = 1,
                    .time_limit = std::chrono::seconds(10),
                    .sink = sink,
                    .progress = {},
                    .event = {},
                    .interrupted = nullptr});
}

/// Ten simulated seconds; `recorded` writes a log as a run does, its completion included.
void RunCycles(benchmark::State& state, bool recorded) {
  const robot::RobotConfig robot = Robot();
  const std::filesystem::path log = std::filesystem::temp_directory_path() / "cycle_bench.mcap";
  backend::Registry registry;
  plugins::RegisterMujoco(registry);
  std::int64_t cycles = 0;
  for (auto _ : state) {
    state.PauseTiming();
    std::unique_ptr<record::Recorder> recorder;
    if (recorded) {
      recorder =
          std::make_unique<record::Recorder>(log, record::RunInfo{}, record::FullRing::kWait);
    }
    auto drive = loop::MakeLockstepDrive(registry.Find("mujoco"), robot, recorder.get());
    state.ResumeTiming();
    const loop::RunReport report = HoldStill(*drive, recorder.get());
    if (recorder) static_cast<void>(recorder->Finish());
    cycles += report.simulated / kCycle;
    state.PauseTiming();
    drive.reset();
    state.ResumeTiming();
  }
  state.SetItemsProcessed(cycles);
  std::filesystem::remove(log);
}

void WholeCycle(benchmark::State& state) {
  RunCycles(state, false);
}
void RecordedCycle(benchmark::State& state) {
  RunCycles(state, true);
}

/// Two arms of one model within reach of each other, each in a fiber, as `run` runs a cell.
void PairCycle(benchmark::State& state) {
  backend::Registry registry;
  plugins::RegisterMujoco(registry);
  std::int64_t cycles = 0;  // of both
  for (auto _ : state) {
    state.PauseTiming();
    std::array<robot::RobotConfig, 2> robots{Robot(), Robot()};
    std::vector<plant::MujocoPlantOptions> plants;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      plant::MujocoPlantOptions& plant = robots[i].plant;
      plant.prefix = i == 0 ? "left/" : "right/";
      plant.pose = {.position = {0, i == 0 ? 0.6 : -0.6, 0}};
      plants.push_back(plant);
    }
    const auto shared = plant::SharedModel::Create(plants, [] { rt::Fiber::Yield(); });
    std::vector<std::unique_ptr<loop::Drive>> drives;
    for (robot::RobotConfig& robot : robots) {
      robot.plant.shared = shared;
      drives.push_back(loop::MakeLockstepDrive(registry.Find("mujoco"), robot, nullptr));
    }
    std::deque<rt::Fiber> runs;
    for (std::unique_ptr<loop::Drive>& drive : drives) {
      runs.emplace_back([&cycles, &drive] {
        cycles += HoldStill(*drive, nullptr).simulated / kCycle;
        drive.reset();  // the other goes on without
      });
    }
    state.ResumeTiming();
    rt::ResumeInTurn(runs);
  }
  state.SetItemsProcessed(cycles);
}

BENCHMARK(BareMjStep)->UseRealTime();
BENCHMARK(IntAlone)->DenseRange(0, kModes.size() - 1)->UseRealTime();
BENCHMARK(WholeCycle)->UseRealTime();
BENCHMARK(RecordedCycle)->UseRealTime();
BENCHMARK(PairCycle)->UseRealTime();

/// Prints as usual and keeps the median time per item of each benchmark; of one with several cases
/// the slowest.
class MedianReporter final : public benchmark::ConsoleReporter {
 public:
  MedianReporter() : ConsoleReporter(OO_Tabular) {}

  void ReportRuns(const std::vector<Run>& runs) override {
    benchmark::ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Aggregate || run.aggregate_name != "median") continue;
      const auto items = run.counters.find("items_per_second");
      if (items != run.counters.end()) {
        double& slowest = seconds_per_item[run.run_name.function_name];
        slowest = std::max(slowest, 1.0 / items->second.value);
      }
    }
  }
  std::map<std::string, double> seconds_per_item;
};

int Verdict(const MedianReporter& reporter) {
  for (const char* name : {"BareMjStep", "IntAlone", "WholeCycle", "RecordedCycle", "PairCycle"}) {
    if (reporter.seconds_per_item.contains(name)) continue;
    std::fprintf(stderr, "cycle_bench: no ratios without %s; leave --benchmark_filter out\n", name);
    return 2;
  }
  const double step = reporter.seconds_per_item.at("BareMjStep");
  const double int_share = reporter.seconds_per_item.at("IntAlone") / step;
  const double cycle = reporter.seconds_per_item.at("WholeCycle");
  const double cycle_share = cycle / step;
  const double record_share = reporter.seconds_per_item.at("RecordedCycle") / cycle;
  const double pair_share = reporter.seconds_per_item.at("PairCycle") / cycle;
  std::printf("mj_step      %.2f us\n", step * 1e6);
  std::printf("int_share    %.3f (at most %.1f)\n", int_share, kMaxIntShare);
  std::printf("cycle_share  %.3f (at most %.1f)\n", cycle_share, kMaxCycleShare);
  std::printf("record_share %.3f (at most %.1f)\n", record_share, kMaxRecordShare);
  std::printf("pair_share   %.3f (at most %.1f)\n", pair_share, kMaxPairShare);
  return int_share <= kMaxIntShare && cycle_share <= kMaxCycleShare &&
                 record_share <= kMaxRecordShare && pair_share <= kMaxPairShare
             ? 0
             : 1;
}

}  // namespace
}  // namespace twin

int main(int argc, char** argv) {
  std::string repetitions = "--benchmark_repetitions=7";
  std::string interleave = "--benchmark_enable_random_interleaving=true";
  std::string min_time = "--benchmark_min_time=0.2";
  std::vector<char*> arguments(argv, argv + argc);
  for (std::string* flag : {&repetitions, &interleave, &min_time}) {
    arguments.insert(arguments.begin() + 1, flag->data());
  }
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  twin::MedianReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  return twin::Verdict(reporter);
}
