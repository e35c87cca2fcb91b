#include "twin/scenario/loss.h"

#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::scenario {
namespace {

rt::LossModel Make(const IndependentLoss& loss) {
  return rt::LossModel(rt::IndependentLoss{loss.percent / 100});
}

rt::LossModel Make(const GilbertElliottLoss& loss) {
  return rt::LossModel(rt::GilbertElliottLoss{loss.good_to_bad / 100, loss.bad_to_good / 100,
                                              loss.loss_good / 100, loss.loss_bad / 100});
}

rt::LossModel Make(const ScriptedLoss& loss) {
  rt::ScriptedLoss script;
  for (const ScriptedLoss::Burst& burst : loss.bursts) {
    if (burst.at < Duration::zero() || burst.at % kCycle != Duration::zero()) {
      throw InputError(fmt::format(
          "{} ns is no time of a message; they are 1 ms apart, so give a whole number of ms",
          burst.at.count()));
    }
    script.runs.push_back({static_cast<std::uint64_t>(burst.at / kCycle), burst.count});
  }
  return rt::LossModel(std::move(script));
}

}  // namespace

rt::LossModel Loss::Model() const {
  return std::visit([](const auto& parameters) { return Make(parameters); }, law);
}

}  // namespace twin::scenario
