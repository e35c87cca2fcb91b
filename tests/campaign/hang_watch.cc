#include "campaign/hang_watch.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <string_view>
#include <utility>

namespace twin::campaign {
namespace {

thread_local const std::string* running = nullptr;  ///< the world's name
/// For a crash of a stack that is full.
thread_local std::array<std::byte, 16384> crash_stack;

void Print(std::string_view text) noexcept {
  static_cast<void>(!::write(STDERR_FILENO, text.data(), text.size()));
}

/// Raises the signal again, for the system's own handling, which ends the program.
void OnCrash(int signal) {
  ::raise(signal);  // blocked until this returns
  if (running == nullptr) return;
  Print(*running);
  Print(" crashed\n");
}

}  // namespace

void TellCrashes() {
  struct sigaction action {};
  action.sa_handler = &OnCrash;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_ONSTACK);
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL}) {
    ::sigaction(signal, &action, nullptr);
  }
  // A controller that calls exit() would end the campaign as a success.
  std::atexit([] {
    if (running != nullptr) std::abort();
  });
}

HangWatch::HangWatch(Duration patience, std::function<void(const World& world)> give_up)
    : patience_(patience), give_up_(std::move(give_up)) {
  if (patience_ > Duration::zero()) {
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
}

HangWatch::World::World(HangWatch& watch, std::string name, std::function<std::string()> keep)
    : watch_(watch), name_(std::move(name)), keep_(std::move(keep)) {
  running = &name_;
  const stack_t stack{.ss_sp = crash_stack.data(), .ss_flags = 0, .ss_size = crash_stack.size()};
  ::sigaltstack(&stack, &stack_before_);
  const std::scoped_lock lock(watch_.mutex_);
  watch_.begun_.emplace(this, watch_.clock_.Now());
}

HangWatch::World::~World() {
  ::sigaltstack(&stack_before_, nullptr);
  running = nullptr;
  const std::scoped_lock lock(watch_.mutex_);
  watch_.begun_.erase(this);
}

void HangWatch::Run(const std::stop_token& stop) {
  const Duration often = std::min<Duration>(patience_, std::chrono::seconds(1));
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    stopped_.wait_for(lock, stop, often, [] { return false; });
    const auto late = std::ranges::find_if(
        begun_, [&](const auto& world) { return clock_.Now() - world.second > patience_; });
    if (late != begun_.end()) {
      give_up_(*late->first);
      begun_.erase(late);
    }
  }
}

}  // namespace twin::campaign
