#include "render/frame_parts.h"

#include <cmath>

namespace twin::render {
namespace {

/// Upper bound of the trace's pieces.
constexpr std::size_t kMostPieces = 300;

/// A body, and the tool's position along z of its frame, m.
struct Tool {
  int body = 0;
  double z_m = 0;
};

Tool ToolOf(const DrawnModel& model) {
  const int hand = mj_name2id(&model.get(), mjOBJ_BODY, "panda_hand");
  if (hand >= 0) return {hand, 0.1034};  // between the finger tips
  return {model.BodyId("panda_link7"), 0.107};
}

double Distance(const Vector3& a, const Vector3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

}  // namespace

ToolTrace::ToolTrace(const DrawnModel& model, const Snapshots* before, const Snapshots& frames) {
  if (before != nullptr) Follow(model, *before);
  before_ = points_.size();
  Follow(model, frames);
}

void ToolTrace::Follow(const DrawnModel& model, const Snapshots& snapshots) {
  const Tool tool = ToolOf(model);
  const DrawnModel::DataPointer data = model.NewData();
  points_.reserve(points_.size() + snapshots.size());
  for (std::size_t i = 0; i < snapshots.size(); ++i) {
    model.SetPositions(snapshots.qpos(i), *data);
    const mjtNum* const R = data->xmat + std::ptrdiff_t{9} * tool.body;  // row-major
    const mjtNum* const p = data->xpos + std::ptrdiff_t{3} * tool.body;
    points_.push_back({ToSeconds(snapshots.time(i).time_since_epoch()),
                       {p[0] + R[2] * tool.z_m, p[1] + R[5] * tool.z_m, p[2] + R[8] * tool.z_m}});
  }
}

void ToolTrace::Append(std::size_t frame, double seconds, const Colour& colour,
                       std::vector<mjvGeom>& marks) const {
  constexpr double kRadius = 0.003;
  constexpr double kApart = 0.004;  // shorter pieces would be invisible
  const std::size_t last = before_ + frame;
  Vector3 end = points_[last].p_W;
  std::size_t pieces = 0;
  for (std::size_t i = last; i-- > 0 && pieces < kMostPieces;) {
    if (points_[i].at_s < points_[last].at_s - seconds) break;
    if (Distance(points_[i].p_W, end) < kApart) continue;
    marks.push_back(Rod(points_[i].p_W, end, kRadius, colour));
    end = points_[i].p_W;
    ++pieces;
  }
}

}  // namespace twin::render
