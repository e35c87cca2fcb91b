#include "twin/onboard/vacuum_pump.h"

#include <algorithm>
#include <cmath>
#include <variant>

namespace twin::onboard {
namespace {

constexpr double kPascal = 0.01;      // mbar
constexpr double kUnit = 10;          // of a command's set point, mbar
constexpr double kMost = 750;         // that the pump reaches, mbar
constexpr double kBand = 75;          // of the regulation, mbar
constexpr double kPart = 550. / 750;  // H2 / H1
constexpr double kPartHysteresis = 10;
constexpr double kRange = 0.1;  // of the set point
constexpr double kGone = 50;    // mbar: nothing is held below
constexpr double kPercent = 100;

}  // namespace

VacuumPump::VacuumPump(const PumpSensors& sensors) noexcept {
  Observe(sensors.vacuum * kPascal);
  Report();
}

HandStart VacuumPump::Start(const HandCommand& command) noexcept {
  HandStart start{0, FindBadValue(command, 0, HandDevice::kCobotPump)};
  if (start.bad) return start;
  start.ticket = outcomes_.Begin();
  std::visit([this](const auto& one) { Take(one); }, command);
  return start;
}

void VacuumPump::Take(const hand::Vacuum& vacuum) noexcept {
  sucks_ = true;
  set_point_ = std::min(kUnit * vacuum.vacuum, kMost);
  cycles_left_ = vacuum.timeout_ms;
  held_ = false;
  pump_.part_detached = false;
}

void VacuumPump::Take(const hand::DropOff& drop) noexcept {
  sucks_ = false;
  cycles_left_ = drop.timeout_ms;
}

void VacuumPump::Take(const hand::Stop& /*stop*/) noexcept {
  sucks_ = false;
  End(HandResult::kSuccess);
}

void VacuumPump::End(HandResult result) noexcept {
  pump_.device_status = result == HandResult::kSuccess ? PumpStatus::kGreen : PumpStatus::kYellow;
  outcomes_.End(result);
}

PumpDrive VacuumPump::Cycle(const PumpSensors& sensors) noexcept {
  const double vacuum = sensors.vacuum * kPascal;
  Observe(vacuum);
  Advance();
  const double power = sucks_ ? std::clamp((set_point_ - vacuum) / kBand, 0.0, 1.0) : 0;
  pump_.actual_power = static_cast<std::int32_t>(std::lround(kPercent * power));
  ++pump_.message_id;
  Report();
  return {.power = power, .vents = !sucks_};
}

void VacuumPump::Observe(double vacuum) noexcept {
  const bool was_present = pump_.part_present;
  const double part = kPart * set_point_ - (was_present ? kPartHysteresis : 0);
  pump_.vacuum = static_cast<std::int32_t>(std::lround(vacuum));
  pump_.part_present = set_point_ > 0 && vacuum > part;
  pump_.in_control_range = sucks_ && std::abs(vacuum - set_point_) <= kRange * set_point_;
  held_ = held_ || pump_.part_present;
  if (was_present && !pump_.part_present && sucks_) pump_.device_status = PumpStatus::kYellow;
  if (held_ && !pump_.part_present && vacuum < kGone) pump_.part_detached = true;
}

void VacuumPump::Advance() noexcept {
  if (!outcomes_.is_running()) return;
  const bool is_gone = !pump_.part_present && pump_.vacuum < kGone;
  const bool done = sucks_ ? pump_.part_present : is_gone;
  if (done) return End(HandResult::kSuccess);
  if (cycles_left_-- > 0) return;
  End(HandResult::kUnsuccessful);
  sucks_ = false;
}

void VacuumPump::Report() noexcept {
  state_.message_id = pump_.message_id;
  state_.is_grasped = pump_.part_present;
  state_.pump = pump_;
}

}  // namespace twin::onboard
