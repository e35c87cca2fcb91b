#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>

#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/fci/sockets.h"
#include "twin/page/live_page.h"
#include "twin/page/operator_channel.h"
#include "twin/planning/collision_world.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"
#include "twin/teleop/device.h"

namespace twin::application {

/// Moves a served robot by the commands of the operator at its page: an ordinary client, by backend
/// fci at the address of the served robot, with the application teleoperation. It connects when an
/// operator takes control and disconnects when the operator returns control. While another client
/// is connected, the server refuses it as any second client.
///
/// A session that ended by a stop or an error begins anew at the operator's request, after
/// automatic error recovery; at another request the arm first moves home.
///
/// Threads: Offer() by one, before the page is open; the client is on a thread of its own.
class PageOperator {
 public:
  using Tell = std::function<void(Time, std::string_view kind, std::string_view text)>;
  /// Puts free bodies and other arms where they are now.
  using Arrange = std::function<void(planning::CollisionWorld&)>;

  /// Connected components; all must outlive this object.
  struct Parts {
    const run::Catalogue& catalogue;
    run::RunFiles files;
    page::OperatorChannel& channel;
    Arrange arrange;  ///< called on the client's thread
    double pace = 1;  ///< of a robot served in lockstep: its time over that of the wall clock
  };

  /// @param served  the robot's scenario. @param arm, hand  where they are served.
  PageOperator(Parts parts, const scenario::Scenario& served, const fci::Endpoint& arm,
               const std::optional<fci::Endpoint>& hand, Tell tell);

  /// Sets what the page asks of an operator's session. The page must end before this object.
  void Offer(page::PageSettings& settings);

 private:
  enum class Wish : std::uint8_t { kNone, kLead, kHome };

  /// An operator has taken control, or control has ended and the session's end will be pressed.
  void Operate(bool wanted);
  [[nodiscard]] bool Ask(Wish wish);
  void Run(const std::stop_token& stop);
  /// @returns the next session's purpose, and sets its phase.
  [[nodiscard]] Wish Begin();
  void End(Wish next);
  [[nodiscard]] bool is_wanted() const;
  /// Runs a session, from connecting to the end of the motion.
  void Session(std::unique_ptr<teleop::Device> device);
  void Home();

  const Parts parts_;
  const scenario::Scenario served_;
  const scenario::Scenario scenario_;
  const run::RealtimeConfig settings_;
  const Tell tell_;
  mutable std::mutex mutex_;  ///< guards the following three
  bool wanted_ = false;       ///< an operator has control
  Wish wish_ = Wish::kNone;
  page::LedSession phase_ = page::LedSession::kRests;
  volatile bool interrupted_ = false;  ///< read by the session; true: the program ends
  volatile bool ends_home_ = false;    ///< read by the way home; true: it ends
  std::jthread thread_;
};

}  // namespace twin::application
