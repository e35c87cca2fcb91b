#include "twin/application/own_client.h"

#include <chrono>

namespace twin::application {

scenario::Scenario OwnClientOf(const scenario::Scenario& served) {
  scenario::Scenario client = served;
  client.backend = scenario::kRemoteBackend;
  client.robot.clock_drift_ppm = 0;
  client.hand.clear();
  if (!client.robot.q_start && !client.motion.waypoints.empty()) {
    client.robot.q_start = client.motion.waypoints.front().q;
  }
  client.motion = {};
  client.base.reset();     // the interface has no mobile base
  client.controller = {};  // the client has its own
  client.tick.period_tolerance = {};
  return client;
}

run::RealtimeConfig OwnClientAt(const fci::Endpoint& arm,
                                const std::optional<fci::Endpoint>& hand) {
  run::RealtimeConfig settings;
  // The address at which this server listens; at another, another robot may use the same port.
  settings.remote.host = arm.address == 0 ? "127.0.0.1" : fci::AddressText(arm.address);
  settings.remote.arm_port = arm.port;
  if (hand) settings.remote.hand_port = hand->port;
  settings.checks_start = false;
  // Its time may be made to stand. This server's end shows by the connection.
  settings.remote.silence = std::chrono::hours(24);
  return settings;
}

}  // namespace twin::application
