#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string_view>
#include <thread>

#include "twin/core/time.h"
#include "twin/fci/sockets.h"
#include "twin/page/operator_channel.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"
#include "twin/teleop/device.h"

namespace twin::application {

/// Moves a served robot by the commands of the operator at its page: an ordinary client, by backend
/// fci at the address of the served robot, with the application teleoperation. It connects when an
/// operator takes control and disconnects when the operator returns control. While another client
/// is connected, the server refuses it as any second client.
///
/// Threads: Operate() from any; the client is on a thread of its own.
class PageOperator {
 public:
  using Tell = std::function<void(Time, std::string_view kind, std::string_view text)>;

  /// Connected components; all must outlive this object.
  struct Parts {
    const run::Catalogue& catalogue;
    run::RunFiles files;
    page::OperatorChannel& channel;
  };

  /// @param served  the robot's scenario. @param arm, hand  where they are served.
  PageOperator(const Parts& parts, const scenario::Scenario& served, const fci::Endpoint& arm,
               const std::optional<fci::Endpoint>& hand, Tell tell);

  /// @param wanted  true: an operator has taken control; false: control has ended, and the
  /// session's end will be pressed.
  void Operate(bool wanted) noexcept {
    if (wanted) takes_.fetch_add(1, std::memory_order_relaxed);
    wanted_.store(wanted, std::memory_order_release);
  }

 private:
  void Run(const std::stop_token& stop);
  /// Runs a session, from connecting to the end of the motion.
  void Session(std::unique_ptr<teleop::Device> device);

  const Parts parts_;
  const scenario::Scenario scenario_;
  const run::RealtimeConfig settings_;
  const Tell tell_;
  std::atomic<bool> wanted_{false};  ///< release, acquire: takes_ is counted before
  std::atomic<std::uint64_t> takes_{0};
  volatile bool interrupted_ = false;  ///< read by the session; true: the program ends
  std::jthread thread_;
};

}  // namespace twin::application
