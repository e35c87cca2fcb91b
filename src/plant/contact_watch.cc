#include "twin/plant/contact_watch.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "plant/part_names.h"

namespace twin::plant {

ContactWatch::ContactWatch(const TruthProbe& truth) : truth_(truth), objects_(truth) {
  const mjModel& model = truth.model();
  ModelParts parts(model);
  part_of_geom_ = std::move(parts.of_geom);
  names_ = std::move(parts.names);
  const std::vector<bool> moves = MovingBodies(model, truth.prefix());
  const int robot = RobotRoot(model, truth.prefix());
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const int body = model.geom_bodyid[geom];
    moves_.push_back(moves[body]);
    free_.push_back(!moves[body] && model.body_weldid[body] != 0 &&
                    model.body_rootid[body] != robot);
  }
}

void ContactWatch::Look(Time now) noexcept {
  ++looks_;
  objects_.Look(now);
  bool touches = false;
  const mjData& data = truth_.data();
  for (int i = 0; i < data.ncon; ++i) {
    const auto parts = PartsOf(i);
    if (!parts) continue;
    touches = true;
    Note((*parts)[0], (*parts)[1], now, i, true);
  }
  for (int i = 0; touches && i < data.ncon; ++i) {
    if (const auto parts = PartsBeyond(i)) Note((*parts)[0], (*parts)[1], now, i, false);
  }
  if (touches) ++cycles_;
}

std::optional<std::array<int, 2>> ContactWatch::PartsOf(int contact) const noexcept {
  const mjContact& one = truth_.data().contact[contact];
  int a = one.geom1;
  int b = one.geom2;
  if (!moves_[a]) std::swap(a, b);
  if (!moves_[a]) return std::nullopt;
  return std::array<int, 2>{part_of_geom_[a], part_of_geom_[b]};
}

bool ContactWatch::Carries(int geom) const noexcept {
  if (!free_[geom]) return false;
  const int part = part_of_geom_[geom];
  return std::any_of(
      seen_.begin(), seen_.begin() + static_cast<std::ptrdiff_t>(pairs_),
      [&](const Seen& seen) { return seen.is_arms && seen.b == part && seen.last_look == looks_; });
}

std::optional<std::array<int, 2>> ContactWatch::PartsBeyond(int contact) const noexcept {
  const mjContact& one = truth_.data().contact[contact];
  if (moves_[one.geom1] || moves_[one.geom2]) return std::nullopt;
  const int a = part_of_geom_[one.geom1];
  const int b = part_of_geom_[one.geom2];
  if (Carries(one.geom1)) return std::array<int, 2>{a, b};
  if (Carries(one.geom2)) return std::array<int, 2>{b, a};
  return std::nullopt;
}

void ContactWatch::Note(int a, int b, Time now, int contact, bool is_arms) noexcept {
  std::size_t i = 0;
  while (i < pairs_ && (seen_[i].a != a || seen_[i].b != b)) ++i;
  if (i == kMostPairs) return;
  if (i == pairs_) seen_[pairs_++] = {.a = a, .b = b, .first = now, .is_arms = is_arms};
  Seen& seen = seen_[i];
  const bool is_first_point = seen.last_look != looks_;
  const bool has_lasted = seen.last_look + 1 >= looks_ && seen.cycles > 0;
  if (is_first_point) {
    seen.force = 0;
    if (!has_lasted) {
      seen.since = now;
      seen.peak = 0;
    }
    seen.last_look = looks_;
    seen.last = now;
    std::copy_n(truth_.data().contact[contact].pos, 3, seen.p_W.begin());
    ++seen.cycles;
  }
  // The step before a contact's first cycle did not know of it.
  if (seen.since == now) return;
  seen.force += ForceOf(contact);
  seen.peak = std::max(seen.peak, seen.force);
}

double ContactWatch::ForceOf(int contact) const noexcept {
  const mjContact& one = truth_.data().contact[contact];
  if (one.exclude != 0 || one.efc_address < 0) return 0;
  mjtNum wrench[6];
  mj_contactForce(&truth_.model(), &truth_.data(), contact, wrench);
  return mju_norm3(wrench);
}

void ContactWatch::Keep(Time now) noexcept {
  if (moment_count_ == kMostMoments) return;
  KeptMoment& moment = moments_[moment_count_++];
  moment.at = now;
  for (std::size_t i = 0; i < pairs_ && moment.count < kMostOfMoment; ++i) {
    const Seen& seen = seen_[i];
    const std::uint64_t ago = looks_ - seen.last_look;
    if (ago > kRecentLooks) continue;
    moment.contacts[moment.count++] = {seen, ago != 0};
  }
}

std::vector<ContactMoment> ContactWatch::Moments() const {
  std::vector<ContactMoment> moments;
  for (std::size_t m = 0; m < moment_count_; ++m) {
    ContactMoment moment{.at = moments_[m].at, .contacts = {}};
    for (std::size_t i = 0; i < moments_[m].count; ++i) {
      const auto& [seen, has_ended] = moments_[m].contacts[i];
      moment.contacts.push_back({.a = names_.at(seen.a),
                                 .b = names_.at(seen.b),
                                 .p_W = seen.p_W,
                                 .force = seen.peak,
                                 .since = seen.since,
                                 .last = has_ended ? std::optional(seen.last) : std::nullopt});
    }
    std::ranges::stable_sort(moment.contacts, std::ranges::greater{}, &NearContact::force);
    moments.push_back(std::move(moment));
  }
  return moments;
}

std::string ContactMoment::Text() const {
  std::string text;
  for (const NearContact& one : contacts) {
    const auto seconds = [](Time time) { return ToSeconds(time.time_since_epoch()); };
    text += fmt::format("{}{} and {} at ({:.3f}, {:.3f}, {:.3f}) m{}, ", text.empty() ? "" : "; ",
                        one.a, one.b, one.p_W[0], one.p_W[1], one.p_W[2],
                        one.force > 0 ? fmt::format(" with up to {:.0f} N", one.force) : "");
    text += one.last ? fmt::format("from {:.3f} s until {:.3f} s", seconds(one.since),
                                   seconds(*one.last))
                     : fmt::format("since {:.3f} s", seconds(one.since));
  }
  return text.empty() ? "none" : text;
}

std::vector<ContactPair> ContactWatch::Pairs() const {
  std::vector<ContactPair> pairs;
  for (std::size_t i = 0; i < pairs_; ++i) {
    const Seen& seen = seen_[i];
    if (!seen.is_arms) continue;
    pairs.push_back({.a = names_.at(seen.a),
                     .b = names_.at(seen.b),
                     .first = seen.first,
                     .cycles = seen.cycles});
  }
  return pairs;
}

}  // namespace twin::plant
