#include "experiment/tempos.h"

#include <chrono>
#include <cmath>
#include <cstdint>

#include "experiment/runs.h"

namespace twin::experiment {

void SetTempo(const Setting& setting, const Tempo& tempo, scenario::Scenario& scenario) {
  if (tempo.stretch == 0) return;
  scenario.motion = scenario::Load(setting.files.models / "scenarios" / "brisk.yaml").motion;
  scenario.motion.interface = control::CommandInterface::kJointPosition;
  scenario.motion.timing.duration.reset();
  for (reference::Waypoint& waypoint : scenario.motion.waypoints) {
    if (waypoint.at) waypoint.at = FromSeconds(ToSeconds(*waypoint.at) * tempo.stretch);
  }
}

scenario::Loss LossOf(const Setting& setting, const Bursts& bursts, double seconds, int run) {
  scenario::ScriptedLoss script;
  std::uint32_t draw = 0;
  std::int64_t at = 20;  // ms: the motion has begun
  for (;;) {
    const double wait = -std::log1p(-ChoiceOfRun(setting, run, ++draw)) / bursts.per_second;
    at += std::llround(1e3 * wait) + 1;
    if (static_cast<double>(at + bursts.length) > 1e3 * seconds) break;
    script.bursts.push_back(
        {std::chrono::milliseconds(at), static_cast<std::uint64_t>(bursts.length)});
    at += bursts.length;
  }
  return {script};
}

}  // namespace twin::experiment
