#include "twin/plant/object_watch.h"

#include <cmath>
#include <utility>

#include <mujoco/mujoco.h>

#include "plant/part_names.h"
#include "twin/model/transform.h"

namespace twin::plant {
namespace {

constexpr const char* kHand = "panda_hand";
constexpr const char* kLeftFinger = "panda_leftfinger";
constexpr const char* kRightFinger = "panda_rightfinger";

bool IsFree(const mjModel& model, int body) {
  return model.body_jntnum[body] == 1 && model.jnt_type[model.body_jntadr[body]] == mjJNT_FREE;
}

Transform PoseOf(const mjData& data, int body) noexcept {
  Transform X = kIdentityTransform;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) X[4 * c + r] = data.xmat[9 * body + 3 * r + c];
    X[12 + r] = data.xpos[3 * body + r];
  }
  return X;
}

double Length(const mjtNum* v) noexcept {
  return std::hypot(v[0], v[1], v[2]);
}

}  // namespace

ObjectWatch::ObjectWatch(const TruthProbe& truth) : truth_(truth) {
  const mjModel& model = truth.model();
  ModelParts parts(model);
  part_of_geom_ = std::move(parts.of_geom);
  names_ = std::move(parts.names);
  const auto body_named = [&](const char* name) {
    return mj_name2id(&model, mjOBJ_BODY, (truth.prefix() + name).c_str());
  };
  hand_ = body_named(kHand);
  const int root = RobotRoot(model, truth.prefix());
  const int left = body_named(kLeftFinger);
  const int right = body_named(kRightFinger);
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const int body = model.geom_bodyid[geom];
    Kind kind = model.body_rootid[body] == root ? Kind::kRobot : Kind::kWorld;
    if (body == left && left >= 0) kind = Kind::kLeftFinger;
    if (body == right && right >= 0) kind = Kind::kRightFinger;
    kind_of_geom_.push_back(kind);
  }
  watched_of_body_.assign(model.nbody, -1);
  for (int body = 1; body < model.nbody && watched_.size() < kMostBodies; ++body) {
    if (!IsFree(model, body) || body == root) continue;
    watched_of_body_[body] = static_cast<int>(watched_.size());
    watched_.emplace_back().body = body;
    watched_.back().samples.reserve(kMostSamples);
    watched_.back().changes.reserve(kMostChanges);
  }
}

void ObjectWatch::Look(Time now) noexcept {
  if (watched_.empty()) return;
  const mjModel& model = truth_.model();
  const mjData& data = truth_.data();
  std::array<Support, kMostBodies> before{};
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    before[i] = std::exchange(watched_[i].now, Support());
  }
  for (int i = 0; i < data.ncon; ++i) {
    const int a = data.contact[i].geom1;
    const int b = data.contact[i].geom2;
    const int watched_a = watched_of_body_[model.body_rootid[model.geom_bodyid[a]]];
    const int watched_b = watched_of_body_[model.body_rootid[model.geom_bodyid[b]]];
    if (watched_a >= 0) Note(watched_[watched_a], b, now);
    if (watched_b >= 0) Note(watched_[watched_b], a, now);
  }
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    Watched& watched = watched_[i];
    Sample(watched, now);
    if (looks_ > 0 && watched.now == before[i]) continue;
    if (watched.changes.size() < kMostChanges) {
      watched.changes.push_back({now, watched.now});
    } else {
      ++watched.missed_changes;
    }
  }
  ++looks_;
}

void ObjectWatch::Note(Watched& watched, int geom, Time now) noexcept {
  switch (kind_of_geom_[geom]) {
    case Kind::kLeftFinger: watched.now.left_finger = true; return;
    case Kind::kRightFinger: watched.now.right_finger = true; return;
    case Kind::kRobot: watched.now.robot = true; return;
    case Kind::kWorld: watched.now.world = true; break;
  }
  const int id = part_of_geom_[geom];
  std::size_t i = 0;
  while (i < watched.part_count && watched.parts[i].id != id) ++i;
  if (i == kMostParts) return;
  if (i == watched.part_count) watched.parts[watched.part_count++] = {.id = id, .first = now};
  watched.parts[i].last = now;
}

void ObjectWatch::Sample(Watched& watched, Time now) noexcept {
  const mjModel& model = truth_.model();
  const mjData& data = truth_.data();
  ObjectSample& sample = watched.last;
  sample.at = now;
  sample.X_WB = PoseOf(data, watched.body);
  sample.X_HB =
      hand_ < 0 ? sample.X_WB : model::Multiply(model::Inverse(PoseOf(data, hand_)), sample.X_WB);
  // A free body's velocity: of its frame's origin in the world, then its rotation in its own axes.
  const mjtNum* dq = data.qvel + model.body_dofadr[watched.body];
  sample.speed = Length(dq);
  sample.turn_rate = Length(dq + 3);
  if (looks_ % kSampleLooks == 0 && watched.samples.size() < kMostSamples) {
    watched.samples.push_back(sample);
  }
}

std::vector<ObjectTrack> ObjectWatch::Tracks() const {
  std::vector<ObjectTrack> tracks;
  for (const Watched& watched : watched_) {
    ObjectTrack track{.body = names_.at(watched.body),
                      .samples = watched.samples,
                      .last = watched.last,
                      .changes = watched.changes,
                      .touched = {},
                      .missed_changes = watched.missed_changes};
    for (std::size_t i = 0; i < watched.part_count; ++i) {
      const Part& part = watched.parts[i];
      track.touched.push_back({names_.at(part.id), part.first, part.last});
    }
    tracks.push_back(std::move(track));
  }
  return tracks;
}

}  // namespace twin::plant
