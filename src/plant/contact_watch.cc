#include "twin/plant/contact_watch.h"

#include <utility>

#include <mujoco/mujoco.h>

#include "plant/part_names.h"

namespace twin::plant {

ContactWatch::ContactWatch(const TruthProbe& truth) : truth_(truth), objects_(truth) {
  const mjModel& model = truth.model();
  ModelParts parts(model);
  part_of_geom_ = std::move(parts.of_geom);
  names_ = std::move(parts.names);
  const std::vector<bool> moves = MovingBodies(model);
  for (int geom = 0; geom < model.ngeom; ++geom) moves_.push_back(moves[model.geom_bodyid[geom]]);
}

void ContactWatch::Look(Time now) noexcept {
  ++looks_;
  objects_.Look(now);
  bool touches = false;
  const mjData& data = truth_.data();
  for (int i = 0; i < data.ncon; ++i) {
    int a = data.contact[i].geom1;
    int b = data.contact[i].geom2;
    if (!moves_[a]) std::swap(a, b);
    if (!moves_[a]) continue;
    touches = true;
    Note(part_of_geom_[a], part_of_geom_[b], now);
  }
  if (touches) ++cycles_;
}

void ContactWatch::Note(int a, int b, Time now) noexcept {
  std::size_t i = 0;
  while (i < pairs_ && (seen_[i].a != a || seen_[i].b != b)) ++i;
  if (i == kMostPairs) return;
  if (i == pairs_) seen_[pairs_++] = {.a = a, .b = b, .first = now};
  Seen& seen = seen_[i];
  if (seen.last_look == looks_) return;  // another contact point of the same pair
  seen.last_look = looks_;
  ++seen.cycles;
}

std::vector<ContactPair> ContactWatch::Pairs() const {
  std::vector<ContactPair> pairs;
  for (std::size_t i = 0; i < pairs_; ++i) {
    const Seen& seen = seen_[i];
    pairs.push_back({.a = names_.at(seen.a),
                     .b = names_.at(seen.b),
                     .first = seen.first,
                     .cycles = seen.cycles});
  }
  return pairs;
}

}  // namespace twin::plant
