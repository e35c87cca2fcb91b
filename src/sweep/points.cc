#include "twin/sweep/points.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numeric>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <boost/random/sobol.hpp>

#include "twin/core/content_hash.h"
#include "twin/core/error.h"
#include "twin/core/quantity.h"
#include "twin/core/random.h"
#include "twin/scenario/text_changes.h"

namespace twin::sweep {
namespace {

namespace fs = std::filesystem;
using scenario::SweepAxis;
using scenario::SweepNumber;

constexpr std::uint64_t kMostRuns = 1ULL << 63;
constexpr std::uint64_t kMostChecked = 1000;

/// Random numbers of an axis. The key is made of the sweep's seed and the axis, so that they are
/// independent of those of the runs and of other axes.
Random RandomOf(const scenario::SweepFile& file, const SweepAxis& axis) {
  ContentHash hash;
  hash.Add("sweep");
  hash.Add(fmt::format("{}", file.seed));
  hash.Add(axis.key);
  return {std::stoull(hash.Hex().substr(0, 16), nullptr, 16), RandomStream::kGoalSeed};
}

std::string TextOf(double value, const std::string& unit) {
  return unit.empty() ? FormatNumber(value) : fmt::format("{} {}", FormatNumber(value), unit);
}

/// @param share  of the way, in [0, 1].
std::string Between(const scenario::SweepRange& range, double share) {
  const double from = range.from.value;
  const double to = range.to.value;
  if (share <= 0) return TextOf(from, range.from.unit);
  if (share >= 1) return TextOf(to, range.from.unit);
  const double value =
      range.is_logarithmic ? from * std::pow(to / from, share) : from + (to - from) * share;
  // Twelve digits: 0.1 + 0.2 reads 0.3.
  return TextOf(ParseNumber(fmt::format("{:.12g}", value)), range.from.unit);
}

std::string Drawn(const scenario::SweepDraw& draw, const Random& random, std::uint64_t point,
                  std::uint32_t run) {
  const double a = draw.first.value;
  const double b = draw.second.value;
  const double value =
      draw.is_normal ? a + b * random.Normal(point, run) : a + (b - a) * random.Uniform(point, run);
  return TextOf(value, draw.first.unit);
}

/// Values of an axis in a grid.
std::uint64_t CountOf(const SweepAxis& axis) {
  if (axis.draw) return 1;
  return axis.range ? axis.range->steps : axis.values.size();
}

/// A random order of 0 ... count - 1 (Fisher and Yates).
std::vector<std::uint32_t> Shuffled(std::uint64_t count, const Random& random) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  for (std::uint64_t i = count; i > 1; --i) {
    const auto j = static_cast<std::uint64_t>(random.Uniform(i, 1) * static_cast<double>(i));
    std::swap(order[i - 1], order[j]);
  }
  return order;
}

constexpr double kSobolRange = 4294967296.0;  ///< 2^32

/// The first points of a Sobol sequence, by axis: the zero that Boost leaves out and the others,
/// each axis shifted (its bits reversed at random places), which keeps how evenly they lie.
std::vector<std::vector<std::uint32_t>> SobolPoints(std::uint64_t count,
                                                    const std::vector<Random>& axes) {
  std::vector<std::vector<std::uint32_t>> points;
  std::vector<std::uint32_t> shifts;
  for (const Random& random : axes) {
    shifts.push_back(static_cast<std::uint32_t>(random.Uniform(0, 2) * kSobolRange));
    points.emplace_back(count, shifts.back());
  }
  boost::random::sobol_engine<std::uint32_t, 32> sequence(axes.size());
  for (std::uint64_t i = 1; i < count; ++i) {
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      points[axis][i] = sequence() ^ shifts[axis];
    }
  }
  return points;
}

fs::path FindBase(const scenario::SweepFile& file, const fs::path& models) {
  for (const fs::path& folder : {file.folder, models, models / "scenarios"}) {
    std::error_code none;
    if (fs::path found = folder / file.scenario; fs::is_regular_file(found, none)) return found;
  }
  throw InputError(fmt::format("scenario: there is no {} beside the sweep's file or in {}",
                               file.scenario.string(), models.string()));
}

/// {link: {command_loss: 1 %}}. @param value  empty: null.
std::string ChangeOf(const std::string& key, const std::string& value) {
  std::string text = value.empty() ? "null" : value;
  for (std::size_t end = key.size(); end != std::string::npos;) {
    const std::size_t dot = end == 0 ? std::string::npos : key.rfind('.', end - 1);
    const std::size_t begin = dot == std::string::npos ? 0 : dot + 1;
    text = fmt::format("{{{}: {}}}", key.substr(begin, end - begin), text);
    end = dot;
  }
  return text;
}

}  // namespace

Sweep::Sweep(const fs::path& file, const fs::path& models)
    : file_(scenario::LoadSweep(file)), scenario_file_(FindBase(file_, models)) {
  std::ifstream in(scenario_file_, std::ios::binary);
  scenario_text_.assign(std::istreambuf_iterator<char>(in), {});
  if (!in) throw InputError(fmt::format("{}: cannot be read", scenario_file_.string()));
  if (file_.samples) points_ = *file_.samples;
  std::uint64_t runs = 0;
  bool too_many = false;
  if (file_.samples) {
    places_ = Places();
  } else {
    for (const SweepAxis& axis : file_.axes) {
      too_many |= __builtin_mul_overflow(points_, CountOf(axis), &points_);
    }
  }
  too_many |= __builtin_mul_overflow(points_, file_.seeds, &runs) || runs > kMostRuns;
  if (too_many) throw InputError(fmt::format("{}: has more than 2^63 runs", file.string()));
  if (file_.budget && runs > *file_.budget) {
    throw InputError(fmt::format("{}: {} points of {} seeds are {} runs; budget allows {}",
                                 file.string(), points_, file_.seeds, runs, *file_.budget));
  }
}

bool Sweep::draws() const noexcept {
  for (const SweepAxis& axis : file_.axes) {
    if (axis.draw) return true;
  }
  return false;
}

std::vector<std::vector<std::uint32_t>> Sweep::Places() const {
  std::vector<std::vector<std::uint32_t>> places(file_.axes.size());
  std::vector<std::size_t> sampled;
  std::vector<Random> random;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (file_.axes[i].draw) continue;
    sampled.push_back(i);
    random.push_back(RandomOf(file_, file_.axes[i]));
  }
  if (file_.has_sobol_samples && !sampled.empty()) {
    auto points = SobolPoints(points_, random);
    for (std::size_t i = 0; i < sampled.size(); ++i) places[sampled[i]] = std::move(points[i]);
    return places;
  }
  for (std::size_t i = 0; i < sampled.size(); ++i) {
    places[sampled[i]] = Shuffled(points_, random[i]);
  }
  return places;
}

std::string Sweep::SampledValue(std::size_t axis, std::uint64_t point) const {
  const SweepAxis& of = file_.axes[axis];
  const double place = places_[axis][point];
  if (file_.has_sobol_samples) return Between(*of.range, place / kSobolRange);
  const double within = RandomOf(file_, of).Uniform(point, 0);
  return Between(*of.range, (place + within) / static_cast<double>(points_));
}

std::vector<std::string> Sweep::ValuesAt(std::uint64_t point) const {
  std::vector<std::string> values(file_.axes.size());
  std::uint64_t rest = point;
  for (std::size_t i = values.size(); i-- > 0;) {
    const SweepAxis& axis = file_.axes[i];
    if (axis.draw) continue;
    if (file_.samples) {
      values[i] = SampledValue(i, point);
      continue;
    }
    const std::uint64_t count = CountOf(axis);
    const std::uint64_t index = rest % count;
    rest /= count;
    values[i] = axis.range ? Between(*axis.range,
                                     static_cast<double>(index) / static_cast<double>(count - 1))
                           : axis.values[index];
  }
  return values;
}

Case Sweep::CaseAt(std::uint64_t run) const {
  Case one{.point = run / file_.seeds, .seed = 0, .values = {}};
  const std::uint64_t number = run % file_.seeds;
  one.seed = file_.first_seed + number;
  one.values = ValuesAt(one.point);
  for (std::size_t i = 0; i < one.values.size(); ++i) {
    const SweepAxis& axis = file_.axes[i];
    if (!axis.draw) continue;
    one.values[i] =
        Drawn(*axis.draw, RandomOf(file_, axis), one.point, static_cast<std::uint32_t>(number));
  }
  return one;
}

const std::string& Sweep::LabelOf(std::size_t axis, const std::string& value) const {
  const SweepAxis& of = file_.axes[axis];
  const auto at = std::ranges::find(of.values, value);
  if (of.names.empty() || at == of.values.end()) return value;
  return of.names[static_cast<std::size_t>(at - of.values.begin())];
}

std::string Sweep::NameOf(const Case& one) const {
  std::string values;
  for (std::size_t i = 0; i < one.values.size(); ++i) {
    values +=
        fmt::format("{}{}: {}", i == 0 ? "" : ", ", file_.axes[i].key, LabelOf(i, one.values[i]));
  }
  return fmt::format("point {} ({})", one.point + 1, values);
}

std::string Sweep::TextWith(const std::vector<std::string>& values) const {
  std::vector<std::string> changes;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i].empty()) continue;
    const std::string& key = file_.axes[i].key;
    // A map replaces what was there: it is not merged with it.
    if (values[i].starts_with('{')) changes.push_back(ChangeOf(key, ""));
    changes.push_back(ChangeOf(key, values[i]));
  }
  return scenario::WithChanges(scenario_text_, scenario_file_, changes);
}

scenario::Scenario Sweep::ScenarioOf(const Case& one) const {
  try {
    scenario::Scenario scenario = scenario::Parse(TextWith(one.values), scenario_file_);
    scenario.seed = one.seed;
    if (!scenario.is_lockstep()) {
      throw InputError("runs of a sweep repeat, which takes drive: lockstep and no remote robot");
    }
    return scenario;
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", NameOf(one), error.what()));
  }
}

void Sweep::CheckPoints() const {
  const std::uint64_t checked = points_ <= kMostChecked ? points_ : 1;
  for (std::uint64_t point = 0; point < checked; ++point) {
    static_cast<void>(ScenarioOf(CaseAt(point * file_.seeds)));
  }
}

}  // namespace twin::sweep
