#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "twin/fci/arm_session.h"
#include "twin/robot/threaded_robot.h"
#include "twin/server/request_handler.h"
#include "twin/server/server.h"
#include "twin/server/udp_port.h"

namespace twin::server {

/// Serves the arm's client: its session, the robot, and the UDP port for states.
///
/// Threads: one.
class ArmRequestHandler final : public RequestHandler, private fci::ArmService {
 public:
  /// All arguments must outlive the handler.
  ArmRequestHandler(robot::ThreadedRobot& robot, UdpPort& port, const ServerConfig& config,
                    const TellPeople& tell);

  /// The robot's mode or errors have changed. @throws RobotFault.
  void OnRobotChanged();

  [[nodiscard]] bool IsReady() override;
  void OnConnect(Connection& client) override;
  [[nodiscard]] std::optional<std::string> OnFrame(const fci::Frame& frame) override;
  [[nodiscard]] std::optional<std::string> Poll(Time now) override;
  [[nodiscard]] bool has_pending() const override;
  void OnDisconnect() override;
  [[nodiscard]] Duration poll_timeout() const override;

 private:
  [[nodiscard]] MoveStatus Move(const fci::Move& move) override;
  void StopMove() override;
  [[nodiscard]] SetterStatus Configure(const Setting& setting) override;
  [[nodiscard]] RecoveryStatus Recover() override;
  [[nodiscard]] SetterStatus CartesianLimitOf(std::int32_t id, fci::CartesianLimit& limit) override;
  [[nodiscard]] std::string_view RobotModel() override { return robot_model_; }
  [[nodiscard]] std::span<const std::byte> ModelLibrary(
      const fci::LoadModelLibrary& machine) override;
  [[nodiscard]] fci::ArmProgress Progress() override;

  void TellEnd(const robot::LastMotion& motion);
  /// Logs violations outside a motion: a collision, or an arm that does not come to rest.
  void TellFound(const onboard::Violations& found);
  void TellRefused(std::string_view request, std::string_view why);
  /// "not possible in the current mode ("Reflex")".
  [[nodiscard]] std::string NotPossible();
  void TellDropped();

  robot::ThreadedRobot& robot_;
  UdpPort& port_;
  const ServerConfig& config_;
  const std::string robot_model_;  ///< the URDF, with what says that this is a twin
  const TellPeople& tell_;

  std::optional<fci::ArmSession> session_;
  fci::Endpoint client_;
  bool connected_ = false;
  bool in_motion_ = false;   ///< a granted motion whose end was not logged yet
  bool stop_asked_ = false;  ///< by the session, or on its behalf
  std::uint64_t told_ = 0;   ///< cycle of the last logged errors
  DroppedDatagrams dropped_before_;
};

}  // namespace twin::server
