#include "twin/onboard/accelerometers.h"

#include <array>
#include <cstddef>
#include <tuple>

#include "twin/core/time.h"

namespace twin::onboard {
namespace {

constexpr std::size_t kLinks = 6;
constexpr double kGravity = 9.81;

/// A sensor in its link's frame, turned about the link's x axis.
struct Mount {
  Vector3 place;  ///< m
  double cos = 1;
  double sin = 0;
};
constexpr double kLeft = 1;    ///< turned by +90 degrees
constexpr double kRight = -1;  ///< turned by -90 degrees

constexpr std::array<Mount, kLinks> kTop{{{{0, 0, 0.05}, -1, 0},
                                          {{0, -0.1, 0}, 0, kLeft},
                                          {{0, -0.13, 0}, 0, kRight},
                                          {{0.0825, 0.05, 0}, 0, kRight},
                                          {{-0.0825, 0.05, 0}, 0, kLeft},
                                          {{0, 0.11, 0}, 0, kRight}}};
constexpr std::array<Mount, kLinks> kBottom{{{{0, 0, 0.06}, 1, 0},
                                             {{0, -0.09, 0}, 0, kRight},
                                             {{0, -0.14, 0}, 0, kLeft},
                                             {{0.0825, 0.04, 0}, 0, kLeft},
                                             {{-0.0825, 0.06, 0}, 0, kRight},
                                             {{0, 0.1, 0}, 0, kLeft}}};

/// R x, or R^T x, of a transform's rotation R.
Vector3 Rotated(const Transform& T, const Vector3& x) noexcept {
  Vector3 y{};
  for (std::size_t r = 0; r < 3; ++r) y[r] = T[r] * x[0] + T[4 + r] * x[1] + T[8 + r] * x[2];
  return y;
}
Vector3 RotatedBack(const Transform& T, const Vector3& x) noexcept {
  Vector3 y{};
  for (std::size_t c = 0; c < 3; ++c) {
    y[c] = T[4 * c] * x[0] + T[4 * c + 1] * x[1] + T[4 * c + 2] * x[2];
  }
  return y;
}

/// A link's motion in base axes.
struct LinkMotion {
  Transform pose = kIdentityTransform;
  Vector6 twist{};
};

/// @param v  velocity of the last cycle; becomes this one's. @param a  receives the reading.
void Read(const LinkMotion& link, const Mount& mount, bool is_new, double* v, double* a) noexcept {
  const Vector3 r = Rotated(link.pose, mount.place);
  const Vector6& t = link.twist;
  const Vector3 now{t[0] + t[4] * r[2] - t[5] * r[1], t[1] + t[5] * r[0] - t[3] * r[2],
                    t[2] + t[3] * r[1] - t[4] * r[0]};
  Vector3 proper{0, 0, kGravity};
  for (std::size_t i = 0; i < 3; ++i) {
    if (!is_new) proper[i] += (now[i] - v[i]) / kCycleSeconds;
    v[i] = now[i];
  }
  const Vector3 in_link = RotatedBack(link.pose, proper);
  a[0] = in_link[0];
  a[1] = mount.cos * in_link[1] + mount.sin * in_link[2];
  a[2] = -mount.sin * in_link[1] + mount.cos * in_link[2];
}

}  // namespace

void Accelerometers::Update(const model::ArmModel& arm, const model::Configuration& q,
                            const JointVector& dq) noexcept {
  for (std::size_t n = 0; n < kLinks; ++n) {
    LinkMotion link;
    if (n > 0) {
      const auto frame = static_cast<model::Frame>(n - 1);  // of joint n, fixed to link n
      std::tie(link.pose, link.twist) = arm.PoseAndTwist(frame, q, dq);
    }
    Read(link, kTop[n], is_new_, &v_top_[3 * n], &top_[3 * n]);
    Read(link, kBottom[n], is_new_, &v_bottom_[3 * n], &bottom_[3 * n]);
  }
  is_new_ = false;
}

}  // namespace twin::onboard
