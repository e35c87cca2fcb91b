#include "plugins/ros2/hand_commander.h"

#include <chrono>
#include <exception>
#include <utility>

#include "twin/core/error.h"

namespace twin::ros2 {
namespace {

constexpr auto kLookForStop = std::chrono::milliseconds(50);

}  // namespace

HandCommander::HandCommander(Connect connect)
    : connect_(std::move(connect)), thread_([this](const std::stop_token& stop) { Run(stop); }) {}

HandCommander::~HandCommander() {
  thread_.request_stop();
}

void HandCommander::Begin(HandWork work) {
  std::optional<HandWork> dropped;
  {
    const std::lock_guard lock(mutex_);
    dropped = std::exchange(next_, std::move(work));
    stops_ = true;
    wake_.notify_one();
  }
  if (dropped) dropped->end(std::nullopt, {}, "a newer command took its place");
}

void HandCommander::Stop() {
  const std::lock_guard lock(mutex_);
  stops_ = true;
  wake_.notify_one();
}

void HandCommander::Run(const std::stop_token& stop) {
  while (true) {
    std::optional<HandWork> work;
    {
      std::unique_lock lock(mutex_);
      if (!wake_.wait(lock, stop, [this] { return next_.has_value(); })) return;
      work = std::exchange(next_, std::nullopt);
      stops_ = stop.stop_requested();
    }
    Execute(*work);
  }
}

void HandCommander::Execute(const HandWork& work) {
  HandState state;
  try {
    const std::shared_ptr<backend::Hand> connected = connect_();
    backend::Hand& hand = *connected;
    state = hand.ReadState();
    const HandTicket ticket = hand.Start(work.choose(state));
    bool stopped = false;
    std::optional<HandResult> result;
    while (!(result = hand.Outcome(ticket))) {
      state = hand.ReadState();
      work.look(state);
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, kLookForStop, [&] { return stops_ && !stopped; });
      if (stopped || !(stops_ || thread_.get_stop_token().stop_requested())) continue;
      stopped = true;
      lock.unlock();
      static_cast<void>(hand.Start(hand::Stop()));
    }
    work.end(result, hand.ReadState(), stopped ? "stopped" : "");
  } catch (const std::exception& error) {
    work.end(std::nullopt, state, error.what());
  }
}

}  // namespace twin::ros2
