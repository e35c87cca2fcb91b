#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include "arrays.h"
#include "bindings.h"
#include "home_process.h"
#include "place.h"
#include "twin/core/error.h"
#include "twin/core/robot_errors.h"
#include "twin/plant/observers.h"
#include "twin/render/frame_painter.h"
#include "twin/run/stepped_robot.h"
#include "twin/run/work_pool.h"

// What panda_twin.envs stands on: robots in lockstep that are led step by step.
namespace twin::python {
namespace {

using namespace nb::literals;  // NOLINT(google-build-using-namespace): "name"_a

template <typename Number, typename... Shape>
using Buffer = nb::ndarray<Number, nb::c_contig, nb::device::cpu, Shape...>;
using RowBuffer = Buffer<double, nb::ndim<2>>;

/// Numbers of a target: seven of the interface (a pose: as Place), and the fingers: > 0 opens,
/// < 0 grasps, 0 leaves them alone.
constexpr std::size_t kTargetSize = 8;

std::map<std::string, Transform> PosesOf(const std::map<std::string, Place>& places) {
  std::map<std::string, Transform> poses;
  for (const auto& [body, place] : places) poses.emplace(body, PoseOf(place.data()));
  return poses;
}

/// How the fingers of an environment are commanded.
struct Fingers {
  double open = kHandStroke;  ///< m
  double speed = 0.1;         ///< m/s
  double force = 30;          ///< N
};

/// What all robots of an environment have in common.
struct Cell {
  scenario::Scenario scenario;
  Fingers fingers;
};

control::CommandInterface InterfaceNamed(const std::string& name) {
  using enum control::CommandInterface;
  if (name == "joint_position") return kJointPosition;
  if (name == "joint_velocity") return kJointVelocity;
  if (name == "cartesian_pose") return kCartesianPose;
  if (name == "torque") return kTorque;
  throw InputError("interface: \"" + name +
                   "\" is unknown; say cartesian_pose, joint_position, joint_velocity or torque");
}

/// Delays of a measured site, and its losses unless the scenario has its own: those of link, tick
/// and controller of a calibrated scenario, or of the asynchronous one of a calibration folder
/// (models/experiments).
void TakeDelays(const std::filesystem::path& from, scenario::Scenario& scenario) {
  const bool is_folder = std::filesystem::is_directory(from);
  const scenario::Scenario site = scenario::Load(is_folder ? from / "asynchronous.yaml" : from);
  scenario::LinkSection link = site.link;
  if (scenario.link.state.loss != scenario::Loss()) link.state.loss = scenario.link.state.loss;
  if (scenario.link.command.loss != scenario::Loss())
    link.command.loss = scenario.link.command.loss;
  scenario.link = link;
  scenario.tick.cost = site.tick.cost;
  scenario.controller.wake_delay = site.controller.wake_delay;
  scenario.controller.cost = site.controller.cost;
}

/// One robot, and what an environment has asked of its hand.
struct Stepped {
  explicit Stepped(const Cell& cell) : robot(cell.scenario, Files()) {}
  run::SteppedRobot robot;
  int fingers = 0;  ///< sign of the last command
};

/// Robots that are stepped together, each with the same cell. In a fork other threads step them.
///
/// Threads: one at a time; std::runtime_error else.
class Robots {
 public:
  class Use {
   public:
    explicit Use(Robots& robots) : robots_(robots) {
      if (!robots.in_use_.exchange(true, std::memory_order_acq_rel)) return;
      throw std::runtime_error(
          "the environment is in use by another thread; take one environment for each thread");
    }
    ~Use() { robots_.in_use_.store(false, std::memory_order_release); }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

   private:
    Robots& robots_;
  };

  Robots(Cell cell, std::size_t count, int threads)
      : cell_(std::move(cell)),
        threads_(threads),
        pool_(std::make_unique<run::WorkPool>(threads)),
        robots_(count) {
    if (count == 0) throw InputError("robots: there must be at least one");
    pool_->ForEach(count, [&](std::size_t i) { robots_[i] = std::make_unique<Stepped>(cell_); });
  }

  ~Robots() {
    if (home_.is_elsewhere()) static_cast<void>(pool_.release());
  }
  Robots(const Robots&) = delete;
  void operator=(const Robots&) = delete;
  [[nodiscard]] std::size_t row_size() const {
    return run::StepReport::kSize +
           robots_[0]->robot.objects().size() * run::SteppedRobot::kObjectSize;
  }
  [[nodiscard]] const std::vector<std::string>& objects() const {
    return robots_[0]->robot.objects();
  }
  [[nodiscard]] run::SteppedRobot& robot(std::size_t i) { return At(i).robot; }

  void Reset(const std::vector<std::size_t>& which, const std::vector<run::EpisodeStart>& starts,
             const RowBuffer& rows) {
    if (which.size() != starts.size()) throw InputError("reset: one start per robot is needed");
    for (const std::size_t i : which) Require(i, rows);
    const Use use(*this);
    const GilReleased release;
    Pool().ForEach(which.size(), [&](std::size_t k) {
      Stepped& stepped = *robots_[which[k]];
      stepped.robot.Reset(starts[k]);
      stepped.fingers = 0;
      Write(which[k], rows);
    });
  }

  void Step(const RowBuffer& targets, const Buffer<const bool, nb::ndim<1>>& mask,
            std::uint64_t cycles, const RowBuffer& rows) {
    const std::size_t count = robots_.size();
    if (targets.shape(0) != count || targets.shape(1) != kTargetSize || mask.shape(0) != count) {
      throw InputError("step: targets must be (robots, 8), the mask (robots,)");
    }
    Require(count - 1, rows);
    const Use use(*this);
    const GilReleased release;
    if (count == 1) {
      if (mask.data()[0]) StepOne(0, targets, cycles, rows);
      return;
    }
    Pool().ForEach(count, [&](std::size_t i) {
      if (mask.data()[i]) StepOne(i, targets, cycles, rows);
    });
  }

  void KeepAsStart() {
    const Use use(*this);
    const GilReleased release;
    Pool().ForEach(robots_.size(), [&](std::size_t i) { robots_[i]->robot.KeepAsStart(); });
  }

  [[nodiscard]] std::string Describe(std::size_t i) {
    return (Use(*this), At(i).robot.DescribeErrors());
  }

 private:
  [[nodiscard]] run::WorkPool& Pool() {
    if (home_.is_elsewhere()) {  // its threads are not here to be joined
      static_cast<void>(pool_.release());
      pool_ = std::make_unique<run::WorkPool>(threads_);
      home_ = HomeProcess();
    }
    return *pool_;
  }
  [[nodiscard]] Stepped& At(std::size_t i) {
    if (i >= robots_.size())
      throw InputError("robots: there is none of number " + std::to_string(i));
    return *robots_[i];
  }
  void Require(std::size_t i, const RowBuffer& rows) {
    static_cast<void>(At(i));
    if (rows.shape(0) != robots_.size() || rows.shape(1) != row_size()) {
      throw InputError("rows: they must be (robots, row_size)");
    }
  }

  void StepOne(std::size_t i, const RowBuffer& targets, std::uint64_t cycles,
               const RowBuffer& rows) {
    Stepped& stepped = *robots_[i];
    const double* const target = targets.data() + i * kTargetSize;
    stepped.robot.SetTarget(TargetOf(target));
    Command(target[7], stepped);
    stepped.robot.Advance(cycles);
    Write(i, rows);
  }

  [[nodiscard]] reference::Target TargetOf(const double* numbers) const {
    using enum control::CommandInterface;
    reference::Target target;
    switch (cell_.scenario.motion.interface) {
      case kJointPosition: std::copy_n(numbers, kJoints, target.joint.q.begin()); break;
      case kJointVelocity: std::copy_n(numbers, kJoints, target.joint.dq.begin()); break;
      case kTorque: std::copy_n(numbers, kJoints, target.tau_J_d.begin()); break;
      case kCartesianPose: target.pose.O_T_EE = PoseOf(numbers); break;
    }
    return target;
  }

  /// Commands the hand when the sign of `wish` has changed.
  void Command(double wish, Stepped& stepped) const {
    const int sign = wish > 0 ? 1 : wish < 0 ? -1 : 0;
    if (sign == 0 || sign == stepped.fingers) return;
    stepped.fingers = sign;
    const Fingers& how = cell_.fingers;
    if (sign > 0) {
      static_cast<void>(stepped.robot.StartHand(hand::Move{how.open, how.speed}));
    } else {
      static_cast<void>(stepped.robot.StartHand(hand::Grasp{.width = 0,
                                                            .speed = how.speed,
                                                            .force = how.force,
                                                            .epsilon_inner = kHandStroke,
                                                            .epsilon_outer = kHandStroke}));
    }
  }

  void Write(std::size_t i, const RowBuffer& rows) {
    double* const row = rows.data() + i * row_size();
    const run::SteppedRobot& robot = robots_[i]->robot;
    std::memcpy(row, &robot.report(), sizeof(run::StepReport));
    robot.CopyObjects({row + run::StepReport::kSize, row_size() - run::StepReport::kSize});
  }

  const Cell cell_;
  const int threads_;
  HomeProcess home_;
  std::unique_ptr<run::WorkPool> pool_;
  std::vector<std::unique_ptr<Stepped>> robots_;
  std::atomic<bool> in_use_{false};  ///< acquire-release: the robots' memory goes with it
};

/// Pictures of a robot.
class Camera {
 public:
  Camera(Robots& robots, std::size_t robot, const std::string& view, int width, int height)
      : robots_(robots), truth_(robots.robot(robot).truth()), snapshots_(1, 0) {
    if (truth_ == nullptr) throw InputError("camera: the ideal plant has no bodies to draw");
    settings_.render.width = width;
    settings_.render.height = height;
    settings_.overlays.text = false;
    settings_.view.kind =
        view == "panda_hand" ? render::ViewKind::kGripper : render::ViewKind::kScene;
    settings_.view.name = view == "panda_hand" ? "" : view;
    film_.model = &truth_->model();
    film_.snapshots = &snapshots_;
    const Robots::Use use(robots_);
    const GilReleased release;
    Look();
    painter_ = std::make_unique<render::FramePainter>(film_, settings_);
  }

  /// Draws what is there now, and small balls at `marks`.
  void Draw(const std::vector<Vector3>& marks, const Buffer<std::uint8_t, nb::ndim<3>>& out) {
    Require(out, 3);
    const Robots::Use use(robots_);
    const GilReleased release;
    Look();
    render::PlannedGoal goal;
    goal.path = marks;
    const render::Image image = painter_->Paint(0, goal);
    std::ranges::copy(image.rgb, out.data());
  }

  void Depth(const Buffer<float, nb::ndim<3>>& out) {
    Require(out, 1);
    const Robots::Use use(robots_);
    const GilReleased release;
    Look();
    const render::DepthImage image = painter_->Depth(0);
    std::ranges::copy(image.depth_m, out.data());
  }

 private:
  template <typename Out>
  void Require(const Out& out, std::size_t channels) const {
    const render::RenderSettings& size = settings_.render;
    if (out.shape(0) == static_cast<std::size_t>(size.height) &&
        out.shape(1) == static_cast<std::size_t>(size.width) && out.shape(2) == channels) {
      return;
    }
    throw InputError("camera: the array must be (height, width, channels)");
  }
  void Look() {
    record::SceneRecord scene;
    plant::CaptureScene(Time(), *truth_, scene);
    snapshots_ = render::Snapshots(1, truth_->qpos_size());
    snapshots_.Append(scene);
  }

  Robots& robots_;
  const plant::TruthProbe* truth_;
  render::Snapshots snapshots_;
  render::Film film_;
  render::FilmSettings settings_;
  std::unique_ptr<render::FramePainter> painter_;
};

std::unique_ptr<Robots> MakeRobots(const std::string& text, const std::string& name,
                                   const std::string& interface, bool cartesian_impedance,
                                   const std::optional<std::filesystem::path>& delays,
                                   std::size_t count, int threads, double grasp_force) {
  const GilReleased release;
  Cell cell{scenario::ParseServed(text, name), {}};
  if (delays) TakeDelays(*delays, cell.scenario);
  cell.scenario.motion.interface = InterfaceNamed(interface);
  if (cartesian_impedance) cell.scenario.motion.controller = ControllerMode::kCartesianImpedance;
  cell.fingers.force = grasp_force;
  return std::make_unique<Robots>(std::move(cell), count, threads);
}

run::EpisodeStart MakeStart(std::uint64_t seed, const std::optional<JointVector>& q,
                            const std::map<std::string, Place>& places,
                            std::map<std::string, double> masses,
                            std::map<std::string, double> frictions, std::optional<double> delay_s,
                            std::optional<double> loss) {
  run::EpisodeStart start;
  start.seed = seed;
  start.q = q;
  start.places = PosesOf(places);
  start.masses = std::move(masses);
  start.frictions = std::move(frictions);
  if (delay_s) start.delay = SecondsFrom(*delay_s, "delay, s,");
  start.loss = loss;
  return start;
}

std::vector<std::string> NamesOf(std::uint64_t errors) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
    if ((errors >> i & 1) != 0) names.emplace_back(Name(static_cast<RobotError>(i)));
  }
  return names;
}

}  // namespace

void AddEnvs(nb::module_& module) {
  nb::class_<run::EpisodeStart>(module, "EpisodeStart")
      .def(
          "__init__",
          [](run::EpisodeStart* self, std::uint64_t seed, std::optional<JointVector> q,
             const std::map<std::string, Place>& places, std::map<std::string, double> masses,
             std::map<std::string, double> frictions, std::optional<double> delay_s,
             std::optional<double> loss) {
            new (self) run::EpisodeStart(
                MakeStart(seed, q, places, std::move(masses), std::move(frictions), delay_s, loss));
          },
          nb::kw_only(), "seed"_a, "q"_a.none(), "places"_a, "masses"_a, "frictions"_a,
          "delay_s"_a.none(), "loss"_a.none());
  nb::class_<Robots>(module, "SteppedRobots")
      .def(nb::new_(&MakeRobots), nb::kw_only(), "scenario"_a, "name"_a, "interface"_a,
           "cartesian_impedance"_a, "delays"_a.none(), "count"_a, "threads"_a, "grasp_force"_a)
      .def_prop_ro("row_size", &Robots::row_size)
      .def_prop_ro("objects", &Robots::objects)
      .def("reset", &Robots::Reset, "which"_a, "starts"_a, "rows"_a)
      .def("step", &Robots::Step, "targets"_a, "mask"_a, "cycles"_a, "rows"_a)
      .def("keep_as_start", &Robots::KeepAsStart)
      .def("describe_errors", &Robots::Describe, "robot"_a);
  nb::class_<Camera>(module, "SteppedCamera")
      .def(nb::init<Robots&, std::size_t, const std::string&, int, int>(), nb::keep_alive<1, 2>(),
           nb::kw_only(), "robots"_a, "robot"_a, "view"_a, "width"_a, "height"_a)
      .def("draw", &Camera::Draw, "marks"_a, "out"_a)
      .def("depth", &Camera::Depth, "out"_a);
  module.def("step_fields", [] {
    std::map<std::string, std::pair<std::size_t, std::size_t>> fields;
    for (const run::StepReport::Field& field : run::StepReport::Fields()) {
      fields.emplace(field.name, std::pair(field.begin, field.size));
    }
    return fields;
  });
  module.def("error_names", &NamesOf, "errors"_a);
}

}  // namespace twin::python
