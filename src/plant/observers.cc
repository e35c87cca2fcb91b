#include "twin/plant/observers.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "plant/part_names.h"
#include "twin/core/error.h"

namespace twin::plant {

int BodyNamed(const mjModel& model, const std::string& name) {
  const int body = mj_name2id(&model, mjOBJ_BODY, name.c_str());
  if (body >= 0) return body;
  throw InputError(fmt::format("no body of robot and scene is named \"{}\"; name one", name));
}

BodyView::BodyView(const TruthProbe& truth, const std::string& body)
    : truth_(truth), body_(BodyNamed(truth.model(), body)) {}

Vector6 BodyView::Twist() const noexcept {
  mjtNum turn_first[6];
  mj_objectVelocity(&truth_.model(), &truth_.data(), mjOBJ_XBODY, body_, turn_first, 0);
  return {turn_first[3], turn_first[4], turn_first[5], turn_first[0], turn_first[1], turn_first[2]};
}

ContactWrench::ContactWrench(const TruthProbe& truth) : truth_(truth) {
  const mjModel& model = truth.model();
  const std::vector<bool> moves = MovingBodies(model, truth.prefix());
  for (int geom = 0; geom < model.ngeom; ++geom) moves_.push_back(moves[model.geom_bodyid[geom]]);
}

Vector6 ContactWrench::About(const Vector3& p_W) const noexcept {
  Vector6 wrench{};
  const mjData& data = truth_.data();
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    const bool is_first = moves_[contact.geom1];
    if (contact.efc_address < 0 || is_first == moves_[contact.geom2]) continue;
    mjtNum force_C[6];  // on the second shape, in the contact's axes, the rows of its frame
    mj_contactForce(&truth_.model(), &data, i, force_C);
    mjtNum force_W[3];
    mjtNum torque_W[3];
    mju_mulMatTVec(force_W, contact.frame, force_C, 3, 3);
    mju_mulMatTVec(torque_W, contact.frame, force_C + 3, 3, 3);
    mjtNum arm[3];
    mjtNum moment[3];
    mju_sub3(arm, contact.pos, p_W.data());
    mju_cross(moment, arm, force_W);
    const double sign = is_first ? 1 : -1;
    for (std::size_t k = 0; k < 3; ++k) {
      wrench[k] += sign * force_W[k];
      wrench[3 + k] += sign * (moment[k] + torque_W[k]);
    }
  }
  return wrench;
}

Transform BodyView::Pose() const noexcept {
  const mjData& data = truth_.data();
  Transform X = kIdentityTransform;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) X[4 * c + r] = data.xmat[9 * body_ + 3 * r + c];
    X[12 + r] = data.xpos[3 * body_ + r];
  }
  return X;
}

namespace {

/// The scene's free bodies, with their names.
std::vector<std::pair<int, std::string>> NamedFreeBodies(const mjModel& model) {
  std::vector<std::pair<int, std::string>> bodies;
  const int robot = RobotRoot(model);
  for (int body = 1; body < model.nbody; ++body) {
    const bool is_free =
        model.body_jntnum[body] == 1 && model.jnt_type[model.body_jntadr[body]] == mjJNT_FREE;
    if (body == robot || !is_free) continue;
    const char* const name = mj_id2name(&model, mjOBJ_BODY, body);
    const bool is_named = name != nullptr && *name != '\0';
    bodies.emplace_back(body, is_named ? name : fmt::format("body {}", body));
  }
  return bodies;
}

}  // namespace

std::vector<std::pair<std::string, Transform>> FreeBodies(const mjModel& model,
                                                          std::span<const double> qpos) {
  std::vector<std::pair<std::string, Transform>> bodies;
  for (auto& [body, name] : NamedFreeBodies(model)) {
    const double* const q = qpos.data() + model.jnt_qposadr[model.body_jntadr[body]];
    mjtNum rotation[9];
    mju_quat2Mat(rotation, q + 3);
    Transform X = kIdentityTransform;
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) X[4 * c + r] = rotation[3 * r + c];
      X[12 + r] = q[r];
    }
    bodies.emplace_back(std::move(name), X);
  }
  return bodies;
}

std::vector<std::pair<std::string, Transform>> FreeBodies(const TruthProbe& truth) {
  return FreeBodies(truth.model(), PositionsOf(truth));
}

std::span<const double> PositionsOf(const TruthProbe& truth) {
  return {truth.data().qpos, static_cast<std::size_t>(truth.model().nq)};
}

int FreeBodyNamed(const mjModel& model, const std::string& name) {
  std::string names;
  for (const auto& [body, its_name] : NamedFreeBodies(model)) {
    if (its_name == name) return body;
    names += (names.empty() ? "" : ", ") + its_name;
  }
  const bool exists = mj_name2id(&model, mjOBJ_BODY, name.c_str()) >= 0 ||
                      mj_name2id(&model, mjOBJ_GEOM, name.c_str()) >= 0;
  throw InputError(fmt::format(
      "{} \"{}\"{}; {}", exists ? "the object" : "there is no object", name,
      exists ? " does not move freely" : "",
      names.empty() ? "this scene has none that does" : "those that move freely: " + names));
}

std::string PartOfShape(const mjModel& model, int geom) {
  const ModelParts parts(model);
  return parts.names.at(parts.of_geom.at(static_cast<std::size_t>(geom)));
}

std::string DescribeOverlap(const mjModel& model, const std::string& body, const Overlap& overlap) {
  // The engine gives half of the depth between two boxes.
  return fmt::format(
      "place: there \"{}\" would lie at least {:.1f} mm deep in {}; {:.0f} mm at most is a touch",
      body, 1e3 * overlap.depth, PartOfShape(model, overlap.geom), 1e3 * Plant::kMostOverlap);
}

namespace {

/// Force of a contact on its second geom's body, world axes.
Vector3 ForceOf(const mjModel& model, const mjData& data, int contact) noexcept {
  mjtNum wrench[6];
  mj_contactForce(&model, &data, contact, wrench);
  Vector3 force{};
  mju_mulMatTVec(force.data(), data.contact[contact].frame, wrench, 3, 3);
  return force;
}

void CaptureContacts(const mjModel& model, const mjData& data,
                     record::SceneRecord& scene) noexcept {
  scene.contacts = 0;
  for (int i = 0; i < data.ncon && scene.contacts < record::SceneRecord::kMostContacts; ++i) {
    const mjContact& contact = data.contact[i];
    if (contact.exclude != 0 || contact.efc_address < 0) continue;
    record::PointForce& mark = scene.contact[scene.contacts];
    std::copy_n(contact.pos, 3, mark.p_W.begin());
    mark.force_W = ForceOf(model, data, i);
    if (model.geom_bodyid[contact.geom1] > model.geom_bodyid[contact.geom2]) {
      mju_scl3(mark.force_W.data(), mark.force_W.data(), -1);
    }
    ++scene.contacts;
  }
}

/// The point p = c + (f x m) / f^2 on the force's line, nearest to the centre of mass c.
void CapturePushes(const mjModel& model, const mjData& data, record::SceneRecord& scene) noexcept {
  constexpr mjtNum kLeast = 1e-6;  // N
  scene.pushes = 0;
  for (int body = 1; body < model.nbody && scene.pushes < record::SceneRecord::kMostPushes;
       ++body) {
    const mjtNum* const force = data.xfrc_applied + std::ptrdiff_t{6} * body;
    const mjtNum square = mju_dot3(force, force);
    if (square < kLeast * kLeast) continue;
    record::PointForce& mark = scene.push[scene.pushes++];
    std::copy_n(force, 3, mark.force_W.begin());
    mju_cross(mark.p_W.data(), force, force + 3);
    mju_scl3(mark.p_W.data(), mark.p_W.data(), 1 / square);
    mju_addTo3(mark.p_W.data(), data.xipos + std::ptrdiff_t{3} * body);
  }
}

}  // namespace

std::optional<ArmOverlap> DeepestOverlap(const mjModel& model, const mjData& data,
                                         const std::vector<bool>& moves) {
  const mjContact* deepest = nullptr;
  for (const mjContact& contact : std::span(data.contact, static_cast<std::size_t>(data.ncon))) {
    if (!moves[model.geom_bodyid[contact.geom1]] && !moves[model.geom_bodyid[contact.geom2]])
      continue;
    if (deepest == nullptr || contact.dist < deepest->dist) deepest = &contact;
  }
  if (deepest == nullptr) return {};
  const bool is_first = moves[model.geom_bodyid[deepest->geom1]];
  return ArmOverlap{.part = PartOfShape(model, is_first ? deepest->geom1 : deepest->geom2),
                    .other = PartOfShape(model, is_first ? deepest->geom2 : deepest->geom1),
                    .depth = -deepest->dist};
}

std::optional<ArmOverlap> ArmOverlapAt(const mjModel& model, const JointVector& q) {
  const int root = RobotRoot(model);
  if (root < 0 || model.body_jntnum[root] > 0) return {};
  const std::vector<bool> moves = MovingBodies(model);
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(&model), &mj_deleteData);
  if (data == nullptr) return {};
  std::size_t next = 0;
  for (int joint = 0; joint < model.njnt && next < kJoints; ++joint) {
    const bool is_arms = moves[model.jnt_bodyid[joint]] && model.jnt_type[joint] == mjJNT_HINGE;
    if (is_arms) data->qpos[model.jnt_qposadr[joint]] = q[next++];
  }
  mj_kinematics(&model, data.get());
  mj_comPos(&model, data.get());
  mj_collision(&model, data.get());
  return DeepestOverlap(model, *data, moves);
}

void RequireShallow(const std::optional<ArmOverlap>& overlap, std::string_view what) {
  if (!overlap || overlap->depth <= Plant::kMostOverlap) return;
  throw InputError(fmt::format(
      "{}: there {} would lie at least {:.1f} mm deep in {}; {:.0f} mm at most is a touch", what,
      overlap->part, 1e3 * overlap->depth, overlap->other, 1e3 * Plant::kMostOverlap));
}

void RequireFreeStart(const TruthProbe& truth) {
  if (!truth.prefix().empty()) return;
  RequireShallow(DeepestOverlap(truth.model(), truth.data(), MovingBodies(truth.model())),
                 "the start");
}

void CaptureScene(Time now, const TruthProbe& truth, record::SceneRecord& scene) noexcept {
  scene.at = now;
  scene.positions = static_cast<std::uint32_t>(truth.qpos_size());
  truth.CopyQpos(std::span(scene.qpos).first(scene.positions));
  CaptureContacts(truth.model(), truth.data(), scene);
  CapturePushes(truth.model(), truth.data(), scene);
}

}  // namespace twin::plant
