#include "twin/application/end_effector_path.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>

#include "twin/core/time.h"
#include "twin/model/arm_model.h"
#include "twin/render/renderer.h"

namespace twin::application {
namespace {

double Distance(const Vector3& a, const Vector3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

}  // namespace

std::vector<Vector3> Thinned(const std::vector<Vector3>& points) {
  constexpr double kApart = 0.02;
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length += Distance(points[i], points[i - 1]);
  const double apart =
      std::max(kApart, length / static_cast<double>(render::Ghost::kMostPoints - 2));
  std::vector<Vector3> way{points.front()};
  for (const Vector3& point : points) {
    if (Distance(point, way.back()) >= apart) way.push_back(point);
  }
  return way;
}

std::vector<Vector3> EndEffectorPath(const reference::Trajectory& trajectory,
                                     const Transform& F_T_EE) {
  constexpr Duration kStep = std::chrono::milliseconds(5);
  std::vector<Vector3> all;
  for (Duration t{}; t < trajectory.duration() + kStep; t += kStep) {
    const Transform O_T_EE =
        model::ArmModel::Panda().Pose(model::Frame::kEndEffector, trajectory.Sample(t).q, F_T_EE);
    all.push_back({O_T_EE[12], O_T_EE[13], O_T_EE[14]});
  }
  return Thinned(all);
}

}  // namespace twin::application
