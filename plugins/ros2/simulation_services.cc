#include "plugins/ros2/simulation_services.h"

#include <algorithm>
#include <cmath>
#include <regex>

#include <Eigen/Geometry>

#include <fmt/format.h>

#include "plugins/ros2/conversions.h"
#include "twin/core/error.h"

namespace twin::ros2 {
namespace {

using server::ControlRequest;
using server::ControlVerb;

/// Looks between two messages on /tf: 33 Hz.
constexpr int kLooksPerTransforms = 30;
/// The same for feedback on steps: 10 Hz.
constexpr int kLooksPerFeedback = 100;
/// Of names from the network, in messages.
constexpr std::size_t kShownName = 64;

msg::Result Failed(std::uint8_t code, const std::string& why) {
  return {.result = code, .error_message = why};
}

}  // namespace

SimulationServices::SimulationServices(Node& node, Simulation simulation,
                                       const std::function<msg::Time()>& now)
    : node_(node),
      simulation_(std::move(simulation)),
      now_(now),
      tf_(node.Advertise<msg::TFMessage>("/tf", {.depth = 100})),
      action_(node, "simulate_steps",
              {.begin = [this](const msg::UUID& id,
                               const msg::SimulateSteps::Goal& goal) { Simulate(id, goal.steps); },
               .cancel =
                   [this](const msg::UUID&) {
                     is_canceled_ = true;
                     static_cast<void>(Do({.verb = ControlVerb::kPause}));
                   },
               .now = now}) {
  ServeState();
  ServeEntities();
}

msg::Result SimulationServices::Do(const ControlRequest& request) {
  try {
    simulation_.robot.Do(request);
    return Failed(msg::Result::kOk, "");
  } catch (const Error& error) {
    return Failed(
        simulation_.is_paused ? msg::Result::kOperationFailed : msg::Result::kFeatureUnsupported,
        error.what());
  }
}

msg::Result SimulationServices::SetState(std::uint8_t state) {
  using State = msg::SimulationState;
  switch (state) {
    case State::kPlaying: return Do({.verb = ControlVerb::kResume});
    case State::kPaused: return Do({.verb = ControlVerb::kPause});
    case State::kStopped: {
      msg::Result reset = Do({.verb = ControlVerb::kReset});
      if (reset.result != msg::Result::kOk) return reset;
      return Do({.verb = ControlVerb::kPause});
    }
    default:
      return Failed(msg::Result::kFeatureUnsupported,
                    "the robot is served until the program that serves it ends");
  }
}

void SimulationServices::Simulate(const msg::UUID& id, std::uint64_t steps) {
  is_canceled_ = false;
  BeginSteps({.all = steps,
              .end =
                  [this, id](const msg::Result& result) {
                    const bool is_well = result.result == msg::Result::kOk;
                    action_.Finish(id,
                                   is_canceled_ ? GoalState::kCanceled
                                   : is_well    ? GoalState::kSucceeded
                                                : GoalState::kAborted,
                                   {.result = result});
                  },
              .tell =
                  [this, id, steps](std::uint64_t left) {
                    action_.Feedback(id,
                                     {.completed_steps = steps - left, .remaining_steps = left});
                  }});
}

void SimulationServices::BeginSteps(Steps steps) {
  if (simulation_.is_paused && !simulation_.is_paused()) {
    return steps.end(Failed(msg::Result::kIncorrectState, "time runs; pause it first"));
  }
  if (steps.all < 1 || steps.all > ControlRequest::kMostCycles) {
    return steps.end(Failed(msg::Result::kOperationFailed,
                            fmt::format("steps is {}; a step is 1 ms, and 1 to {} may be asked for",
                                        steps.all, ControlRequest::kMostCycles)));
  }
  const std::lock_guard lock(mutex_);
  if (steps_) return steps.end(Failed(msg::Result::kIncorrectState, "other steps are under way"));
  const msg::Result begun = Do({.verb = ControlVerb::kStep, .cycles = steps.all});
  if (begun.result != msg::Result::kOk) return steps.end(begun);
  steps_ = std::move(steps);
}

void SimulationServices::ServeState() {
  node_.Serve<msg::GetSimulatorFeatures>(
      "get_simulator_features",
      [this](const msg::GetSimulatorFeatures::Request&, const auto& reply) {
        using Features = msg::SimulatorFeatures;
        msg::GetSimulatorFeatures::Response response;
        response.features.features = {Features::kEntityStateGetting, Features::kEntityStateSetting,
                                      Features::kSimulationStateGetting};
        if (simulation_.is_paused) {
          for (const auto feature :
               {Features::kSimulationReset, Features::kSimulationResetState,
                Features::kSimulationStateSetting, Features::kSimulationStatePause,
                Features::kStepSimulationSingle, Features::kStepSimulationMultiple,
                Features::kStepSimulationAction}) {
            response.features.features.push_back(feature);
          }
        }
        response.features.custom_info = "panda-twin: a step is a cycle of the robot, 1 ms";
        reply(response);
      });
  node_.Serve<msg::GetSimulationState>(
      "get_simulation_state", [this](const msg::GetSimulationState::Request&, const auto& reply) {
        const bool stands = simulation_.is_paused && simulation_.is_paused();
        reply(
            {.state = {.state = static_cast<std::uint8_t>(stands ? msg::SimulationState::kPaused
                                                                 : msg::SimulationState::kPlaying)},
             .result = Failed(msg::Result::kOk, "")});
      });
  node_.Serve<msg::SetSimulationState>(
      "set_simulation_state",
      [this](const msg::SetSimulationState::Request& request, const auto& reply) {
        reply({.result = SetState(request.state.state)});
      });
  node_.Serve<msg::StepSimulation>(
      "step_simulation", [this](const msg::StepSimulation::Request& request, const auto& reply) {
        BeginSteps({.all = request.steps,
                    .end = [reply](const msg::Result& result) { reply({.result = result}); },
                    .tell = {}});
      });
  node_.Serve<msg::ResetSimulation>(
      "reset_simulation", [this](const msg::ResetSimulation::Request&, const auto& reply) {
        reply({.result = Do({.verb = ControlVerb::kReset})});
      });
}

void SimulationServices::ServeEntities() {
  node_.Serve<msg::GetEntities>("get_entities", [this](const msg::GetEntities::Request& request,
                                                       const auto& reply) {
    msg::GetEntities::Response response;
    try {
      const std::regex wanted(request.filters.filter.empty() ? ".*" : request.filters.filter,
                              std::regex::extended);
      for (const auto& [name, X_WB] : BodiesNow()) {
        if (std::regex_match(name, wanted)) response.entities.push_back(name);
      }
      response.result = Failed(msg::Result::kOk, "");
    } catch (const std::regex_error&) {
      response.result = Failed(msg::Result::kOperationFailed, "filter is no regular expression");
    }
    reply(response);
  });
  node_.Serve<msg::GetEntityState>(
      "get_entity_state", [this](const msg::GetEntityState::Request& request, const auto& reply) {
        const Bodies bodies = BodiesNow();
        const auto body = std::ranges::find(bodies, request.entity, &Bodies::value_type::first);
        msg::GetEntityState::Response response;
        response.result =
            body == bodies.end()
                ? Failed(msg::Result::kNotFound,
                         "no free body is called " + request.entity.substr(0, kShownName))
                : Failed(msg::Result::kOk, "");
        if (body != bodies.end()) {
          response.state.header = {.stamp = now_(), .frame_id = "world"};
          response.state.pose = PoseOf(body->second);
        }
        reply(response);
      });
  node_.Serve<msg::SetEntityState>(
      "set_entity_state", [this](const msg::SetEntityState::Request& request, const auto& reply) {
        if (request.set_twist || request.set_acceleration || !request.set_pose) {
          return reply(
              {.result = Failed(msg::Result::kFeatureUnsupported,
                                "a pose alone can be set: set_pose; the body then rests")});
        }
        const std::string& frame = request.state.header.frame_id;
        if (!frame.empty() && frame != "world") {
          return reply(
              {.result = Failed(msg::SetEntityState::kInvalidPose,
                                "poses are those in the frame world; give that, or none")});
        }
        const msg::Pose& pose = request.state.pose;
        const Eigen::Quaterniond q(pose.orientation.w, pose.orientation.x, pose.orientation.y,
                                   pose.orientation.z);
        const double norm = q.norm();
        if (!(std::abs(norm - 1) < 1e-3)) {
          return reply({.result = Failed(msg::SetEntityState::kInvalidPose,
                                         "the orientation is no unit quaternion")});
        }
        const Eigen::Matrix3d R = q.normalized().toRotationMatrix();
        ControlRequest place;
        place.verb = ControlVerb::kPlace;
        place.name = request.entity;
        place.position = {pose.position.x, pose.position.y, pose.position.z};
        place.rpy = {std::atan2(R(2, 1), R(2, 2)), std::asin(std::clamp(-R(2, 0), -1.0, 1.0)),
                     std::atan2(R(1, 0), R(0, 0))};
        try {
          place = server::ParseControlRequest(server::ToLine(place));  // which judges it
        } catch (const InputError& error) {
          return reply({.result = Failed(msg::SetEntityState::kInvalidPose, error.what())});
        }
        reply({.result = Do(place)});
      });
}

SimulationServices::Bodies SimulationServices::BodiesNow() const {
  const std::lock_guard lock(mutex_);
  return bodies_;
}

void SimulationServices::PublishBodies() {
  Bodies bodies = simulation_.bodies ? simulation_.bodies() : Bodies();
  if (simulation_.puts_bodies_on_tf && tf_->has_readers() && !bodies.empty()) {
    msg::TFMessage message;
    for (const auto& [name, X_WB] : bodies) {
      message.transforms.push_back(FrameInWorld(name, X_WB, now_()));
    }
    tf_->Publish(message);
  }
  const std::lock_guard lock(mutex_);
  bodies_ = std::move(bodies);
}

void SimulationServices::Look() {
  if (++looks_ % kLooksPerTransforms == 0) PublishBodies();
  std::optional<Steps> over;
  {
    const std::lock_guard lock(mutex_);
    if (!steps_) return;
    if (simulation_.robot.IsBusy()) {
      if (steps_->tell && looks_ % kLooksPerFeedback == 0) {
        steps_->tell(simulation_.cycles_left());
      }
      return;
    }
    over = std::exchange(steps_, std::nullopt);
  }
  over->end(Failed(msg::Result::kOk, ""));
}

}  // namespace twin::ros2
