#include "twin/planning/collision_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "planning/parts.h"
#include "planning/shape_pairs.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"
#include "twin/model/self_collision.h"
#include "twin/model/transform.h"
#include "twin/plant/compiled_model.h"
#include "twin/plant/observers.h"

namespace twin::planning {
namespace {

struct DataDeleter {
  void operator()(mjData* data) const noexcept { mj_deleteData(data); }
};

/// Flange in the frame of joint 7.
Transform FlangeInLink7() {
  const model::ArmModel& arm = model::ArmModel::Panda();
  const model::Configuration zero{JointVector{}};
  return model::Multiply(model::Inverse(arm.Pose(model::Frame::kJoint7, zero)),
                         arm.Pose(model::Frame::kFlange, zero));
}

Transform BodyPose(const mjData& data, int body) {
  Transform X = kIdentityTransform;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) X[4 * c + r] = data.xmat[9 * body + 3 * r + c];
    X[12 + r] = data.xpos[3 * body + r];
  }
  return X;
}

void RequirePose(const std::string& body, const Transform& X) {
  bool sound = true;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      double product = 0;
      for (std::size_t r = 0; r < 3; ++r) product += X[4 * i + r] * X[4 * j + r];
      sound = sound && std::abs(product - (i == j ? 1 : 0)) <= 1e-6;
    }
    sound = sound && std::isfinite(X[12 + i]);
  }
  if (sound) return;
  throw InputError(fmt::format(
      "planning: the pose of '{}' is none: its axes must be of length 1 and at right angles, its "
      "position finite",
      body));
}

}  // namespace

std::string Describe(const std::vector<Touch>& touches) {
  std::string text;
  for (const Touch& touch : touches) {
    if (!text.empty()) text += "; ";
    if (touch.is_limit) {
      text += touch.distance < 0 ? fmt::format("the {} is {:.1f} mm beyond the limit \"{}\"",
                                               touch.a, -touch.distance * 1e3, touch.b)
                                 : fmt::format("the {} is {:.1f} mm from the limit \"{}\"", touch.a,
                                               touch.distance * 1e3, touch.b);
      continue;
    }
    text += touch.distance < 0 ? fmt::format("{} and {} overlap", touch.a, touch.b)
                               : fmt::format("{} and {} are {:.1f} mm apart", touch.a, touch.b,
                                             touch.distance * 1e3);
  }
  return text;
}

struct CollisionWorld::Parts {
  Parts(std::span<const plant::MujocoPlantOptions> arms, std::size_t own)
      : all(plant::CompileModels(arms)),
        compiled(all[own]),
        model(*compiled.model),
        data(mj_makeData(&model)),
        names(model),
        joints_before(JointsBefore(compiled)),
        contacts(mjMAXCONPAIR) {
    for (std::size_t i = 0; i < kJoints; ++i) qpos[i] = model.jnt_qposadr[compiled.arm[i]];
    link7 = model.jnt_bodyid[compiled.arm.back()];
    SetWidth(kOpen);
    ChangeWhatIsThere();
  }

  static constexpr double kOpen = 0.08;   ///< m
  static constexpr double kClose = 0.06;  ///< m; gradients of shorter distances are differences
  static constexpr double kStep = 1e-4;   ///< rad, of the differences
  /// A body at the flange.
  struct Held {
    int body = -1;
    int qpos = -1;
    Transform F_T_B{};
    std::array<double, 7> placed{};  ///< its qpos before the attachment
  };

  void SetWidth(double width) { SetWidth(compiled, width); }
  void SetWidth(const plant::CompiledModel& arm, double width) {
    for (const int finger : arm.fingers) data->qpos[model.jnt_qposadr[finger]] = width / 2;
  }

  void SetFreeJoint(int address, const Transform& X_WB) {
    const Eigen::Quaterniond turn = model::Orientation(X_WB);
    const std::array<double, 7> pose{X_WB[12], X_WB[13], X_WB[14], turn.w(),
                                     turn.x(), turn.y(), turn.z()};
    std::copy(pose.begin(), pose.end(), data->qpos + address);
  }

  /// Poses every shape at q.
  void Pose(const JointVector& q) {
    for (std::size_t i = 0; i < kJoints; ++i) data->qpos[qpos[i]] = q[i];
    mj_kinematics(&model, data.get());
    if (held.body < 0) return;
    const Transform X_WF = model::Multiply(BodyPose(*data, link7), link7_T_F);
    SetFreeJoint(held.qpos, model::Multiply(X_WF, held.F_T_B));
    mj_kinematics(&model, data.get());
  }

  [[nodiscard]] bool IsHeld(int body) const {
    return held.body >= 0 && model.body_rootid[body] == held.body;
  }
  [[nodiscard]] bool IsFinger(int body) const {
    return std::any_of(compiled.fingers.begin(), compiled.fingers.end(),
                       [&](int joint) { return model.jnt_bodyid[joint] == body; });
  }
  [[nodiscard]] bool Moves(int geom) const {
    const int body = model.geom_bodyid[geom];
    return joints_before[body] > 0 || IsHeld(body);
  }
  /// True if contact between these shapes counts.
  [[nodiscard]] bool Matters(int a, int b) const {
    if (!Moves(a) && !Moves(b)) return false;
    const int body_a = model.geom_bodyid[a];
    const int body_b = model.geom_bodyid[b];
    if ((IsHeld(body_a) && (IsHeld(body_b) || IsFinger(body_b))) ||
        (IsHeld(body_b) && IsFinger(body_a))) {
      return false;
    }
    return !allowed.contains(std::minmax(names.OfShape(a), names.OfShape(b)));
  }

  /// Distance of the arm from the robot's self-stop, m; nullopt if it is at least the clearance.
  [[nodiscard]] std::optional<double> NearGuard(const JointVector& q,
                                                double clearance) const noexcept {
    if (!self_guard) return std::nullopt;
    const double wanted = *self_guard + clearance;
    const double distance = model::SelfDistance(q, !compiled.fingers.empty(), wanted);
    if (distance >= wanted) return std::nullopt;
    return distance - *self_guard;
  }

  /// The part closest to a limit, or farthest beyond; nullopt if its margin is at least the
  /// clearance.
  [[nodiscard]] std::optional<model::RegionMargin> NearLimit(const JointVector& q,
                                                             double clearance) const noexcept {
    const auto least = model::LeastMargin(limits, limited_arm, q);
    return least && least->margin < clearance ? least : std::nullopt;
  }

  /// To the world, or to a mobile base.
  [[nodiscard]] bool IsFixed(int geom) const {
    const int body = model.geom_bodyid[geom];
    if (model.body_weldid[body] == 0) return true;
    return compiled.base >= 0 && joints_before[body] == 0 &&
           model.body_rootid[body] == model.body_rootid[model.jnt_bodyid[compiled.base]];
  }

  /// Derivative of the distance at a contact by the joints that carry one of its shapes.
  /// @param away  unit vector, from the other shape to this one.
  [[nodiscard]] JointVector GradientOf(const mjtNum* point, const Eigen::Vector3d& away,
                                       int geom) const {
    JointVector gradient{};
    const Eigen::Map<const Eigen::Vector3d> p(point);
    const int joints = joints_before[model.geom_bodyid[geom]];
    for (int i = 0; i < joints; ++i) {
      const Eigen::Map<const Eigen::Vector3d> axis(data->xaxis + 3 * compiled.arm[i]);
      const Eigen::Map<const Eigen::Vector3d> anchor(data->xanchor + 3 * compiled.arm[i]);
      gradient[i] = away.dot(axis.cross(p - anchor));
    }
    return gradient;
  }

  /// Rebuilds the pairs and the reach. Starts at the hand, which collides most often.
  void ChangeWhatIsThere() {
    pairs.clear();
    for (int a = model.ngeom; a-- > 0;) {
      for (int b = a; b-- > 0;) {
        if (Matters(a, b) && CanCollide(model, a, b)) pairs.push_back(MakePair(model, a, b));
      }
    }
    for (int i = 0; i < model.npair; ++i) {  // pairs that the scene lists explicitly
      const int a = model.pair_geom1[i];
      const int b = model.pair_geom2[i];
      if (!Matters(a, b)) continue;
      pairs.push_back(MakePair(model, a, b));
      pairs.back().margin = model.pair_margin[i];
    }
    std::array<double, 2> width{};
    for (std::size_t i = 0; i < compiled.fingers.size() && i < width.size(); ++i) {
      width[i] = data->qpos[model.jnt_qposadr[compiled.fingers[i]]];
    }
    SetWidth(kOpen);  // the largest reach of the fingers
    Pose(JointVector{});
    reach = ReachOf(compiled, *data, joints_before, held.body);
    if (!compiled.fingers.empty()) SetWidth(width[0] + width[1]);
  }

  /// The deepest contact of shapes closer than `horizon`, null if they are farther apart. Valid
  /// until the next search.
  const mjContact* Deepest(const ShapePair& pair, double horizon) noexcept {
    if (!MayTouch(model, *data, pair.geom1, pair.geom2, horizon)) return nullptr;
    const int found = NarrowPhase(model, *data, pair, horizon, contacts);
    if (found == 0) return nullptr;
    return &*std::min_element(
        contacts.begin(), contacts.begin() + found,
        [](const mjContact& a, const mjContact& b) { return a.dist < b.dist; });
  }

  /// Replaces gradients of short distances by differences of the distances: MuJoCo's contact normal
  /// of two convex shapes apart may point elsewhere than the distance grows.
  void DifferentiateClose(const JointVector& q, double horizon, std::span<Clearance> near,
                          std::span<const ShapePair* const> pair_of) noexcept {
    const auto is_close = [](const Clearance& c) { return c.distance < kClose; };
    if (std::ranges::none_of(near, is_close)) return;
    for (std::size_t i = 0; i < kJoints; ++i) {
      JointVector there = q;
      there[i] += kStep;
      Pose(there);
      for (std::size_t k = 0; k < near.size(); ++k) {
        const mjContact* moved = is_close(near[k]) ? Deepest(*pair_of[k], horizon) : nullptr;
        if (moved == nullptr) continue;
        const double slope = (moved->dist - near[k].distance) / kStep;
        if (std::abs(slope) <= reach[i]) near[k].gradient[i] = slope;  // else the distance jumps
      }
    }
  }

  const std::vector<plant::CompiledModel> all;  ///< the arms
  const plant::CompiledModel& compiled;         ///< the one that moves
  const mjModel& model;
  std::unique_ptr<mjData, DataDeleter> data;
  const PartNames names;
  const std::vector<int> joints_before;
  std::array<int, kJoints> qpos{};
  int link7 = -1;
  const Transform link7_T_F = FlangeInLink7();
  Held held;
  std::optional<double> self_guard = kSelfGuard;
  model::LabLimits limits;
  model::LimitedArm limited_arm;
  std::set<std::pair<int, int>> allowed;
  std::vector<ShapePair> pairs;
  Contacts contacts;
  JointVector reach{};
  std::uint64_t checks = 0;
};

CollisionWorld::CollisionWorld(const plant::MujocoPlantOptions& options)
    : CollisionWorld({&options, 1}, 0) {}

CollisionWorld::CollisionWorld(std::span<const plant::MujocoPlantOptions> arms, std::size_t own)
    : parts_(std::make_unique<Parts>(arms, own)) {}

CollisionWorld::~CollisionWorld() = default;

void CollisionWorld::SetHandWidth(double width) {
  RequireInRange("planning: hand width", width, 0, Parts::kOpen);
  parts_->SetWidth(width);
}

void CollisionWorld::SetSelfGuard(std::optional<double> distance) {
  if (distance) RequireInRange("planning: distance of the self-collision guard", *distance, 0, 1);
  parts_->self_guard = distance;
}

void CollisionWorld::SetLimits(const model::LabLimits& limits, const model::LimitedArm& arm) {
  parts_->limits = limits;
  parts_->limited_arm = arm;
}

const model::LabLimits& CollisionWorld::limits() const noexcept {
  return parts_->limits;
}

const model::LimitedArm& CollisionWorld::limited_arm() const noexcept {
  return parts_->limited_arm;
}

void CollisionWorld::Place(const std::string& body, const Transform& X_WB) {
  RequirePose(body, X_WB);
  const int joint = FreeJointOf(parts_->model, body);
  const int address = parts_->model.jnt_qposadr[joint];
  parts_->SetFreeJoint(address, X_WB);
  if (parts_->held.qpos == address) {
    std::copy_n(parts_->data->qpos + address, 7, parts_->held.placed.begin());
  }
}

void CollisionWorld::PlaceArm(std::size_t arm, const JointVector& q, double width) {
  RequireInRange("planning: hand width of another arm", width, 0, Parts::kOpen);
  const plant::CompiledModel& other = parts_->all.at(arm);
  for (std::size_t i = 0; i < kJoints; ++i) {
    parts_->data->qpos[parts_->model.jnt_qposadr[other.arm[i]]] = q[i];
  }
  parts_->SetWidth(other, width);
}

void CollisionWorld::ArrangeAs(const mjModel_& model, std::span<const double> qpos) {
  const auto arrange = [&](int joint) {
    const int there =
        mj_name2id(&model, mjOBJ_JOINT, mj_id2name(&parts_->model, mjOBJ_JOINT, joint));
    if (there < 0) return;
    parts_->data->qpos[parts_->model.jnt_qposadr[joint]] = qpos[model.jnt_qposadr[there]];
  };
  for (const plant::CompiledModel& arm : parts_->all) {
    if (&arm == &parts_->compiled) continue;
    std::ranges::for_each(arm.arm, arrange);
    std::ranges::for_each(arm.fingers, arrange);
  }
  for (const auto& [name, X_WB] : plant::FreeBodies(model, qpos)) Place(name, X_WB);
}

void CollisionWorld::Attach(const std::string& body, const Transform& F_T_B) {
  RequirePose(body, F_T_B);
  const int joint = FreeJointOf(parts_->model, body);
  Detach();
  Parts::Held& held = parts_->held;
  held.body = parts_->model.jnt_bodyid[joint];
  held.qpos = parts_->model.jnt_qposadr[joint];
  held.F_T_B = F_T_B;
  std::copy_n(parts_->data->qpos + held.qpos, 7, held.placed.begin());
  parts_->ChangeWhatIsThere();
}

void CollisionWorld::Detach() {
  Parts::Held& held = parts_->held;
  if (held.body < 0) return;
  std::copy(held.placed.begin(), held.placed.end(), parts_->data->qpos + held.qpos);
  held = {};
  parts_->ChangeWhatIsThere();
}

void CollisionWorld::Allow(const std::string& a, const std::string& b) {
  parts_->allowed.insert(std::minmax(parts_->names.Find(a), parts_->names.Find(b)));
  parts_->ChangeWhatIsThere();
}

void CollisionWorld::ForbidAll() {
  parts_->allowed.clear();
  parts_->ChangeWhatIsThere();
}

bool CollisionWorld::IsFree(const JointVector& q, double clearance) {
  ++parts_->checks;
  if (parts_->NearLimit(q, clearance)) return false;
  parts_->Pose(q);
  if (parts_->NearGuard(q, clearance)) return false;
  const mjModel& model = parts_->model;
  const mjData& data = *parts_->data;
  return std::none_of(parts_->pairs.begin(), parts_->pairs.end(), [&](const ShapePair& pair) {
    const double margin = std::max(pair.margin, clearance);
    return MayTouch(model, data, pair.geom1, pair.geom2, margin) &&
           NarrowPhase(model, data, pair, margin, parts_->contacts) > 0;
  });
}

std::vector<Touch> CollisionWorld::Touches(const JointVector& q, double clearance) {
  ++parts_->checks;
  parts_->Pose(q);
  std::vector<Touch> touches;
  if (const auto distance = parts_->NearGuard(q, clearance)) {
    touches.push_back({kGuardedArm, kGuardedArmItself, *distance});
  }
  if (const auto limit = parts_->NearLimit(q, clearance)) {
    touches.push_back({model::Name(limit->part), parts_->limits.regions[limit->region].name,
                       limit->margin, true});
  }
  for (const ShapePair& pair : parts_->pairs) {
    const double margin = std::max(pair.margin, clearance);
    if (!MayTouch(parts_->model, *parts_->data, pair.geom1, pair.geom2, margin)) continue;
    const int count = NarrowPhase(parts_->model, *parts_->data, pair, margin, parts_->contacts);
    if (count == 0) continue;
    const bool first_moves = parts_->Moves(pair.geom1);
    const auto name = [&](int geom) -> std::string_view {
      return parts_->names.NameOf(parts_->names.OfShape(geom));
    };
    Touch touch{name(first_moves ? pair.geom1 : pair.geom2),
                name(first_moves ? pair.geom2 : pair.geom1), parts_->contacts[0].dist};
    for (int i = 1; i < count; ++i) {
      touch.distance = std::min(touch.distance, parts_->contacts[i].dist);
    }
    const auto same = std::find_if(touches.begin(), touches.end(), [&](const Touch& other) {
      return std::minmax(other.a, other.b) == std::minmax(touch.a, touch.b);
    });
    if (same == touches.end()) {
      touches.push_back(touch);
    } else {
      same->distance = std::min(same->distance, touch.distance);
    }
  }
  std::stable_sort(touches.begin(), touches.end(),
                   [](const Touch& a, const Touch& b) { return a.distance < b.distance; });
  return touches;
}

void CollisionWorld::MoveBase(const BasePose& from_start) noexcept {
  Parts& p = *parts_;
  if (p.compiled.base < 0) return;
  const int at = p.model.jnt_qposadr[p.compiled.base];
  std::copy_n(p.model.qpos0 + at, 7, p.data->qpos + at);
  plant::MoveBase(p.compiled, from_start, {p.data->qpos, static_cast<std::size_t>(p.model.nq)});
}

std::size_t CollisionWorld::NearFixed(const JointVector& q, double horizon,
                                      std::span<Clearance> near) noexcept {
  Parts& p = *parts_;
  ++p.checks;
  p.Pose(q);
  std::array<const ShapePair*, kMostNear> pair_of{};
  const std::size_t most = std::min(near.size(), kMostNear);
  std::size_t count = 0;
  for (const ShapePair& pair : p.pairs) {
    const bool first_is_fixed = p.IsFixed(pair.geom1);
    if (first_is_fixed == p.IsFixed(pair.geom2)) continue;
    const mjContact* deepest = p.Deepest(pair, horizon);
    if (deepest == nullptr) continue;
    if (count < most) near[count++].distance = std::numeric_limits<double>::infinity();
    const auto farthest = std::max_element(
        near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count),
        [](const Clearance& a, const Clearance& b) { return a.distance < b.distance; });
    if (count == 0 || farthest->distance <= deepest->dist) continue;
    const Eigen::Map<const Eigen::Vector3d> normal(deepest->frame);  // from geom1 to geom2
    const double side = first_is_fixed ? 1 : -1;
    *farthest = {deepest->dist, p.GradientOf(deepest->pos, side * normal,
                                             first_is_fixed ? pair.geom2 : pair.geom1)};
    pair_of[static_cast<std::size_t>(farthest - near.begin())] = &pair;
  }
  p.DifferentiateClose(q, horizon, near.first(count), pair_of);
  return count;
}

std::uint64_t CollisionWorld::checks() const noexcept {
  return parts_->checks;
}

double CollisionWorld::Travel(const JointVector& a, const JointVector& b) const noexcept {
  double travel = 0;
  for (std::size_t i = 0; i < kJoints; ++i) travel += parts_->reach[i] * std::abs(a[i] - b[i]);
  return travel;
}

const JointVector& CollisionWorld::reach() const noexcept {
  return parts_->reach;
}

Transform CollisionWorld::PoseOf(const std::string& body) const {
  const int id = mj_name2id(&parts_->model, mjOBJ_BODY, body.c_str());
  if (id >= 0) return BodyPose(*parts_->data, id);
  throw InputError(fmt::format("planning: the model has no body '{}'", body));
}

}  // namespace twin::planning
