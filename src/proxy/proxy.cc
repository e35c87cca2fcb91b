#include "twin/proxy/proxy.h"

#include <poll.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "proxy/relay_request_handler.h"
#include "twin/core/random.h"
#include "twin/server/single_client_acceptor.h"

namespace twin::proxy {
namespace {

const ProxyConfig& Validated(const ProxyConfig& config) {
  config.Validate();
  return config;
}

/// Makes the hand's draws independent of the arm's.
std::uint64_t HandSeed(std::uint64_t seed) noexcept {
  const auto bits = Random(seed, RandomStream::kHandSeed).Bits(0);
  return std::uint64_t{bits[1]} << 32 | bits[0];
}

RelayRequestHandler::Settings HandlerSettings(const ProxyConfig& config, fci::HeadKind kind) {
  const bool is_arm = kind == fci::HeadKind::kArm;
  return {.name = is_arm ? "arm" : "hand",
          .kind = kind,
          .robot = is_arm ? config.robot_arm : config.robot_hand,
          .reach_timeout = config.reach_timeout,
          .faults = {config.state, config.command, is_arm ? config.seed : HandSeed(config.seed)},
          .thread = {.name = is_arm ? "twin-proxy-arm" : "twin-proxy-hand",
                     .fifo_priority = config.fifo_priority,
                     .cpu = config.cpu}};
}

/// A port and its handler.
struct Service {
  Service(const ProxyConfig& config, fci::HeadKind kind, const MonotonicClock& clock,
          const server::TellPeople& tell)
      : handler(HandlerSettings(config, kind), clock, tell),
        acceptor(server::SingleClientAcceptor::SettingsOf(config, kind), handler, tell) {}

  RelayRequestHandler handler;
  server::SingleClientAcceptor acceptor;
};

}  // namespace

void ProxyConfig::Validate() const {
  state.Validate("link.state");
  command.Validate("link.command");
}

class Proxy::Impl {
 public:
  Impl(const ProxyConfig& config, const MonotonicClock& clock, server::TellPeople tell)
      : clock_(clock),
        tell_(std::move(tell)),
        arm_(Validated(config), fci::HeadKind::kArm, clock, tell_),
        hand_(config, fci::HeadKind::kHand, clock, tell_) {}

  void Run(const std::function<bool()>& ends) {
    while (!ends()) {
      Wait();
      const Time now = clock_.Now();
      for (Service* service : {&arm_, &hand_}) service->acceptor.Serve(now);
    }
    for (Service* service : {&arm_, &hand_}) service->acceptor.End();
  }

  [[nodiscard]] const Service& arm() const noexcept { return arm_; }
  [[nodiscard]] const Service& hand() const noexcept { return hand_; }

 private:
  void Wait() {
    waited_.clear();
    for (const Service* service : {&arm_, &hand_}) {
      service->acceptor.AddTo(waited_);
      service->handler.AddTo(waited_);
    }
    const Duration timeout = std::min(arm_.acceptor.poll_timeout(), hand_.acceptor.poll_timeout());
    static_cast<void>(fci::AwaitAny(waited_, clock_, clock_.Now() + timeout));
  }

  const MonotonicClock& clock_;
  const server::TellPeople tell_;
  Service arm_;
  Service hand_;
  std::vector<pollfd> waited_;
};

Proxy::Proxy(const ProxyConfig& config, const MonotonicClock& clock, server::TellPeople tell)
    : impl_(std::make_unique<Impl>(config, clock, std::move(tell))) {}

Proxy::~Proxy() = default;

fci::Endpoint Proxy::arm() const {
  return impl_->arm().acceptor.local();
}

fci::Endpoint Proxy::hand() const {
  return impl_->hand().acceptor.local();
}

void Proxy::Run(const std::function<bool()>& ends) {
  impl_->Run(ends);
}

ProxyCounts Proxy::counts() const noexcept {
  return {impl_->arm().handler.counts(), impl_->hand().handler.counts()};
}

}  // namespace twin::proxy
