#include "cell_clock.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::python {

CellClock::CellClock(std::vector<CellMember> members) {
  for (CellMember& member : members) robots_.push_back({.member = std::move(member)});
}

namespace {

constexpr const char* kInUse =
    "the cell is in use, by another thread, by a function of together() or by the call whose law "
    "this is";

}  // namespace

Duration CellClock::Now() const {
  const std::scoped_lock lock(mutex_);
  if (!MayCall()) throw std::runtime_error(kInUse);
  std::uint64_t most = 0;
  for (const Robot& robot : robots_) most = std::max(most, robot.cycles);
  return static_cast<std::int64_t>(most) * kCycle;
}

bool CellClock::has_call() const noexcept {
  return std::ranges::any_of(robots_, [this](const Robot& one) { return one.caller == turn_; });
}

bool CellClock::MayCall() const {
  const bool has_turn =
      functions_.empty() || functions_[turn_].thread == std::this_thread::get_id();
  return has_turn && !has_call();
}

void CellClock::Admit(std::size_t robot) {
  const std::scoped_lock lock(mutex_);
  if (!MayCall()) throw std::runtime_error(kInUse);
  if (!functions_.empty() && cancelled_) throw Cancelled();
  Robot& one = robots_[robot];
  if (one.is_taken()) {
    throw std::runtime_error(fmt::format(
        "robot {} is moved by another function of together(); call the robot that this one got",
        one.member.name));
  }
  one.caller = turn_;
}

void CellClock::Dismount(std::size_t robot) noexcept {
  const std::scoped_lock lock(mutex_);
  robots_[robot].caller.reset();
}

void CellClock::Lead(Robot& robot) noexcept {
  robot.is_led = true;
  robot.lead();
  robot.is_led = false;
}

void CellClock::EndCycle(std::size_t robot) noexcept {
  Robot& one = robots_[robot];
  ++one.cycles;
  if (one.is_led) return;  // the call that leads it waits for the others
  while (true) {
    const auto late = std::ranges::find_if(robots_, [&one](const Robot& other) {
      // Those of its island have met it in the step.
      return other.member.island != one.member.island && other.cycles < one.cycles;
    });
    if (late == robots_.end()) return;
    late->is_taken() ? HandOver() : Lead(*late);
  }
}

void CellClock::LetOthers(std::size_t island) noexcept {
  const auto free = std::ranges::find_if(robots_, [island](const Robot& one) {
    return one.member.island == island && !one.is_taken();
  });
  free == robots_.end() ? HandOver() : Lead(*free);
}

std::size_t CellClock::After(std::size_t function) const noexcept {
  std::size_t next = function;
  do {
    next = (next + 1) % functions_.size();
  } while (next != function && functions_[next].has_left);
  return next;
}

void CellClock::HandOver() noexcept {
  std::unique_lock lock(mutex_);
  TWIN_CHECK(!functions_.empty());
  const std::size_t own = turn_;
  turn_ = After(own);
  TWIN_CHECK(turn_ != own);
  turned_.notify_all();
  turned_.wait(lock, [this, own] { return turn_ == own; });
}

void CellClock::RequireIdle() const {
  const std::scoped_lock lock(mutex_);
  if (functions_.empty() && !has_call()) return;
  throw std::runtime_error(kInUse);
}

void CellClock::Gather(const std::vector<std::size_t>& robots) {
  RequireIdle();
  const std::scoped_lock lock(mutex_);
  for (const std::size_t robot : robots) {
    functions_.push_back({.robot = robot});
    robots_[robot].awaits_function = true;
  }
  turn_ = 0;
}

void CellClock::Enter(std::size_t function) {
  std::unique_lock lock(mutex_);
  const auto has_left = [&] {
    return function >= functions_.size() || functions_[function].has_left;
  };
  if (!has_left()) functions_[function].thread = std::this_thread::get_id();
  turned_.wait(lock, [&] { return turn_ == function || has_left(); });
  if (has_left() || cancelled_) throw Cancelled();
  robots_[functions_[function].robot].awaits_function = false;
}

void CellClock::Leave(std::size_t function) noexcept {
  const std::scoped_lock lock(mutex_);
  if (function >= functions_.size()) return;
  Function& one = functions_[function];
  if (one.has_left) return;
  one.has_left = true;
  robots_[one.robot].awaits_function = false;
  turn_ = After(function);
  turned_.notify_all();
  ended_.notify_all();
}

bool CellClock::AwaitEnd(std::chrono::milliseconds limit) {
  std::unique_lock lock(mutex_);
  const auto all_left = [this] { return std::ranges::all_of(functions_, &Function::has_left); };
  if (!ended_.wait_for(lock, limit, all_left)) return false;
  functions_.clear();
  turn_ = 0;
  cancelled_ = false;
  stopping_ = false;
  return true;
}

}  // namespace twin::python
