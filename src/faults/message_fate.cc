#include "twin/faults/message_fate.h"

#include <limits>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::faults {
namespace {

/// Draw that decides on a copy; the delay models use those from 0 on.
constexpr std::uint32_t kDecisionDraw = std::numeric_limits<std::uint32_t>::max();

const DirectionConfig& Validated(const DirectionConfig& config) {
  config.Validate("direction");
  return config;
}

}  // namespace

void DirectionConfig::Validate(std::string_view where) const {
  RequireInRange(fmt::format("{}.duplication", where), duplication, 0, 1);
  RequireInRange(fmt::format("{}.reordering", where), reordering, 0, 1);
  if (reorder_by < Duration::zero() || reorder_by > DelayModel::kLongestParameter) {
    throw InputError(
        fmt::format("{}.reorder_by is {} ns; it must lie in [0, 1 h]", where, reorder_by.count()));
  }
  if (reordering > 0 && reorder_by == Duration::zero()) {
    throw InputError(fmt::format(
        "{0}.reorder_by is 0 ns, so {0}.reordering = {1} would change nothing; give the time by "
        "which a message is held back",
        where, reordering));
  }
}

MessageFate::MessageFate(const DirectionConfig& config, std::uint64_t seed,
                         const FateStreams& streams)
    : config_(Validated(config)),
      loss_(config.loss, seed, streams.loss, streams.burst),
      delay_(seed, streams.delay),
      duplicate_(seed, streams.duplicate),
      reorder_(seed, streams.reorder) {}

Fate MessageFate::Of(std::uint64_t number, std::uint32_t repeat) noexcept {
  Fate fate;
  fate.lost = loss_.Loses(number, repeat);
  if (fate.lost) return fate;
  fate.delay = config_.delay.Draw(delay_, number);
  if (config_.reordering > 0 && reorder_.Uniform(number) < config_.reordering) {
    fate.delay += config_.reorder_by;
  }
  fate.duplicated =
      config_.duplication > 0 && duplicate_.Uniform(number, kDecisionDraw) < config_.duplication;
  if (fate.duplicated) {
    fate.duplicate_delay = fate.delay + config_.duplicate_delay.Draw(duplicate_, number);
  }
  return fate;
}

}  // namespace twin::faults
