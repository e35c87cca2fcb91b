#include "twin/server/served_robot.h"

#include <stop_token>
#include <string_view>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/core/modes.h"
#include "twin/plant/observers.h"
#include "twin/robot/wall_clock_robot.h"
#include "twin/server/udp_port.h"
#include "twin/server/wake_event.h"

namespace twin::server {
namespace {

/// First port in the search for two free ones.
constexpr std::uint16_t kFirstPort = 21337;
constexpr std::uint16_t kLastPort = 21537;

rt::ThreadSettings ThreadOf(const ServedRobotSettings& settings) {
  if (settings.thread) return *settings.thread;
  if (settings.lockstep) return {.name = "twin-int", .lock_memory = false};
  return {.name = "twin-int", .fifo_priority = 98};
}

}  // namespace

class ServedRobot::Impl {
 public:
  Impl(const robot::RobotConfig& config, robot::MadePlant plant, ServedRobotSettings settings)
      : port_(clock_, settings.server.address, changed_, fci::Protocol{config.protocol}),
        plant_name_(std::move(plant.name)),
        engine_(plant.engine),
        limits_(config.onboard.limits) {
    settings.server.protocol = fci::Protocol{config.protocol};
    port_.KeepIn(settings.server.capture);
    const rt::ThreadSettings thread = ThreadOf(settings);
    if (settings.lockstep) {
      robot_ = &lockstep_.emplace(config, std::move(plant.plant), port_, port_, clock_, thread,
                                  settings.sink, *settings.lockstep);
    } else {
      robot_ = &wall_clock_.emplace(config, std::move(plant.plant), port_, clock_, thread,
                                    settings.sink);
    }
    if (engine_ != nullptr) plant::RequireFreeStart(*engine_);
    if (!settings.tell) settings.tell = [](std::string_view) {};
    settings.takes_free_ports ? ListenAnywhere(settings) : Listen(settings);
  }
  ~Impl() { End(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void Begin() { robot_->Begin(); }
  void Serve(const std::function<bool()>& ends) { server_->Run(ends); }
  void Start() {
    Begin();
    serving_ = std::jthread(
        [this](const std::stop_token& stop) { Serve([&stop] { return stop.stop_requested(); }); });
  }
  void StopServing() {
    if (!serving_.joinable()) return;
    serving_.request_stop();
    changed_.Notify();
    serving_.join();
  }
  void End() {
    StopServing();
    robot_->End();
  }

  void Place(const std::string& name, const Transform& X_WB) {
    if (engine_ == nullptr) {
      throw InputError("place: the ideal plant has no objects; serve a scenario with kind: mujoco");
    }
    const int body = plant::FreeBodyNamed(engine_->model(), name);
    const std::optional<plant::Overlap> overlap = robot_->Place(body, X_WB);
    if (!overlap) return;
    throw InputError(plant::DescribeOverlap(engine_->model(), name, *overlap));
  }
  void RequireFree(const JointVector& q) const {
    if (engine_ == nullptr) return;
    for (std::size_t i = 0; i < kJoints; ++i) {
      if (!(q[i] >= limits_.q_min[i] && q[i] <= limits_.q_max[i])) return;
    }
    plant::RequireShallow(plant::ArmOverlapAt(engine_->model(), q), "reset");
  }
  void PressUserStop(bool pressed) {
    static_cast<void>(
        robot_->Operate(pressed ? PanelAction::kPressUserStop : PanelAction::kReleaseUserStop));
  }

  [[nodiscard]] const Server& server() const noexcept { return *server_; }
  [[nodiscard]] const robot::ThreadedRobot& robot() const noexcept { return *robot_; }
  [[nodiscard]] robot::ThreadedRobot& robot() noexcept { return *robot_; }
  [[nodiscard]] robot::AnswerPacedRobot* lockstep() noexcept {
    return lockstep_ ? &*lockstep_ : nullptr;
  }
  [[nodiscard]] const robot::WallClockRobot& wall_clock() const {
    TWIN_CHECK(wall_clock_);
    return *wall_clock_;
  }
  [[nodiscard]] const std::string& plant_name() const noexcept { return plant_name_; }
  [[nodiscard]] const plant::MujocoPlant* engine() const noexcept { return engine_; }

 private:
  void Listen(const ServedRobotSettings& settings) {
    server_ =
        std::make_unique<Server>(settings.server, *robot_, port_, changed_, clock_, settings.tell);
  }
  void ListenAnywhere(ServedRobotSettings& settings) {
    for (std::uint16_t port = kFirstPort; server_ == nullptr;
         port = static_cast<std::uint16_t>(port + 2)) {
      settings.server.arm_port = port;
      settings.server.hand_port = static_cast<std::uint16_t>(port + 1);
      try {
        Listen(settings);
      } catch (const EnvironmentError&) {
        if (port >= kLastPort) throw;
      }
    }
  }

  const MonotonicClock clock_;
  WakeEvent changed_;
  UdpPort port_;
  const std::string plant_name_;
  const plant::MujocoPlant* const engine_;  ///< the robot's plant; null for the ideal plant
  const JointLimits limits_;
  std::optional<robot::WallClockRobot> wall_clock_;
  std::optional<robot::AnswerPacedRobot> lockstep_;
  robot::ThreadedRobot* robot_ = nullptr;  ///< whichever of the two exists
  std::unique_ptr<Server> server_;
  std::jthread serving_;
};

ServedRobot::ServedRobot(const robot::RobotConfig& config, robot::MadePlant plant,
                         ServedRobotSettings settings)
    : impl_(std::make_unique<Impl>(config, std::move(plant), std::move(settings))) {}

ServedRobot::~ServedRobot() = default;

fci::Endpoint ServedRobot::arm() const {
  return impl_->server().arm();
}

std::optional<fci::Endpoint> ServedRobot::hand() const {
  return impl_->server().hand();
}

const std::string& ServedRobot::plant_name() const noexcept {
  return impl_->plant_name();
}

const plant::TruthProbe* ServedRobot::truth() const noexcept {
  return impl_->engine();
}

void ServedRobot::Begin() {
  impl_->Begin();
}

const std::vector<std::string>& ServedRobot::notices() const {
  return std::as_const(*impl_).robot().notices();
}

robot::ThreadedRobot& ServedRobot::robot() noexcept {
  return impl_->robot();
}

robot::AnswerPacedRobot* ServedRobot::lockstep() noexcept {
  return impl_->lockstep();
}

void ServedRobot::Place(const std::string& name, const Transform& X_WB) {
  impl_->Place(name, X_WB);
}

void ServedRobot::RequireFree(const JointVector& q) const {
  impl_->RequireFree(q);
}

void ServedRobot::PressUserStop(bool pressed) {
  impl_->PressUserStop(pressed);
}

void ServedRobot::Serve(const std::function<bool()>& ends) {
  impl_->Serve(ends);
}

void ServedRobot::Start() {
  impl_->Start();
}

void ServedRobot::StopServing() {
  impl_->StopServing();
}

void ServedRobot::End() {
  impl_->End();
}

std::string ServedRobot::DescribeWarnings() const {
  return impl_->engine() != nullptr ? impl_->engine()->DescribeWarnings() : "";
}

const rt::DurationHistogram& ServedRobot::lateness() const {
  return impl_->wall_clock().lateness();
}

std::uint64_t ServedRobot::overruns() const {
  return impl_->wall_clock().overruns();
}

}  // namespace twin::server
