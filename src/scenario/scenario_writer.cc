#include <iterator>

#include <fmt/format.h>

#include "scenario/names.h"
#include "scenario/quantity.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {
namespace {

using Text = fmt::memory_buffer;

template <typename... Arguments>
void Put(Text& out, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  fmt::format_to(std::back_inserter(out), format, std::forward<Arguments>(arguments)...);
}

/// A YAML double-quoted scalar.
std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (c == '\n') {
      quoted += "\\n";
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += fmt::format("\\x{:02x}", byte);
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

std::string List(const JointVector& values) {
  std::string list = "[";
  for (std::size_t i = 0; i < kJoints; ++i) {
    list += (i == 0 ? "" : ", ") + FormatNumber(values[i]);
  }
  return list + "]";
}

std::string DelayText(const Delay& delay) {
  if (delay.kind == Delay::Kind::kConstant) return FormatDuration(delay.constant);
  return fmt::format("{{log_normal: {{median: {}, sigma: {}, offset: {}}}}}",
                     FormatDuration(delay.median), FormatNumber(delay.sigma),
                     FormatDuration(delay.offset));
}

void PutRobotAndPlant(Text& out, const Scenario& s) {
  Put(out, "robot:\n  model: {}\n  hand: {}\n", Quoted(s.robot.model),
      NameOf(kHandNames, s.robot.hand));
  if (s.robot.q_start) Put(out, "  q_start: {{unit: rad, values: {}}}\n", List(*s.robot.q_start));
  Put(out, "plant:\n  kind: {}\n  friction: {}\n  armature: {}\n",
      NameOf(kPlantNames, s.plant.kind), NameOf(kFrictionNames, s.plant.friction),
      s.plant.armature);
  Put(out, "  noise: {{q: {} rad, dq: {} rad/s, tau_J: {} Nm}}\n", FormatNumber(s.plant.noise_q),
      FormatNumber(s.plant.noise_dq), FormatNumber(s.plant.noise_tau_J));
}

void PutLinkAndOnboard(Text& out, const Scenario& s) {
  Put(out, "link:\n  state_delay: {}\n  command_delay: {}\n", DelayText(s.link.state_delay),
      DelayText(s.link.command_delay));
  Put(out, "  state_loss: {} %\n  command_loss: {} %\n  d_INT: {}\n",
      FormatNumber(s.link.state_loss_percent), FormatNumber(s.link.command_loss_percent),
      FormatDuration(s.link.d_INT));
  Put(out, "int:\n  K_theta: {{unit: Nm/rad, values: {}}}\n", List(s.onboard.K_theta));
  Put(out, "  damping_ratio: {}\n  abort_after_lost: {}\n", FormatNumber(s.onboard.damping_ratio),
      s.onboard.abort_after_lost);
}

void PutTickAndController(Text& out, const Scenario& s) {
  Put(out,
      "tick:\n  generator: {}\n  lambda: {}\n  rate_matching: {}\n  finish_tolerance: {} rad\n  "
      "cost: {}\n",
      NameOf(kGeneratorNames, s.tick.generator), FormatNumber(s.tick.lambda), s.tick.rate_matching,
      FormatNumber(s.tick.finish_tolerance), DelayText(s.tick.cost));
  Put(out, "controller:\n  type: {}\n  rate: {} Hz\n  clock_drift: {} ppm\n  phase: {}\n",
      Quoted(s.controller.type), FormatNumber(s.controller.rate_hz),
      FormatNumber(s.controller.clock_drift_ppm), FormatDuration(s.controller.phase));
  Put(out, "  wake_delay: {}\n  cost: {}\n  feed_forward: {}\n", DelayText(s.controller.wake_delay),
      DelayText(s.controller.cost), NameOf(kFeedForwardNames, s.controller.feed_forward));
}

void PutMotion(Text& out, const MotionSection& motion) {
  Put(out, "motion:\n  interface: {}\n  trajectory:\n    unit: rad\n",
      NameOf(kInterfaceNames, motion.interface));
  if (motion.timing.duration) {
    Put(out, "    duration: {}\n", FormatDuration(*motion.timing.duration));
  }
  Put(out, "    velocity_scale: {}\n    acceleration_scale: {}\n    jerk_scale: {}\n",
      FormatNumber(motion.timing.velocity_scale), FormatNumber(motion.timing.acceleration_scale),
      FormatNumber(motion.timing.jerk_scale));
  Put(out, "    waypoints:\n");
  for (const reference::Waypoint& point : motion.waypoints) {
    Put(out, "      - {{q: {}", List(point.q));
    if (point.at) Put(out, ", at: {}", FormatDuration(*point.at));
    if (point.stop) Put(out, ", stop: true");
    Put(out, "}}\n");
  }
}

void PutRender(Text& out, const RenderSection& render) {
  Put(out, "render:\n  enabled: {}\n  width: {}\n  height: {}\n  fps: {} Hz\n", render.enabled,
      render.width, render.height, render.fps);
  if (!render.camera.empty()) {
    Put(out, "  camera: {}\n", Quoted(render.camera));
    return;
  }
  Put(out, "  camera:\n    azimuth: {} rad\n    elevation: {} rad\n    distance: {} m\n",
      FormatNumber(render.azimuth), FormatNumber(render.elevation), FormatNumber(render.distance));
  Put(out, "    lookat: [{} m, {} m, {} m]\n", FormatNumber(render.lookat[0]),
      FormatNumber(render.lookat[1]), FormatNumber(render.lookat[2]));
}

}  // namespace

std::string ToYaml(const Scenario& scenario) {
  Text out;
  Put(out, "name: {}\ndescription: {}\nseed: {}\n", Quoted(scenario.name),
      Quoted(scenario.description), scenario.seed);
  Put(out, "backend: {}\ndrive: lockstep\nscene: {}\n", Quoted(scenario.backend),
      Quoted(scenario.scene.string()));
  PutRobotAndPlant(out, scenario);
  PutLinkAndOnboard(out, scenario);
  PutTickAndController(out, scenario);
  PutMotion(out, scenario.motion);
  PutRender(out, scenario.render);
  Put(out, "record: {}\n", scenario.record);
  return fmt::to_string(out);
}

}  // namespace twin::scenario
