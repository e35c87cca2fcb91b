#include "record/arm_frames.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "twin/model/arm_model.h"
#include "twin/model/transform.h"

namespace twin::record {
namespace {

/// The links in the order of the tree, each the parent of the next.
constexpr std::array kLinks = {"panda_link0", "panda_link1", "panda_link2", "panda_link3",
                               "panda_link4", "panda_link5", "panda_link6", "panda_link7",
                               "panda_link8", "panda_hand"};

/// Frames of all links except the base and the hand.
constexpr std::array kFrames = {model::Frame::kJoint1, model::Frame::kJoint2, model::Frame::kJoint3,
                                model::Frame::kJoint4, model::Frame::kJoint5, model::Frame::kJoint6,
                                model::Frame::kJoint7, model::Frame::kFlange};

/// The hand is mounted turned by -45 degrees about the flange's z axis.
constexpr double kCos45 = std::numbers::sqrt2 / 2;
constexpr Transform kFlangeToHand{kCos45, -kCos45, 0, 0, kCos45, kCos45, 0, 0,
                                  0,      0,       1, 0, 0,      0,      0, 1};

/// Unit quaternion of a rotation, w not negative. Computed from its largest component, which avoids
/// division by small numbers. Source: Shepperd, "Quaternion from rotation matrix", 1978.
void SetRotation(const Transform& X, foxglove::Quaternion& out) {
  const auto R = [&X](std::size_t row, std::size_t column) { return X[4 * column + row]; };
  const double trace = R(0, 0) + R(1, 1) + R(2, 2);
  std::array<double, 4> q{};  // x, y, z, w
  const std::array<double, 4> size{R(0, 0), R(1, 1), R(2, 2), trace};
  const auto largest =
      static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin());
  if (largest == 3) {
    q = {R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1), 1 + trace};
  } else {
    const std::size_t i = largest;
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    q[i] = 1 + R(i, i) - R(j, j) - R(k, k);
    q[j] = R(j, i) + R(i, j);
    q[k] = R(k, i) + R(i, k);
    q[3] = R(k, j) - R(j, k);
  }
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double scale = (q[3] < 0 ? -1 : 1) / norm;
  out.set_x(q[0] * scale);
  out.set_y(q[1] * scale);
  out.set_z(q[2] * scale);
  out.set_w(q[3] * scale);
}

void SetPose(const Transform& X, foxglove::FrameTransform& out) {
  out.mutable_translation()->set_x(X[12]);
  out.mutable_translation()->set_y(X[13]);
  out.mutable_translation()->set_z(X[14]);
  SetRotation(X, *out.mutable_rotation());
}

void SetTime(Time at, google::protobuf::Timestamp& out) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t ns = std::max<std::int64_t>(at.time_since_epoch().count(), 0);
  out.set_seconds(ns / kSecond);
  out.set_nanos(static_cast<std::int32_t>(ns % kSecond));
}

}  // namespace

ArmFrames::ArmFrames() {
  for (std::size_t i = 0; i + 1 < kLinks.size(); ++i) AddFrame(kLinks[i], kLinks[i + 1]);
  SetPose(kFlangeToHand, *message_.mutable_transforms()->rbegin());
}

void ArmFrames::AddFrame(const char* parent, const char* child) {
  foxglove::FrameTransform& frame = *message_.add_transforms();
  frame.set_parent_frame_id(parent);
  frame.set_child_frame_id(child);
}

const foxglove::FrameTransforms* ArmFrames::Next(Time at, const JointVector& q) {
  const std::int64_t span = at.time_since_epoch() / kPeriod;
  if (last_ == span || !std::ranges::all_of(q, [](double x) { return std::isfinite(x); })) {
    return nullptr;
  }
  last_ = span;
  const model::Configuration configuration(q);
  Transform O_T_parent = kIdentityTransform;
  for (std::size_t i = 0; i < kFrames.size(); ++i) {
    const Transform O_T_child = model::ArmModel::Panda().Pose(kFrames[i], configuration);
    SetPose(model::Multiply(model::Inverse(O_T_parent), O_T_child),
            *message_.mutable_transforms(static_cast<int>(i)));
    O_T_parent = O_T_child;
  }
  for (foxglove::FrameTransform& frame : *message_.mutable_transforms()) {
    SetTime(at, *frame.mutable_timestamp());
  }
  return &message_;
}

}  // namespace twin::record
