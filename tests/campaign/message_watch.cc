#include "campaign/message_watch.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <variant>

#include <fmt/format.h>

namespace twin::campaign {
namespace {

constexpr Duration kRounding = Duration(3);  ///< of times to whole nanoseconds
/// Between two losses that are counted and the law that drew them, in standard deviations.
constexpr double kUnlikely = 8;
/// More than that, since bursts are few and long.
constexpr double kFewBursts = 60;
/// Commands that were written so long before a motion's end have come, if they were not lost.
constexpr Duration kArrives = std::chrono::milliseconds(100);

bool IsInMotion(const record::TickRecord& tick) {
  return tick.action != record::TickAction::kPublished;
}

/// No delay by this law is shorter.
Duration Least(const scenario::Delay& delay) {
  if (const auto* law = std::get_if<faults::ConstantDelay>(&delay.law)) return law->value;
  if (const auto* law = std::get_if<faults::LogNormalDelay>(&delay.law)) return law->offset;
  if (const auto* law = std::get_if<faults::GammaDelay>(&delay.law)) return law->offset;
  if (const auto* law = std::get_if<faults::EmpiricalDelay>(&delay.law)) return law->edges.front();
  return {};
}

bool IsConstant(const scenario::Delay& delay) {
  return std::holds_alternative<faults::ConstantDelay>(delay.law);
}

/// Whether another seed draws other delays; a normal one without spread is drawn, and does not.
bool IsDrawn(const scenario::Delay& delay) {
  const auto* const normal = std::get_if<faults::NormalDelay>(&delay.law);
  return !IsConstant(delay) && (normal == nullptr || normal->sigma > Duration::zero());
}

bool IsScripted(const scenario::Loss& loss) {
  return std::holds_alternative<scenario::ScriptedLoss>(loss.law);
}

/// Whether a script loses this message.
bool Loses(const scenario::Loss& loss, std::uint64_t number) {
  const auto* script = std::get_if<scenario::ScriptedLoss>(&loss.law);
  return script != nullptr && std::ranges::any_of(script->bursts, [number](const auto& burst) {
           const auto first = static_cast<std::uint64_t>(burst.at / kCycle);
           return number >= first && number < first + burst.count;
         });
}

/// Whether chance may lose a message.
bool HasChance(const scenario::Loss& loss) {
  const auto* const law = std::get_if<scenario::IndependentLoss>(&loss.law);
  return law != nullptr ? law->percent > 0 : !IsScripted(loss);
}

Duration Apart(Time a, Time b) {
  return a < b ? b - a : a - b;
}

double SpeedOf(double drift_ppm) {
  return 1 + drift_ppm * 1e-6;
}

}  // namespace

bool WasWritten(const record::TickRecord& tick) {
  return record::WroteCommand(tick) || (tick.action == record::TickAction::kLimited &&
                                        tick.command.message_id == tick.message_id);
}

MessageWatch::Direction MessageWatch::Of(const scenario::DirectionSection& section) {
  return {.least = Least(section.delay),
          .is_certain = IsConstant(section.delay) && section.duplication.share_percent == 0 &&
                        section.reordering.share_percent == 0};
}

MessageWatch::MessageWatch(const scenario::Scenario& world, Note note)
    : world_(world),
      note_(std::move(note)),
      states_(Of(world.link.state)),
      commands_(Of(world.link.command)),
      reads_all_(world.loop == loop::LoopKind::kAsynchronous && states_.is_certain &&
                 IsConstant(world.tick.cost) && Least(world.tick.cost) < kCycle / 2) {}

void MessageWatch::OnTick(const record::TickRecord& tick) {
  CheckTickCount(tick);
  CheckPeriod(tick);
  CheckStall(tick);
  CheckDepositTime(tick);
  CheckArrival(tick);
  if (WasWritten(tick) && IsDrawn(world_.tick.cost)) {
    const Duration cost = tick.written - tick.read;
    if (cost != std::exchange(last_cost_, cost)) ++changed_costs_;
    costs_hash_.AddWord(static_cast<std::uint64_t>(cost.count()));
  }
  if (WasWritten(tick)) {
    lately_.push_back(tick.written);
    if (Loses(world_.link.command.loss, tick.message_id)) ++lost_by_script_;
  }
  ticks_[tick.message_id % kKept] = tick;
  last_tick_ = tick;
}

void MessageWatch::CheckTickCount(const record::TickRecord& tick) {
  if (!WasWritten(tick) && tick.written != tick.read) {
    note_("account",
          fmt::format("the tick of state {} writes, and says it did not", tick.message_id));
  }
  if (!last_tick_) return;
  const std::uint64_t skipped = tick.message_id - last_tick_->message_id - 1;
  if (tick.skipped_states != skipped) {
    note_("account", fmt::format("the tick of state {} tells of {} skipped states, after {}",
                                 tick.message_id, tick.skipped_states, last_tick_->message_id));
  }
}

void MessageWatch::CheckPeriod(const record::TickRecord& tick) {
  if (world_.tick.period_tolerance == Duration::zero() || !last_tick_ || !IsInMotion(tick)) return;
  const Duration period = tick.read - last_tick_->read;
  const bool is_off = Apart(Time(period), Time(kCycle)) > world_.tick.period_tolerance;
  if (is_off == (tick.action == record::TickAction::kSkipped)) return;
  note_("period",
        fmt::format("state {} came {} ns after the one before, and its tick was {}skipped",
                    tick.message_id, period.count(), is_off ? "not " : ""));
}

void MessageWatch::CheckStall(const record::TickRecord& tick) {
  if (!record::WroteCommand(tick) || !last_tick_) return;
  const bool is_fresh = last_command_ == 0 || tick.deposit_time != last_tick_->deposit_time;
  without_deposit_ = is_fresh ? 0 : without_deposit_ + tick.message_id - last_command_;
  last_command_ = tick.message_id;
  const double periods = 3 / world_.controller.rate_hz;
  const auto allowed = static_cast<std::uint64_t>(
      std::llround(std::max(ToSeconds(world_.tick.stall_time), periods) / kCycleSeconds));
  if (tick.stalled == (without_deposit_ > allowed)) return;
  note_("stall",
        fmt::format("the tick of state {}: {} cycles without a deposit, {} are allowed, "
                    "and the source is {}stalled",
                    tick.message_id, without_deposit_, allowed, tick.stalled ? "" : "not "));
}

void MessageWatch::CheckDepositTime(const record::TickRecord& tick) {
  if (world_.loop != loop::LoopKind::kAsynchronous || !record::WroteCommand(tick)) return;
  const double speed = SpeedOf(world_.controller.clock_drift_ppm);
  const Time made(FromSeconds(ToSeconds(tick.deposit_time.time_since_epoch()) / speed));
  if (made > tick.read + kRounding) {
    note_("clocks", fmt::format("the tick of state {} uses a deposit of {} ns later",
                                tick.message_id, (made - tick.read).count()));
  }
  if (!first_deposit_) first_deposit_ = tick.deposit_time;
  if (!IsConstant(world_.controller.wake_delay)) return;
  // On its own clock the controller wakes up at whole periods.
  const double periods = ToSeconds(tick.deposit_time - *first_deposit_) * world_.controller.rate_hz;
  const double off = std::abs(periods - std::round(periods)) / world_.controller.rate_hz;
  if (off > 2e-8) {
    note_("clocks", fmt::format("the tick of state {}: its deposit is {} s off the grid of {} Hz",
                                tick.message_id, off, world_.controller.rate_hz));
  }
}

void MessageWatch::CheckArrival(const record::TickRecord& tick) {
  const std::uint64_t id = tick.message_id;
  const Time sent = sent_[id % kKept];
  const Duration took = tick.read - sent;
  if (took + kRounding < states_.least) {
    note_("link", fmt::format("state {} was read {} ns after it was sent, and takes {} ns at least",
                              id, took.count(), states_.least.count()));
  }
  if (Loses(world_.link.state.loss, id)) {
    note_("link", fmt::format("state {} was read, which the script of losses has", id));
  }
  if (!reads_all_) return;
  if (took > states_.least + kRounding) {
    note_("link", fmt::format("state {} was read {} ns after it was sent, and takes {} ns", id,
                              took.count(), states_.least.count()));
  }
  if (last_tick_) CountStates(last_tick_->message_id + 1, id);
}

void MessageWatch::CountStates(std::uint64_t from, std::uint64_t to) {
  for (std::uint64_t id = from; id <= to; ++id) {
    const bool is_lost = id != to;
    if (IsScripted(world_.link.state.loss)) {
      if (is_lost && !Loses(world_.link.state.loss, id)) {
        note_("link", fmt::format("state {} was lost, which no script says", id));
      }
      continue;
    }
    ++states_lost_.sent;
    ++losses_.sent;
    if (!is_lost) continue;
    ++states_lost_.lost;
    ++losses_.lost;
    losses_hash_.AddWord(id);
  }
}

void MessageWatch::OnCycle(const record::CycleRecord& record) {
  if (!first_cycle_) first_cycle_ = record;
  const auto cycles = static_cast<double>(record.state.message_id - first_cycle_->state.message_id);
  const double elapsed = cycles * kCycleSeconds / SpeedOf(world_.robot.clock_drift_ppm);
  if (Apart(record.at, first_cycle_->at + FromSeconds(elapsed)) > kRounding) {
    note_("clocks",
          fmt::format("cycle {} is at {} ns, {} s after the first by INT's clock",
                      record.state.message_id, record.at.time_since_epoch().count(), elapsed));
  }
  sent_[record.state.message_id % kKept] = record.at;
  while (record.fate != record::CommandFate::kNone && !lately_.empty() &&
         lately_.front() <= record.at - kArrives) {
    lately_.pop_front();
  }
  CheckCommand(record);
}

void MessageWatch::CheckCommand(const record::CycleRecord& record) {
  if (record.fate == record::CommandFate::kNone) return;
  const std::uint64_t answered = record.state.message_id - 1;
  const record::TickRecord& tick = ticks_[answered % kKept];
  if (tick.message_id != answered || !WasWritten(tick)) return;
  const bool is_served = record.fate == record::CommandFate::kServed;
  const Duration early = record.at - world_.link.d_INT - commands_.least - tick.written;
  if (is_served && early < -kRounding) {
    note_("link", fmt::format("cycle {} serves a command that comes {} ns too late",
                              record.state.message_id, -early.count()));
  }
  const bool is_scripted = Loses(world_.link.command.loss, answered);
  if (is_served && is_scripted) {
    note_("link", fmt::format("cycle {} serves a command that the script of losses has",
                              record.state.message_id));
  }
  if (!commands_.is_certain || early <= kRounding) return;
  if (IsScripted(world_.link.command.loss)) {
    if (is_served || is_scripted) return;
    note_("link", fmt::format("cycle {} holds, and its command came {} ns before it was due",
                              record.state.message_id, early.count()));
    return;
  }
  ++commands_lost_.sent;
  ++losses_.sent;
  if (is_served) return;
  ++commands_lost_.lost;
  ++losses_.lost;
  losses_hash_.AddWord(record.state.message_id);
}

void MessageWatch::End(std::uint64_t written, std::uint64_t arrived) {
  CheckArrived(written, arrived);
  CheckLosses("states", world_.link.state, states_lost_);
  CheckLosses("commands", world_.link.command, commands_lost_);
}

void MessageWatch::CheckArrived(std::uint64_t written, std::uint64_t arrived) {
  const scenario::DirectionSection& section = world_.link.command;
  const std::uint64_t copies = section.duplication.share_percent > 0 ? 2 : 1;
  const std::uint64_t most = copies * (written - lost_by_script_);
  const std::uint64_t not_sure = lately_.size() + lost_by_script_;
  const bool is_missing = !HasChance(section.loss) && arrived + not_sure < written;
  if (arrived <= most && !is_missing) return;
  note_("account", fmt::format("{} commands were written, {} of which a script lost and {} at the "
                               "motion's end; {} arrived",
                               written, lost_by_script_, lately_.size(), arrived));
}

void MessageWatch::CheckLosses(std::string_view what, const scenario::DirectionSection& section,
                               const Losses& losses) {
  const auto sent = static_cast<double>(losses.sent);
  double share = 0;
  double together = 1;  ///< by how much bursts raise the variance
  double few = 3;
  if (const auto* law = std::get_if<scenario::IndependentLoss>(&section.loss.law)) {
    share = law->percent / 100;
  } else if (const auto* law = std::get_if<scenario::GilbertElliottLoss>(&section.loss.law)) {
    const double change = law->good_to_bad + law->bad_to_good;
    const double bad = law->good_to_bad / change;
    share = (bad * law->loss_bad + (1 - bad) * law->loss_good) / 100;
    together = 2 / std::min(1.0, change / 100);
    few = kFewBursts;
  } else {
    return;
  }
  const double expected = share * sent;
  const double variance = expected * (1 - share) * together;
  const double off = std::abs(static_cast<double>(losses.lost) - expected);
  tally_.Add({static_cast<double>(losses.lost), expected, variance});
  if (off <= (share > 0 ? kUnlikely * std::sqrt(variance) + few : 0)) return;
  note_("link", fmt::format("{} of {} {} were lost, and the law says {:.1f}", losses.lost,
                            losses.sent, what, expected));
}

}  // namespace twin::campaign
