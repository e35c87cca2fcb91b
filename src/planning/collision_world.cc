#include "twin/planning/collision_world.h"

#include <algorithm>
#include <array>
#include <cmath>
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
    text += touch.distance < 0 ? fmt::format("{} and {} overlap", touch.a, touch.b)
                               : fmt::format("{} and {} are {:.1f} mm apart", touch.a, touch.b,
                                             touch.distance * 1e3);
  }
  return text;
}

struct CollisionWorld::Parts {
  explicit Parts(const plant::MujocoPlantOptions& options)
      : compiled(plant::CompileModel(options)),
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

  static constexpr double kOpen = 0.08;  ///< m
  /// A body at the flange.
  struct Held {
    int body = -1;
    int qpos = -1;
    Transform F_T_B{};
    std::array<double, 7> placed{};  ///< its qpos before the attachment
  };

  void SetWidth(double width) {
    for (const int finger : compiled.fingers) {
      data->qpos[model.jnt_qposadr[finger]] = width / 2;
    }
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

  plant::CompiledModel compiled;
  const mjModel& model;
  std::unique_ptr<mjData, DataDeleter> data;
  const PartNames names;
  const std::vector<int> joints_before;
  std::array<int, kJoints> qpos{};
  int link7 = -1;
  const Transform link7_T_F = FlangeInLink7();
  Held held;
  std::optional<double> self_guard = kSelfGuard;
  std::set<std::pair<int, int>> allowed;
  std::vector<ShapePair> pairs;
  Contacts contacts;
  JointVector reach{};
  std::uint64_t checks = 0;
};

CollisionWorld::CollisionWorld(const plant::MujocoPlantOptions& options)
    : parts_(std::make_unique<Parts>(options)) {}

CollisionWorld::~CollisionWorld() = default;

void CollisionWorld::SetHandWidth(double width) {
  RequireInRange("planning: hand width", width, 0, Parts::kOpen);
  parts_->SetWidth(width);
}

void CollisionWorld::SetSelfGuard(std::optional<double> distance) {
  if (distance) RequireInRange("planning: distance of the self-collision guard", *distance, 0, 1);
  parts_->self_guard = distance;
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
