#include "cli/ros_flags.h"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include <fmt/format.h>

#include "plugins/ros2/bridge.h"
#include "plugins/ros2/state_tap.h"
#include "twin/application/own_client.h"
#include "twin/core/error.h"
#include "twin/core/integer.h"
#include "twin/page/live_feed.h"
#include "twin/plant/observers.h"
#include "twin/render/scene_painter.h"
#include "twin/run/film.h"
#include "twin/run/run_records.h"
#include "twin/server/controlled_robot.h"
#include "twin/server/served_robot.h"

namespace twin::cli {
namespace {

/// ROS_DOMAIN_ID; 0 when it is not set. @throws InputError for what is no number.
int DomainOfEnvironment() {
  const char* text = std::getenv("ROS_DOMAIN_ID");
  if (text == nullptr || *text == '\0') return 0;
  const auto domain = ParseInteger<int>(text);
  if (!domain) throw InputError(fmt::format("ROS_DOMAIN_ID is \"{}\", no number", text));
  return *domain;
}

ros2::BridgeOptions OptionsOf(const RosFlags& flags, const RosBridge::Tell& tell) {
  ros2::BridgeOptions options;
  options.node.name_space = flags.name_space;
  options.node.dds.domain = DomainOfEnvironment();
  options.node.dds.discovery =
      flags.discovery == "subnet" ? ros2::Discovery::kSubnet : ros2::Discovery::kThisMachine;
  options.node.mapping =
      flags.header ? ros2::ServiceMapping::kHeader : ros2::ServiceMapping::kByVendor;
  options.node.is_humble = flags.distro == "humble";
  options.node.tell = tell;
  options.rate_hz = flags.rate_hz;
  options.lockstep_hz = flags.lockstep_hz;
  options.has_clock = flags.has_scene;
  options.arms = flags.arms;
  return options;
}

class FastRosBridge final : public RosBridge {
 public:
  FastRosBridge(const RosFlags& flags, record::RecordSink* next)
      : flags_(flags), feed_(next), tap_(&feed_) {}

  [[nodiscard]] record::RecordSink* sink() noexcept override { return &tap_; }

  void Watch(application::ServedSession& session) override {
    truth_ = session.robot().truth();
    if (truth_ != nullptr) truth_ = &truth_->whole();
    if (truth_ != nullptr && !run::RunRecords::CanFilm(*truth_)) truth_ = nullptr;
    if (truth_ != nullptr) feed_.Show(*truth_);
  }

  [[nodiscard]] std::string OpenServed(application::ServedSession& session,
                                       const run::Catalogue& catalogue, const Tell& tell) override {
    server::ServedRobot& robot = session.robot();
    const auto hand = robot.hand();
    ros2::BridgedRobot bridged{
        .catalogue = catalogue,
        .files = session.files(),
        .client = application::OwnClientOf(session.scenario()),
        .settings = application::OwnClientAt(robot.arm(), hand),
        .data = session.robot_data(),
        .follows_wall_clock = !session.drive().is_lockstep() || session.drive().pace == 1.0};
    if (hand) bridged.hand = [&robot] { return robot.robot().hand_state(); };
    bridged.simulation.emplace(ros2::Simulation{
        .robot = server::ControlledRobot(robot, session.reset() != application::ResetPolicy::kNever,
                                         !flags_.is_among_others),
        .bodies = [this] { return Bodies(); },
        .puts_bodies_on_tf = flags_.has_scene});
    robot::AnswerPacedRobot* const lockstep = robot.lockstep();
    if (lockstep != nullptr && !flags_.is_among_others) {
      bridged.simulation->is_paused = [lockstep] { return lockstep->cycles_left().has_value(); };
      bridged.simulation->cycles_left = [lockstep] { return lockstep->cycles_left().value_or(0); };
    }
    if (truth_ != nullptr) bridged.cameras = MakeCameras(session.scenario());
    bridge_.emplace(OptionsOf(flags_, tell), std::move(bridged), tap_);
    return bridge_->Introduction();
  }

  [[nodiscard]] std::string OpenRemote(const scenario::Scenario& client,
                                       const run::RealtimeConfig& settings,
                                       const run::RunFiles& files, const run::Catalogue& catalogue,
                                       const Tell& tell) override {
    ros2::BridgedRobot bridged{
        .catalogue = catalogue,
        .files = files,
        .client = client,
        .settings = settings,
        .data = scenario::LoadRobotData(files.models, client.robot.model, client.robot.hand),
        .keeps_connection = true};
    bridge_.emplace(OptionsOf(flags_, tell), std::move(bridged), tap_);
    return bridge_->Introduction();
  }

  void Close() override { bridge_.reset(); }

 private:
  std::vector<std::pair<std::string, Transform>> Bodies() {
    static_cast<void>(feed_.places().Refresh());
    if (truth_ == nullptr || !feed_.places().has_value()) return {};
    return plant::FreeBodies(truth_->model(), feed_.places().value().Positions());
  }

  ros2::Cameras MakeCameras(const scenario::Scenario& scenario) {
    render::View hand;
    hand.kind = render::ViewKind::kGripper;
    hand.name = truth_->prefix();
    views_ = {run::FilmOf(scenario.render).view, hand};
    painters_.resize(views_.size());
    return {.names = {"overview", "hand"},
            .frame_prefix = truth_->prefix(),
            .paint = [this](std::size_t camera, bool with_depth) -> std::optional<ros2::Picture> {
              static_cast<void>(feed_.scene().Refresh());
              if (!feed_.scene().has_value()) return std::nullopt;
              const record::SceneRecord& scene = feed_.scene().value();
              auto& painter = painters_[camera];
              if (!painter) {
                render::FilmSettings settings;
                settings.view = views_[camera];
                settings.overlays.text = false;
                painter = std::make_unique<render::ScenePainter>(truth_->model(), scene, settings);
              }
              painter->Show(scene);
              return ros2::Picture{.image = painter->Paint(),
                                   .depth = with_depth ? painter->Depth() : render::DepthImage(),
                                   .camera = painter->Camera()};
            }};
  }

  const RosFlags flags_;
  std::vector<render::View> views_;
  std::vector<std::unique_ptr<render::ScenePainter>> painters_;  ///< of the cameras' thread
  const plant::TruthProbe* truth_ = nullptr;                     ///< whose scenes the feed has
  page::LiveFeed feed_;
  ros2::StateTap tap_;
  std::optional<ros2::Bridge> bridge_;
};

}  // namespace

void AddRos(CLI::App& app, RosFlags& flags) {
  app.add_flag("--ros", flags.wanted,
               "Put the robot into the ROS 2 graph, without ROS: topics, services and actions of "
               "domain ROS_DOMAIN_ID");
  AddRosNames(app, flags);
  Add(app, "--ros-lockstep HZ", flags.lockstep_hz,
      "With drive lockstep: robot_joint_states come at this rate of robot time, which stands until "
      "robot_joint_commands has answered each; in [1, 1000]");
}

void AddRosNames(CLI::App& app, RosFlags& flags) {
  Add(app, "--ros-namespace NS", flags.name_space, "Namespace of its names, such as /left")
      ->capture_default_str();
  Add(app, "--ros-discovery", flags.discovery,
      "Whose nodes see it and can move it: those of this machine (localhost) or of the network "
      "(subnet)")
      ->check(CLI::IsMember({"localhost", "subnet"}))
      ->capture_default_str();
  Add(app, "--ros-distro", flags.distro,
      "Whose nodes find it by name (ros2 node list): Humble's (humble) or those of Iron and later "
      "(jazzy, kilted); topics, services and actions are the same")
      ->check(CLI::IsMember({"humble", "jazzy", "kilted"}))
      ->capture_default_str();
  Add(app, "--ros-rate HZ", flags.rate_hz, "Rate of joint_states and /clock, in [1, 1000]")
      ->capture_default_str();
  app.add_flag("--ros-arm", flags.arms,
               "Follow robot_joint_commands (ros2_control) from the start; else the service ~/arm "
               "permits it");
  app.add_flag("--ros-service-header", flags.header,
               "Answer services by a header in the payload, for clients that behave as "
               "rmw_cyclonedds on another DDS");
}

void RequireRosFlags(const RosFlags& flags) {
  RequireInRange("--ros-rate", flags.rate_hz, 1, 1000);
  RequireInRange("--ros-lockstep", flags.lockstep_hz.value_or(1), 1, 1000);
  const RosFlags usual;
  RefuseIf(!flags.wanted &&
               (flags.name_space != usual.name_space || flags.discovery != usual.discovery ||
                flags.distro != usual.distro || flags.rate_hz != usual.rate_hz ||
                flags.lockstep_hz || flags.arms || flags.header),
           "flags --ros-... belong to --ros: give it too");
}

RosFlags RosOf(const RosFlags& flags, const std::string& robot, bool has_scene) {
  RosFlags own = flags;
  own.is_among_others = true;
  own.has_scene = has_scene;
  if (!own.name_space.ends_with('/')) own.name_space += '/';
  own.name_space += robot;
  std::ranges::replace(own.name_space, '-', '_');  // which ROS does not know
  return own;
}

std::unique_ptr<RosBridge> MakeRosBridge(const RosFlags& flags, record::RecordSink* next) {
  return std::make_unique<FastRosBridge>(flags, next);
}

}  // namespace twin::cli
