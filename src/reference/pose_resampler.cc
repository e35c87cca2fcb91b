#include "twin/reference/pose_resampler.h"

#include "twin/model/rotation.h"

namespace twin::reference {

namespace {

Transform PoseOf(const JointVector& x) noexcept {
  return model::Pose(Eigen::Quaterniond(x[3], x[4], x[5], x[6]).normalized(), {x[0], x[1], x[2]});
}

}  // namespace

JointVector PoseResampler::CoordinatesOf(const Transform& O_T_EE) const noexcept {
  const Eigen::Vector3d p = model::Position(O_T_EE);
  const Eigen::Quaterniond r = model::Orientation(O_T_EE);
  const double cosine = r.w() * last_[3] + r.x() * last_[4] + r.y() * last_[5] + r.z() * last_[6];
  const double sign = cosine < 0 ? -1 : 1;
  return {p.x(), p.y(), p.z(), sign * r.w(), sign * r.x(), sign * r.y(), sign * r.z()};
}

void PoseResampler::Reset(const Transform& O_T_EE) noexcept {
  last_ = CoordinatesOf(O_T_EE);
  resampler_.Reset(last_);
}

void PoseResampler::Deposit(Time source_time, const Transform& O_T_EE) noexcept {
  last_ = CoordinatesOf(O_T_EE);
  resampler_.Deposit(source_time, last_);
}

Transform PoseResampler::Value(std::size_t cycles) const noexcept {
  return PoseOf(resampler_.Value(cycles));
}

Transform PoseResampler::Source() const noexcept {
  return PoseOf(resampler_.Source());
}

}  // namespace twin::reference
