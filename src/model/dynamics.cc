#include "model/body.h"
#include "model/joint_chain.h"
#include "twin/model/arm_model.h"

namespace twin::model {

using internal::AboutJoint7;
using internal::BaseToTip;
using internal::Cross;
using internal::Offset;
using internal::OffsetCross;
using internal::TipToBase;
using internal::ToChild;
using internal::ToParent;
using internal::operator+;
using internal::operator-;
using internal::operator*;

namespace {

using Links = std::array<MassMoments, kJoints>;

/// Motion of a link, in its own axes.
struct Motion {
  Vector3 w{};      ///< angular velocity
  Vector3 alpha{};  ///< angular acceleration
  Vector3 a{};      ///< acceleration of the frame's origin, minus gravity
};

/// A matrix by its columns.
struct Columns {
  Vector3 x, y, z;
};

/// [alpha]x + [w]x^2: maps a point of the link to its acceleration relative to the origin.
Columns RelativeAcceleration(const Vector3& w, const Vector3& alpha) noexcept {
  const double xx = w[0] * w[0];
  const double yy = w[1] * w[1];
  const double zz = w[2] * w[2];
  const double xy = w[0] * w[1];
  const double xz = w[0] * w[2];
  const double yz = w[1] * w[2];
  return {{-yy - zz, xy + alpha[2], xz - alpha[1]},
          {xy - alpha[2], -xx - zz, yz + alpha[0]},
          {xz + alpha[1], yz - alpha[0], -xx - yy}};
}

/// Motion of link i from that of its parent, with `A` the parent's RelativeAcceleration.
template <std::size_t i>
Motion Next(const Motion& parent, const Columns& A, double s, double c, double dq,
            double ddq) noexcept {
  constexpr Vector3 p = Offset(i);
  Vector3 a = parent.a;
  if constexpr (p[0] != 0) a = a + p[0] * A.x;
  if constexpr (p[1] != 0) a = a + p[1] * A.y;
  if constexpr (p[2] != 0) a = a + p[2] * A.z;
  const Vector3 w = ToChild<i>(parent.w, s, c);
  const Vector3 alpha = ToChild<i>(parent.alpha, s, c);
  return {{w[0], w[1], w[2] + dq},
          {alpha[0] + w[1] * dq, alpha[1] - w[0] * dq, alpha[2] + ddq},
          ToChild<i>(a, s, c)};
}

/// Force, and moment about the frame's origin.
struct Wrench {
  Vector3 f{};
  Vector3 n{};
};

/// A wrench at the origin of frame i, in the axes of frame i - 1 and about its origin.
template <std::size_t i>
Wrench Shift(const Wrench& wrench, double s, double c) noexcept {
  const Vector3 f = ToParent<i>(wrench.f, s, c);
  return {f, ToParent<i>(wrench.n, s, c) + OffsetCross<i>(f)};
}

/// Wrenches about a frame's origin that accelerate a body, one for each unit parameter: of mass,
/// first and second moments.
using UnitWrenches = std::array<Wrench, kBodyParameters>;

UnitWrenches WrenchesOf(const Motion& motion, const Columns& A) noexcept {
  const auto& [w, alpha, a] = motion;
  // I alpha + w x I w, for I with one element (and its mirror image) of 1.
  const auto moment = [&w = motion.w, &alpha = motion.alpha](const SymmetricMatrix3& I) {
    return Wrench{{}, I * alpha + Cross(w, I * w)};
  };
  return {Wrench{a, {}},           {A.x, {0, -a[2], a[1]}}, {A.y, {a[2], 0, -a[0]}},
          {A.z, {-a[1], a[0], 0}}, moment({.xx = 1}),       moment({.xy = 1}),
          moment({.xz = 1}),       moment({.yy = 1}),       moment({.yz = 1}),
          moment({.zz = 1})};
}

}  // namespace

Regressor ArmModel::RegressorOf(const Configuration& q, const JointVector& dq,
                                const JointVector& ddq, const Vector3& g_earth) noexcept {
  std::array<UnitWrenches, kRegressorBodies> bodies;  // in the axes of their frame
  Motion motion{{}, {}, -g_earth};
  Columns A{};
  BaseToTip([&]<std::size_t i>() {
    motion = Next<i>(motion, A, q.sin[i], q.cos[i], dq[i], ddq[i]);
    A = RelativeAcceleration(motion.w, motion.alpha);
    bodies[i] = WrenchesOf(motion, A);
  });
  // The flange has the axes of joint frame 7; its wrenches then act about that frame's origin.
  motion.a = motion.a + internal::kFlangeOffset * A.z;
  bodies[kJoints] = WrenchesOf(motion, A);
  for (Wrench& wrench : bodies[kJoints]) {
    wrench.n = wrench.n + internal::kFlangeOffset * Vector3{-wrench.f[1], wrench.f[0], 0};
  }

  constexpr std::size_t kWidth = kRegressorBodies * kBodyParameters;
  Regressor Y{};
  TipToBase([&]<std::size_t i>() {
    for (std::size_t body = i; body < kRegressorBodies; ++body) {
      for (std::size_t p = 0; p < kBodyParameters; ++p) {
        Wrench& wrench = bodies[body][p];
        Y[kWidth * i + kBodyParameters * body + p] = wrench.n[2];
        if constexpr (i > 0) wrench = Shift<i>(wrench, q.sin[i], q.cos[i]);
      }
    }
  });
  return Y;
}

JointVector ArmModel::InverseDynamics(const Configuration& q, const JointVector& dq,
                                      const JointVector& ddq, const Payload& payload,
                                      const Vector3& g_earth) const noexcept {
  const MassMoments last = links_[kJoints - 1] + AboutJoint7(payload);
  std::array<Wrench, kJoints> inertial;  // that accelerates each link
  Motion motion{{}, {}, -g_earth};       // of the base
  Columns A{};
  BaseToTip([&]<std::size_t i>() {
    const MassMoments& body = i == kJoints - 1 ? last : links_[i];
    motion = Next<i>(motion, A, q.sin[i], q.cos[i], dq[i], ddq[i]);
    A = RelativeAcceleration(motion.w, motion.alpha);
    inertial[i].f = body.m * motion.a + (body.h[0] * A.x + body.h[1] * A.y + body.h[2] * A.z);
    inertial[i].n =
        Cross(body.h, motion.a) + body.I * motion.alpha + Cross(motion.w, body.I * motion.w);
  });

  JointVector tau;
  Wrench carried;  // by joint i, for link i and all beyond it
  TipToBase([&]<std::size_t i>() {
    carried.f = carried.f + inertial[i].f;
    carried.n = carried.n + inertial[i].n;
    tau[i] = carried.n[2];
    if constexpr (i > 0) carried = Shift<i>(carried, q.sin[i], q.cos[i]);
  });
  return tau;
}

JointVector ArmModel::Coriolis(const Configuration& q, const JointVector& dq,
                               const Payload& payload) const noexcept {
  return InverseDynamics(q, dq, JointVector{}, payload, Vector3{});
}

JointVector ArmModel::Gravity(const Configuration& q, const Payload& payload,
                              const Vector3& g_earth) const noexcept {
  std::array<Vector3, kJoints> g;  // gravity in each link's axes
  Vector3 g_parent = g_earth;
  BaseToTip([&]<std::size_t i>() {
    g[i] = ToChild<i>(g_parent, q.sin[i], q.cos[i]);
    g_parent = g[i];
  });

  const MassMoments load = AboutJoint7(payload);
  JointVector tau;
  double m = load.m;  // of link i and all beyond it
  Vector3 h = load.h;
  TipToBase([&]<std::size_t i>() {
    m += links_[i].m;
    h = h + links_[i].h;
    tau[i] = h[1] * g[i][0] - h[0] * g[i][1];
    constexpr Vector3 p = Offset(i);
    h = ToParent<i>(h, q.sin[i], q.cos[i]);
    for (std::size_t k = 0; k < 3; ++k) {
      if (p[k] != 0) h[k] += p[k] * m;
    }
  });
  return tau;
}

JointMatrix ArmModel::MassMatrix(const Configuration& q, const Payload& payload) const noexcept {
  JointMatrix M;
  MassMoments body = AboutJoint7(payload);  // link i and all beyond it, held rigid
  TipToBase([&]<std::size_t i>() {
    body = body + links_[i];
    // Wrench for a unit acceleration of joint i alone, propagated to the base.
    Wrench wrench{{-body.h[1], body.h[0], 0}, {body.I.xz, body.I.yz, body.I.zz}};
    M[kJoints * i + i] = body.I.zz;
    TipToBase([&]<std::size_t j>() {
      if constexpr (j > 0 && j <= i) {
        wrench = Shift<j>(wrench, q.sin[j], q.cos[j]);
        M[kJoints * i + j - 1] = wrench.n[2];
        M[kJoints * (j - 1) + i] = wrench.n[2];
      }
    });
    if constexpr (i > 0) body = ToParent<i>(body, q.sin[i], q.cos[i]);
  });
  return M;
}

}  // namespace twin::model
