#include "twin/planning/pose_following.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "planning/joint_space.h"
#include "twin/core/error.h"
#include "twin/core/joint_vector.h"
#include "twin/model/arm_model.h"
#include "twin/model/inverse_kinematics.h"
#include "twin/model/transform.h"

namespace twin::planning {
namespace {

constexpr double kArrived = 1e-5;  // m and rad
constexpr Duration kTimeout = std::chrono::seconds(5);

/// Joint and bound, if q leaves the requested range.
std::optional<std::string> OutOfRange(const JointVector& q, const JointLimits& limits,
                                      double margin, Duration at) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (q[i] >= limits.q_min[i] + margin && q[i] <= limits.q_max[i] - margin) continue;
    return fmt::format("after {:.2f} s joint {} comes to {:.3f} rad, its range is [{}, {}] rad",
                       ToSeconds(at), i + 1, q[i], limits.q_min[i], limits.q_max[i]);
  }
  return std::nullopt;
}

/// Updates the shares of the joint limits used in one step.
void AddLoads(const JointVector& q, const JointVector& before, const JointVector& dq, double step_s,
              const JointLimits& limits, const FollowOptions& options, Followed& followed) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    followed.velocity_load =
        std::max(followed.velocity_load,
                 std::abs(dq[i]) / (options.velocity_share * limits.VelocityLimit(i, q[i], dq[i])));
    followed.acceleration_load =
        std::max(followed.acceleration_load, std::abs(dq[i] - before[i]) / step_s /
                                                 (options.acceleration_share * limits.ddq_max[i]));
  }
}

}  // namespace

void FollowOptions::Validate() const {
  RequireInRange("follow: K_P", K_P, 0.1, 100);
  RequireInRange("follow: alpha", alpha, 0, 1);
  RequireInRange("follow: step (s)", ToSeconds(step), 1e-4, 0.02);
  RequireInRange("follow: limit_margin (rad)", limit_margin, 0.01, 1);
  RequireInRange("follow: velocity_share", velocity_share, 0.01, 1);
  RequireInRange("follow: acceleration_share", acceleration_share, 0.01, 1);
}

std::variant<Followed, std::string> Follow(const reference::PoseTrajectory& poses,
                                           const JointVector& q, const Transform& F_T_EE,
                                           const JointLimits& limits,
                                           const FollowOptions& options) {
  options.Validate();
  const model::ArmModel& arm = model::ArmModel::Panda();
  const double step_s = ToSeconds(options.step);
  Followed followed{.q = {q}};
  JointVector now = q;
  JointVector before{};
  for (Duration t{};; t += options.step) {
    const model::FrameMotion motion = arm.MotionOf(model::Frame::kEndEffector, now, F_T_EE);
    const Vector6 e = model::WayTo(motion.O_T_frame, poses.Sample(t).O_T_EE);
    const double left = std::max(HalfNorm(e, 0), HalfNorm(e, 3));
    if (t >= poses.duration() && left <= kArrived) return followed;
    if (t > poses.duration() + kTimeout) {
      return fmt::format("the arm does not come nearer to the goal than {:.4f} m and {:.4f} rad",
                         HalfNorm(e, 0), HalfNorm(e, 3));
    }
    Vector6 v = poses.Sample(t + options.step / 2).O_dP_EE;
    for (std::size_t i = 0; i < v.size(); ++i) v[i] += options.K_P * e[i];
    const JointVector dq = model::DampedLeastSquares(motion.J, v, options.alpha);
    for (std::size_t i = 0; i < kJoints; ++i) now[i] += step_s * dq[i];
    if (auto why = OutOfRange(now, limits, options.limit_margin, t)) return std::move(*why);
    AddLoads(now, before, dq, step_s, limits, options, followed);
    followed.q.push_back(now);
    before = dq;
  }
}

std::optional<std::string> FirstTouch(CollisionWorld& world, const std::vector<JointVector>& way,
                                      double clearance) {
  double travelled = 0;
  for (std::size_t i = 0; i < way.size(); ++i) {
    const bool is_end = i == 0 || i + 1 == way.size();
    if (i > 0) travelled += world.Travel(way[i - 1], way[i]);
    const double next = is_end ? 0 : world.Travel(way[i], way[i + 1]);
    if (!is_end && travelled + next <= 2 * clearance) continue;
    travelled = 0;
    if (world.IsFree(way[i], clearance)) continue;
    return Describe(world.Touches(way[i], clearance));
  }
  return std::nullopt;
}

}  // namespace twin::planning
