#include "twin/server/server.h"

#include <poll.h>

#include <algorithm>
#include <utility>

#include "server/arm_request_handler.h"
#include "server/hand_request_handler.h"
#include "twin/core/error.h"
#include "twin/server/single_client_acceptor.h"

namespace twin::server {
namespace {

SingleClientAcceptor::Settings SettingsOf(const ServerConfig& config, fci::HeadKind kind,
                                          const Clock& clock) {
  SingleClientAcceptor::Settings settings = SingleClientAcceptor::SettingsOf(config, kind);
  settings.tap = {config.capture, &clock};
  return settings;
}

}  // namespace

class Server::Impl {
 public:
  Impl(ServerConfig config, robot::ThreadedRobot& robot, UdpPort& port, WakeEvent& changed,
       const MonotonicClock& clock, TellPeople tell)
      : config_(std::move(config)),
        clock_(clock),
        tell_(std::move(tell)),
        changed_(changed),
        arm_desk_(robot, port, config_, tell_),
        arm_(SettingsOf(config_, fci::HeadKind::kArm, clock), arm_desk_, tell_) {
    if (!robot.has_hand()) return;
    config_.hand_port = config_.hand_port.value_or(fci::PortOf(robot.hand_device()));
    hand_desk_.emplace(robot, clock, config_.address, tell_, config_.capture);
    hand_.emplace(SettingsOf(config_, fci::HeadKind::kHand, clock), *hand_desk_, tell_);
  }

  [[nodiscard]] fci::Endpoint arm() const { return arm_.local(); }
  [[nodiscard]] std::optional<fci::Endpoint> hand() const {
    return hand_ ? std::optional(hand_->local()) : std::nullopt;
  }

  void Run(const std::function<bool()>& ends) {
    while (!ends()) {
      Wait();
      const Time now = clock_.Now();
      if (changed_.Clear()) Watch();
      arm_.Serve(now);
      if (hand_) hand_->Serve(now);
    }
    arm_.End();
    if (hand_) hand_->End();
  }

 private:
  void Wait() {
    waited_.clear();
    waited_.push_back({changed_.fd(), POLLIN, 0});
    Duration timeout = arm_.poll_timeout();
    arm_.AddTo(waited_);
    if (hand_) {
      hand_->AddTo(waited_);
      timeout = std::min(timeout, hand_->poll_timeout());
    }
    const auto ms = std::chrono::ceil<std::chrono::milliseconds>(timeout);
    // The result does not matter: each handler checks its own descriptors.
    static_cast<void>(poll(waited_.data(), waited_.size(), static_cast<int>(ms.count())));
  }

  /// Logs the end of a motion, even after its client has disconnected.
  void Watch() {
    try {
      arm_desk_.OnRobotChanged();
    } catch (const RobotFault& fault) {
      tell_(fault.what());
    }
  }

  ServerConfig config_;
  const MonotonicClock& clock_;
  const TellPeople tell_;
  WakeEvent& changed_;
  ArmRequestHandler arm_desk_;
  SingleClientAcceptor arm_;
  std::optional<HandRequestHandler> hand_desk_;
  std::optional<SingleClientAcceptor> hand_;
  std::vector<pollfd> waited_;
};

Server::Server(ServerConfig config, robot::ThreadedRobot& robot, UdpPort& port, WakeEvent& changed,
               const MonotonicClock& clock, TellPeople tell)
    : impl_(std::make_unique<Impl>(std::move(config), robot, port, changed, clock,
                                   std::move(tell))) {}

Server::~Server() = default;

fci::Endpoint Server::arm() const {
  return impl_->arm();
}

std::optional<fci::Endpoint> Server::hand() const {
  return impl_->hand();
}

void Server::Run(const std::function<bool()>& ends) {
  impl_->Run(ends);
}

}  // namespace twin::server
