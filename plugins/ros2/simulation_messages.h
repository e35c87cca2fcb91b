#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "plugins/ros2/messages.h"

// Messages, services and actions of simulation_interfaces, by which ROS 2 steers any simulator, as
// messages.h and action_messages.h have theirs. Layouts of 2.1.0. Quantities are SI and rad; a test
// compares bytes and hashes with those of rosbags.
namespace twin::ros2 {
namespace msg {

struct Result {
  static constexpr const char* kName = "simulation_interfaces/msg/Result";
  enum Code : std::uint8_t {
    kFeatureUnsupported = 0,
    kOk = 1,
    kNotFound = 2,
    kIncorrectState = 3,
    kOperationFailed = 4,
  };
  std::uint8_t result = 0;  ///< Code, or one above 100 of the service
  std::string error_message;
  static void Visit(auto& m, auto&& v) {
    v("result", m.result);
    v("error_message", m.error_message);
  }
};

struct SimulationState {
  static constexpr const char* kName = "simulation_interfaces/msg/SimulationState";
  enum State : std::uint8_t {
    kStopped = 0,
    kPlaying = 1,
    kPaused = 2,
    kQuitting = 3,
    kNoWorld = 4,
    kLoadingWorld = 5,
  };
  std::uint8_t state = 0;  ///< State
  static void Visit(auto& m, auto&& v) { v("state", m.state); }
};

struct SimulatorFeatures {
  static constexpr const char* kName = "simulation_interfaces/msg/SimulatorFeatures";
  enum Feature : std::uint16_t {
    kSpawning = 0,
    kDeleting = 1,
    kNamedPoses = 2,
    kPoseBounds = 3,
    kEntityTags = 4,
    kEntityBounds = 5,
    kEntityBoundsBox = 6,
    kEntityBoundsConvex = 7,
    kEntityCategories = 8,
    kSpawningResourceString = 9,
    kEntityStateGetting = 10,
    kEntityStateSetting = 11,
    kEntityInfoGetting = 12,
    kEntityInfoSetting = 13,
    kSpawnables = 14,
    kSimulationReset = 20,
    kSimulationResetTime = 21,
    kSimulationResetState = 22,
    kSimulationResetSpawned = 23,
    kSimulationStateGetting = 24,
    kSimulationStateSetting = 25,
    kSimulationStatePause = 26,
    kStepSimulationSingle = 31,
    kStepSimulationMultiple = 32,
    kStepSimulationAction = 33,
    kWorldLoading = 40,
    kWorldResourceString = 41,
    kWorldTags = 42,
    kWorldUnloading = 43,
    kWorldInfoGetting = 44,
    kAvailableWorlds = 45,
  };
  std::vector<std::uint16_t> features;     ///< Feature
  std::vector<std::string> spawn_formats;  ///< "urdf", "mjcf", ...
  std::string custom_info;
  static void Visit(auto& m, auto&& v) {
    v("features", m.features);
    v("spawn_formats", m.spawn_formats);
    v("custom_info", m.custom_info);
  }
};

struct Bounds {
  static constexpr const char* kName = "simulation_interfaces/msg/Bounds";
  enum Type : std::uint8_t {
    kEmpty = 0,
    kBox = 1,
    kConvexHull = 2,
    kSphere = 3,
  };
  std::uint8_t type = 0;        ///< Type
  std::vector<Vector3> points;  ///< m; of a sphere its centre, and its radius as x
  static void Visit(auto& m, auto&& v) {
    v("type", m.type);
    v("points", m.points);
  }
};

struct EntityCategory {
  static constexpr const char* kName = "simulation_interfaces/msg/EntityCategory";
  enum Category : std::uint8_t {
    kObject = 0,
    kRobot = 1,
    kHuman = 2,
    kDynamicObject = 4,
    kStaticObject = 5,
  };
  std::uint8_t category = 0;  ///< Category
  static void Visit(auto& m, auto&& v) { v("category", m.category); }
};

struct TagsFilter {
  static constexpr const char* kName = "simulation_interfaces/msg/TagsFilter";
  enum Mode : std::uint8_t {
    kAny = 0,
    kAll = 1,
  };
  std::vector<std::string> tags;
  std::uint8_t filter_mode = 0;  ///< Mode
  static void Visit(auto& m, auto&& v) {
    v("tags", m.tags);
    v("filter_mode", m.filter_mode);
  }
};

struct EntityFilters {
  static constexpr const char* kName = "simulation_interfaces/msg/EntityFilters";
  std::string filter;  ///< POSIX extended regular expression of names; empty: all
  std::vector<EntityCategory> categories;
  TagsFilter tags;
  Bounds bounds;
  static void Visit(auto& m, auto&& v) {
    v("filter", m.filter);
    v("categories", m.categories);
    v("tags", m.tags);
    v("bounds", m.bounds);
  }
};

struct EntityState {
  static constexpr const char* kName = "simulation_interfaces/msg/EntityState";
  Header header;  ///< no frame: the world's
  Pose pose;
  Twist twist;
  Accel acceleration;
  static void Visit(auto& m, auto&& v) {
    v("header", m.header);
    v("pose", m.pose);
    v("twist", m.twist);
    v("acceleration", m.acceleration);
  }
};

struct GetSimulatorFeatures {
  static constexpr const char* kName = "simulation_interfaces/srv/GetSimulatorFeatures";
  struct Request : detail::Nothing {
    static constexpr const char* kName = "simulation_interfaces/srv/GetSimulatorFeatures_Request";
  };
  struct Response {
    static constexpr const char* kName = "simulation_interfaces/srv/GetSimulatorFeatures_Response";
    SimulatorFeatures features;
    static void Visit(auto& m, auto&& v) { v("features", m.features); }
  };
};

struct StepSimulation {
  static constexpr const char* kName = "simulation_interfaces/srv/StepSimulation";
  struct Request {
    static constexpr const char* kName = "simulation_interfaces/srv/StepSimulation_Request";
    std::uint64_t steps = 1;
    static void Visit(auto& m, auto&& v) { v("steps", m.steps); }
  };
  struct Response {
    static constexpr const char* kName = "simulation_interfaces/srv/StepSimulation_Response";
    Result result;
    static void Visit(auto& m, auto&& v) { v("result", m.result); }
  };
};

struct ResetSimulation {
  static constexpr const char* kName = "simulation_interfaces/srv/ResetSimulation";
  /// Bits.
  enum Scope : std::uint8_t {
    kDefault = 0,
    kTime = 1,
    kState = 2,
    kSpawned = 4,
    kAll = 255,
  };
  struct Request {
    static constexpr const char* kName = "simulation_interfaces/srv/ResetSimulation_Request";
    std::uint8_t scope = 0;  ///< Scope
    static void Visit(auto& m, auto&& v) { v("scope", m.scope); }
  };
  struct Response {
    static constexpr const char* kName = "simulation_interfaces/srv/ResetSimulation_Response";
    Result result;
    static void Visit(auto& m, auto&& v) { v("result", m.result); }
  };
};

struct SetSimulationState {
  static constexpr const char* kName = "simulation_interfaces/srv/SetSimulationState";
  /// Of result.result, beside Result::Code.
  enum Code : std::uint8_t {
    kAlreadyInTargetState = 101,
    kStateTransitionError = 102,
    kIncorrectTransition = 103,
  };
  struct Request {
    static constexpr const char* kName = "simulation_interfaces/srv/SetSimulationState_Request";
    SimulationState state;
    static void Visit(auto& m, auto&& v) { v("state", m.state); }
  };
  struct Response {
    static constexpr const char* kName = "simulation_interfaces/srv/SetSimulationState_Response";
    Result result;
    static void Visit(auto& m, auto&& v) { v("result", m.result); }
  };
};

struct GetSimulationState {
  static constexpr const char* kName = "simulation_interfaces/srv/GetSimulationState";
  struct Request : detail::Nothing {
    static constexpr const char* kName = "simulation_interfaces/srv/GetSimulationState_Request";
  };
  struct Response {
    static constexpr const char* kName = "simulation_interfaces/srv/GetSimulationState_Response";
    SimulationState state;
    Result result;
    static void Visit(auto& m, auto&& v) {
      v("state", m.state);
      v("result", m.result);
    }
  };
};

struct GetEntities {
  static constexpr const char* kName = "simulation_interfaces/srv/GetEntities";
  struct Request {
    static constexpr const char* kName = "simulation_interfaces/srv/GetEntities_Request";
    EntityFilters filters;
    static void Visit(auto& m, auto&& v) { v("filters", m.filters); }
  };
  struct Response {
    static constexpr const char* kName = "simulation_interfaces/srv/GetEntities_Response";
    Result result;
    std::vector<std::string> entities;
    static void Visit(auto& m, auto&& v) {
      v("result", m.result);
      v("entities", m.entities);
    }
  };
};

struct GetEntityState {
  static constexpr const char* kName = "simulation_interfaces/srv/GetEntityState";
  struct Request {
    static constexpr const char* kName = "simulation_interfaces/srv/GetEntityState_Request";
    std::string entity;
    static void Visit(auto& m, auto&& v) { v("entity", m.entity); }
  };
  struct Response {
    static constexpr const char* kName = "simulation_interfaces/srv/GetEntityState_Response";
    Result result;
    EntityState state;
    static void Visit(auto& m, auto&& v) {
      v("result", m.result);
      v("state", m.state);
    }
  };
};

struct SetEntityState {
  static constexpr const char* kName = "simulation_interfaces/srv/SetEntityState";
  /// Of result.result, beside Result::Code.
  enum Code : std::uint8_t {
    kInvalidPose = 101,
  };
  struct Request {
    static constexpr const char* kName = "simulation_interfaces/srv/SetEntityState_Request";
    std::string entity;
    EntityState state;
    bool set_pose = false;  ///< which of the state's to set
    bool set_twist = false;
    bool set_acceleration = false;
    static void Visit(auto& m, auto&& v) {
      v("entity", m.entity);
      v("state", m.state);
      v("set_pose", m.set_pose);
      v("set_twist", m.set_twist);
      v("set_acceleration", m.set_acceleration);
    }
  };
  struct Response {
    static constexpr const char* kName = "simulation_interfaces/srv/SetEntityState_Response";
    Result result;
    static void Visit(auto& m, auto&& v) { v("result", m.result); }
  };
};

struct SimulateSteps {
  static constexpr const char* kName = "simulation_interfaces/action/SimulateSteps";
  struct Goal {
    static constexpr const char* kName = "simulation_interfaces/action/SimulateSteps_Goal";
    std::uint64_t steps = 0;
    static void Visit(auto& m, auto&& v) { v("steps", m.steps); }
  };
  struct Result {
    static constexpr const char* kName = "simulation_interfaces/action/SimulateSteps_Result";
    msg::Result result;
    static void Visit(auto& m, auto&& v) { v("result", m.result); }
  };
  struct Feedback {
    static constexpr const char* kName = "simulation_interfaces/action/SimulateSteps_Feedback";
    std::uint64_t completed_steps = 0;
    std::uint64_t remaining_steps = 0;
    static void Visit(auto& m, auto&& v) {
      v("completed_steps", m.completed_steps);
      v("remaining_steps", m.remaining_steps);
    }
  };
};

}  // namespace msg

/// Calls visitor.operator()<M>() for each message above, and for those of each service and action.
void ForEachSimulationMessage(auto&& visitor) {
  visitor.template operator()<msg::Result>();
  visitor.template operator()<msg::SimulationState>();
  visitor.template operator()<msg::SimulatorFeatures>();
  visitor.template operator()<msg::Bounds>();
  visitor.template operator()<msg::EntityCategory>();
  visitor.template operator()<msg::TagsFilter>();
  visitor.template operator()<msg::EntityFilters>();
  visitor.template operator()<msg::EntityState>();
  visitor.template operator()<msg::GetSimulatorFeatures::Request>();
  visitor.template operator()<msg::GetSimulatorFeatures::Response>();
  visitor.template operator()<msg::StepSimulation::Request>();
  visitor.template operator()<msg::StepSimulation::Response>();
  visitor.template operator()<msg::ResetSimulation::Request>();
  visitor.template operator()<msg::ResetSimulation::Response>();
  visitor.template operator()<msg::SetSimulationState::Request>();
  visitor.template operator()<msg::SetSimulationState::Response>();
  visitor.template operator()<msg::GetSimulationState::Request>();
  visitor.template operator()<msg::GetSimulationState::Response>();
  visitor.template operator()<msg::GetEntities::Request>();
  visitor.template operator()<msg::GetEntities::Response>();
  visitor.template operator()<msg::GetEntityState::Request>();
  visitor.template operator()<msg::GetEntityState::Response>();
  visitor.template operator()<msg::SetEntityState::Request>();
  visitor.template operator()<msg::SetEntityState::Response>();
  visitor.template operator()<msg::SimulateSteps::Goal>();
  visitor.template operator()<msg::SimulateSteps::Result>();
  visitor.template operator()<msg::SimulateSteps::Feedback>();
}

}  // namespace twin::ros2
