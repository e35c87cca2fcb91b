#include "twin/model/lab_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <Eigen/Core>

#include "twin/model/transform.h"

namespace twin::model {
namespace {

using Point = Eigen::Vector3d;
using ConstPoint = Eigen::Map<const Point>;

constexpr double kAnyDistance = std::numeric_limits<double>::infinity();
constexpr double kCos45Deg = 0.70710678118654752440;

/// The hand's y axis is turned by 45 degrees from the flange's x axis.
constexpr FlangeSphere AcrossHand(double y, double z, double radius) {
  return {{kCos45Deg * y, kCos45Deg * y, z}, radius};
}

constexpr std::array<FlangeSphere, 8> kHandSpheres{
    AcrossHand(-0.065, 0.037, 0.054),    AcrossHand(-0.065 / 3, 0.037, 0.054),
    AcrossHand(0.065 / 3, 0.037, 0.054), AcrossHand(0.065, 0.037, 0.054),
    AcrossHand(-0.05, 0.095, 0.027),     AcrossHand(-0.05 / 3, 0.095, 0.027),
    AcrossHand(0.05 / 3, 0.095, 0.027),  AcrossHand(0.05, 0.095, 0.027)};

/// A sphere of the robot in the base, and the motion of the frame that it is fixed to.
struct LimitedSphere {
  LimitedPart part;
  Point p;
  double radius;
  const FrameMotion* frame;
};

Point At(const Transform& X, const Vector3& p) {
  const Eigen::Map<const Eigen::Matrix4d> matrix(X.data());
  return matrix.topLeftCorner<3, 3>() * ConstPoint(p.data()) + matrix.topRightCorner<3, 1>();
}

/// d(outward . p)/dq with a minus: how the margin changes.
JointVector MarginGradient(const LimitedSphere& sphere, const Point& outward) {
  const Eigen::Map<const Eigen::Matrix<double, 6, 7>> J(sphere.frame->J.data());
  const Point arm = sphere.p - At(sphere.frame->O_T_frame, {});
  JointVector gradient;
  Eigen::Map<Eigen::Matrix<double, 1, 7>>(gradient.data()) =
      -outward.transpose() * J.topRows<3>() - arm.cross(outward).transpose() * J.bottomRows<3>();
  return gradient;
}

/// Collects the closest planes.
class ClosestPlanes {
 public:
  ClosestPlanes(double horizon, std::span<RegionMargin> near) : horizon_(horizon), near_(near) {}

  void Offer(std::size_t region, const LimitedSphere& sphere, const Point& outward, double bound) {
    const double margin = bound - outward.dot(sphere.p) - sphere.radius;
    if (!(margin < horizon_)) return;
    RegionMargin* to = nullptr;
    if (count_ < near_.size()) {
      to = &near_[count_++];
    } else if (!near_.empty()) {
      to = &*std::ranges::max_element(near_, {}, &RegionMargin::margin);
      if (to->margin <= margin) return;
    } else {
      return;
    }
    *to = {region, sphere.part, {outward[0], outward[1], outward[2]},
           bound,  margin,      MarginGradient(sphere, outward)};
  }

  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  const double horizon_;
  const std::span<RegionMargin> near_;
  std::size_t count_ = 0;
};

/// The plane of a box that a point outside must not pass.
/// @returns its normal out of the free space, into the box, and its bound.
std::pair<Point, double> PlaneBeside(const LimitBox& box, const Point& p) {
  const ConstPoint low(box.low.data());
  const ConstPoint high(box.high.data());
  const Point closest = p.cwiseMax(low).cwiseMin(high);
  const double distance = (closest - p).norm();
  if (distance > 0) {
    const Point inward = (closest - p) / distance;
    return {inward, inward.dot(closest)};
  }
  Eigen::Index axis = 0;  // inside: the face with the shortest way out
  const Point depth = (p - low).cwiseMin(high - p);
  depth.minCoeff(&axis);
  const bool is_low = p[axis] - low[axis] < high[axis] - p[axis];
  return {is_low ? Point::Unit(axis) : Point(-Point::Unit(axis)), is_low ? low[axis] : -high[axis]};
}

void OfferBox(std::size_t index, const LimitRegion& region, const LimitBox& box,
              const LimitedSphere& sphere, ClosestPlanes& planes) {
  if (!region.keep_inside) {
    const auto [inward, bound] = PlaneBeside(box, sphere.p);
    return planes.Offer(index, sphere, inward, bound);
  }
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    planes.Offer(index, sphere, Point::Unit(axis), box.high[i]);
    planes.Offer(index, sphere, -Point::Unit(axis), -box.low[i]);
  }
}

void OfferRegion(std::size_t index, const LimitRegion& region, const LimitedSphere& sphere,
                 ClosestPlanes& planes) {
  if (const auto* box = std::get_if<LimitBox>(&region.shape)) {
    return OfferBox(index, region, *box, sphere, planes);
  }
  const auto& half = std::get<HalfSpace>(region.shape);
  const ConstPoint normal(half.normal.data());
  const double side = region.keep_inside ? 1 : -1;
  planes.Offer(index, sphere, side * normal.normalized(), side * half.offset);
}

bool Limits(const LimitRegion& region, LimitedPart part) noexcept {
  return std::ranges::find(region.parts, part) != region.parts.end();
}

void Offer(const LabLimits& limits, LimitedPart part, const FrameMotion& frame,
           const FlangeSphere& at, ClosestPlanes& planes) {
  const LimitedSphere sphere{part, At(frame.O_T_frame, at.centre), at.radius, &frame};
  for (std::size_t i = 0; i < limits.regions.size(); ++i) {
    if (Limits(limits.regions[i], part)) OfferRegion(i, limits.regions[i], sphere, planes);
  }
}

void OfferBeyondFlange(const LabLimits& limits, const LimitedArm& arm, const FrameMotion& flange,
                       ClosestPlanes& planes) {
  const FlangeSphere end_effector{{arm.F_T_EE[12], arm.F_T_EE[13], arm.F_T_EE[14]}, 0};
  Offer(limits, LimitedPart::kEndEffector, flange, end_effector, planes);
  if (!arm.with_hand) return Offer(limits, LimitedPart::kHand, flange, kBareFlange, planes);
  for (const FlangeSphere& sphere : kHandSpheres) {
    Offer(limits, LimitedPart::kHand, flange, sphere, planes);
  }
}

[[noreturn]] void Refuse(const LimitRegion& region, const std::string& why) {
  throw InputError(fmt::format("region \"{}\": {}", region.name, why));
}

void RequireShape(const LimitRegion& region) {
  if (const auto* box = std::get_if<LimitBox>(&region.shape)) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (box->low[i] < box->high[i]) continue;
      Refuse(region, fmt::format("its box is empty: min {} m, max {} m along {}; min must be the "
                                 "lower",
                                 box->low[i], box->high[i], "xyz"[i]));
    }
    return;
  }
  const auto& half = std::get<HalfSpace>(region.shape);
  if (ConstPoint(half.normal.data()).norm() > 1e-9) return;
  Refuse(region, "the normal of its half-space has length 0; give where it points, as [0, 0, 1]");
}

/// Farthest that a point of the box goes along n.
double Reach(const LimitBox& box, const Point& n) {
  const ConstPoint low(box.low.data());
  const ConstPoint high(box.high.data());
  return n.cwiseProduct(low).cwiseMax(n.cwiseProduct(high)).sum();
}

/// Refuses regions of which each alone shows that they leave the part no place.
void RequirePlace(const std::vector<LimitRegion>& regions, LimitedPart part) {
  constexpr double kFar = 1e9;
  LimitBox room{{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}};
  const auto refuse = [part](const LimitRegion& region) {
    Refuse(region, fmt::format("it leaves the {} no place beside the other regions", Name(part)));
  };
  for (const LimitRegion& region : regions) {
    const auto* box = std::get_if<LimitBox>(&region.shape);
    if (!Limits(region, part) || !region.keep_inside || box == nullptr) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      room.low[i] = std::max(room.low[i], box->low[i]);
      room.high[i] = std::min(room.high[i], box->high[i]);
      if (!(room.low[i] < room.high[i])) refuse(region);
    }
  }
  for (const LimitRegion& region : regions) {
    if (!Limits(region, part)) continue;
    if (const auto* half = std::get_if<HalfSpace>(&region.shape)) {
      const double side = region.keep_inside ? 1 : -1;
      const Point out = side * ConstPoint(half->normal.data()).normalized();
      if (-Reach(room, -out) >= side * half->offset) refuse(region);
    } else if (!region.keep_inside) {
      const auto& box = std::get<LimitBox>(region.shape);
      const bool is_all =
          (ConstPoint(box.low.data()).array() <= ConstPoint(room.low.data()).array()).all() &&
          (ConstPoint(box.high.data()).array() >= ConstPoint(room.high.data()).array()).all();
      if (is_all) refuse(region);
    }
  }
}

void RequireCap(const char* name, double value) {
  if (value > 0 && std::isfinite(value)) return;
  throw InputError(fmt::format("{} is {}; it must be above 0", name, value));
}

template <typename T>
void TakeLower(std::optional<T>& cap, const std::optional<T>& other) {
  if (!other) return;
  if (!cap) {
    cap = other;
    return;
  }
  if constexpr (std::is_same_v<T, double>) {
    cap = std::min(*cap, *other);
  } else {
    for (std::size_t i = 0; i < cap->size(); ++i) (*cap)[i] = std::min((*cap)[i], (*other)[i]);
  }
}

/// "x = 0.71200 m; it must be at most 0.70000 m". A part may pass a plane beside a box to stay out
/// of elsewhere, so there a bound is told, and no demand.
std::string PassedText(const RegionMargin& margin, bool is_demand) {
  const Vector3& n = margin.outward;
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::abs(n[i]) != 1) continue;
    const std::string_view demand = n[i] < 0 ? "it must be at least" : "it must be at most";
    return fmt::format("{} = {:.5f} m; {} {:.5f} m", "xyz"[i], n[i] * margin.value(),
                       is_demand ? demand : "the bound is", n[i] * margin.bound);
  }
  return fmt::format("{:.5f} m along [{:.3g}, {:.3g}, {:.3g}]; the bound is {:.5f} m",
                     margin.value(), n[0], n[1], n[2], margin.bound);
}

}  // namespace

std::string_view Name(LimitedPart part) noexcept {
  switch (part) {
    case LimitedPart::kEndEffector: return "end effector";
    case LimitedPart::kElbow: return "elbow";
    case LimitedPart::kHand: return "hand";
  }
  return {};
}

std::span<const FlangeSphere> HandSpheres() noexcept {
  return kHandSpheres;
}

void LabLimits::Add(const LabLimits& other) {
  for (const LimitRegion& region : other.regions) {
    if (std::ranges::find(regions, region.name, &LimitRegion::name) != regions.end()) {
      Refuse(region, "another region has this name; rename one of them");
    }
    regions.push_back(region);
  }
  TakeLower(dq_max, other.dq_max);
  TakeLower(v_max, other.v_max);
  TakeLower(w_max, other.w_max);
  TakeLower(force_max, other.force_max);
  TakeLower(tau_max, other.tau_max);
}

void LabLimits::Lower(JointLimits& limits) const noexcept {
  if (!dq_max) return;
  for (std::size_t i = 0; i < kJoints; ++i) {
    limits.dq_max[i] = std::min(limits.dq_max[i], (*dq_max)[i]);
  }
}

void LabLimits::Lower(CartesianLimits& limits) const noexcept {
  if (v_max) limits.translation.dp_max = std::min(limits.translation.dp_max, *v_max);
  if (w_max) limits.rotation.dp_max = std::min(limits.rotation.dp_max, *w_max);
}

void LabLimits::Validate() const {
  if (regions.size() > kMostRegions) {
    throw InputError(
        fmt::format("{} regions; there may be at most {}", regions.size(), kMostRegions));
  }
  for (auto region = regions.begin(); region != regions.end(); ++region) {
    if (region->name.empty()) throw InputError("a region has no name; give it one");
    if (region->name.size() > LimitRegion::kLongestName) {
      Refuse(*region, fmt::format("the name has {} bytes; give one of at most {}",
                                  region->name.size(), LimitRegion::kLongestName));
    }
    if (region->parts.empty())
      Refuse(*region, "it limits nothing; name end_effector, elbow or hand");
    if (std::ranges::find(regions.begin(), region, region->name, &LimitRegion::name) != region) {
      Refuse(*region, "another region has this name; rename one of them");
    }
    RequireShape(*region);
  }
  for (std::size_t part = 0; part < kLimitedParts; ++part) {
    RequirePlace(regions, static_cast<LimitedPart>(part));
  }
  if (dq_max) std::ranges::for_each(*dq_max, [](double x) { RequireCap("speed.joints", x); });
  if (v_max) RequireCap("speed.end_effector", *v_max);
  if (w_max) RequireCap("speed.rotation", *w_max);
  if (force_max) RequireCap("force", *force_max);
  if (tau_max) std::ranges::for_each(*tau_max, [](double x) { RequireCap("torque", x); });
}

std::size_t MarginsWithin(double horizon, const LabLimits& limits, const LimitedArm& arm,
                          const Configuration& q, std::span<RegionMargin> near) noexcept {
  if (limits.regions.empty()) return 0;
  const ArmModel& model = ArmModel::Panda();
  ClosestPlanes planes(horizon, near);
  const FrameMotion elbow = model.MotionOf(Frame::kJoint4, q);
  Offer(limits, LimitedPart::kElbow, elbow, {}, planes);
  OfferBeyondFlange(limits, arm, model.MotionOf(Frame::kFlange, q), planes);
  return planes.count();
}

std::optional<RegionMargin> LeastMargin(const LabLimits& limits, const LimitedArm& arm,
                                        const Configuration& q) noexcept {
  RegionMargin least;
  const std::size_t count = MarginsWithin(kAnyDistance, limits, arm, q, {&least, 1});
  return count == 0 ? std::nullopt : std::optional(least);
}

std::optional<RegionMargin> LeastMarginAt(const LabLimits& limits, const LimitedArm& arm,
                                          const Transform& O_T_EE) noexcept {
  RegionMargin least;
  ClosestPlanes planes(kAnyDistance, {&least, 1});
  OfferBeyondFlange(limits, arm, {Multiply(O_T_EE, Inverse(arm.F_T_EE)), {}}, planes);
  return planes.count() == 0 ? std::nullopt : std::optional(least);
}

std::string Describe(const LabLimits& limits, const RegionMargin& margin) {
  const LimitRegion& region = limits.regions[margin.region];
  return fmt::format(
      "limit \"{}\": the {} reaches {}", region.name, Name(margin.part),
      PassedText(margin, region.keep_inside || std::holds_alternative<HalfSpace>(region.shape)));
}

}  // namespace twin::model
