#include "twin/faults/loss_model.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::faults {
namespace {

/// Index of a draw within a message number.
constexpr std::uint32_t kTransitionDraw = 0;
constexpr std::uint32_t kStationaryDraw = 1;

/// Stationary probability of the chain's bad state.
double StationaryShare(const GilbertElliottLoss& chain) noexcept {
  return chain.good_to_bad / (chain.good_to_bad + chain.bad_to_good);
}

bool IsScripted(const ScriptedLoss& script, std::uint64_t number) noexcept {
  const auto after = std::upper_bound(
      script.runs.begin(), script.runs.end(), number,
      [](std::uint64_t n, const ScriptedLoss::Run& run) noexcept { return n < run.first; });
  return after != script.runs.begin() && number - std::prev(after)->first < std::prev(after)->count;
}

}  // namespace

LossModel::LossModel(const IndependentLoss& independent) : parameters_(independent) {
  RequireInRange("loss: probability", independent.probability, 0, 1);
}

LossModel::LossModel(const GilbertElliottLoss& gilbert_elliott) : parameters_(gilbert_elliott) {
  RequireInRange("loss: good_to_bad", gilbert_elliott.good_to_bad, 0, 1);
  RequireInRange("loss: bad_to_good", gilbert_elliott.bad_to_good, 0, 1);
  RequireInRange("loss: loss_good", gilbert_elliott.loss_good, 0, 1);
  RequireInRange("loss: loss_bad", gilbert_elliott.loss_bad, 0, 1);
  if (gilbert_elliott.bad_to_good == 0) {
    throw InputError("loss: bad_to_good is 0; it must be above 0, else a burst never ends");
  }
}

LossModel::LossModel(ScriptedLoss scripted) {
  std::uint64_t free_from = 0;
  for (std::size_t i = 0; i < scripted.runs.size(); ++i) {
    const auto& run = scripted.runs[i];
    if (run.count == 0 || run.count > std::numeric_limits<std::uint64_t>::max() - run.first) {
      throw InputError(
          fmt::format("loss: runs[{}].count is {}; it must be at least 1, and no number may exceed "
                      "2^64 - 1",
                      i, run.count));
    }
    if (run.first < free_from) {
      throw InputError(
          fmt::format("loss: runs[{}].first is {}; it must be at least {}, where the run before it "
                      "has ended: list the runs in rising order, without overlap",
                      i, run.first, free_from));
    }
    free_from = run.first + run.count;
  }
  parameters_ = std::move(scripted);
}

LossProcess::LossProcess(LossModel model, std::uint64_t seed, RandomStream loss, RandomStream burst)
    : model_(std::move(model)), loss_(seed, loss), burst_(seed, burst) {}

bool LossProcess::Loses(std::uint64_t number, std::uint32_t repeat) noexcept {
  const auto draw = [&](double probability) noexcept {
    return probability > 0 && loss_.Uniform(number, repeat) < probability;
  };
  const LossModel::Parameters& parameters = model_.parameters();
  if (const auto* independent = std::get_if<IndependentLoss>(&parameters)) {
    return draw(independent->probability);
  }
  if (const auto* chain = std::get_if<GilbertElliottLoss>(&parameters)) {
    return draw(InBadState(*chain, number) ? chain->loss_bad : chain->loss_good);
  }
  return IsScripted(*std::get_if<ScriptedLoss>(&parameters), number);
}

bool LossProcess::InBadState(const GilbertElliottLoss& chain, std::uint64_t number) noexcept {
  const std::uint64_t block_start = number - number % kBlock;
  if (!started_ || last_number_ < block_start || last_number_ > number) {
    bad_ = burst_.Uniform(block_start, kStationaryDraw) < StationaryShare(chain);
    last_number_ = block_start;
    started_ = true;
  }
  while (last_number_ < number) {
    const double to_bad = bad_ ? 1 - chain.bad_to_good : chain.good_to_bad;
    bad_ = burst_.Uniform(++last_number_, kTransitionDraw) < to_bad;
  }
  return bad_;
}

}  // namespace twin::faults
