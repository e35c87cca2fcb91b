#include "render/frame_parts.h"

#include <algorithm>
#include <cmath>

namespace twin::render {
namespace {

constexpr Colour kGround{0.08F, 0.08F, 0.10F, 0.75F};
constexpr Colour kFar{0.25F, 0.80F, 0.35F, 1};
constexpr Colour kNear{1.0F, 0.70F, 0.10F, 1};
constexpr Colour kAtLimit{0.95F, 0.15F, 0.10F, 1};

const Colour& ColourOf(double share) {
  const double margin = std::min(share, 1 - share);
  if (margin < 0.02) return kAtLimit;
  return margin < 0.1 ? kNear : kFar;
}

}  // namespace

JointBars::JointBars(const DrawnModel& model) {
  const std::array<int, kJoints> ids = model.ArmJoints();
  for (std::size_t i = 0; i < kJoints; ++i) {
    const mjtNum* const range = model.get().jnt_range + std::ptrdiff_t{2} * ids[i];
    joints_[i] = {model.get().jnt_qposadr[ids[i]], range[0], range[1]};
  }
}

void JointBars::Draw(const mjData& data, const SceneRenderer& scene) const {
  const mjrRect whole = scene.Whole();
  const int width = std::max(3, whole.width / 80);
  const int height = whole.height / 6;
  const int slider = std::max(2, height / 14);
  const int bottom = height / 8;
  int left = whole.width - 7 * (width + width / 2) - bottom;
  for (const Joint& joint : joints_) {
    const double share = std::clamp(
        (data.qpos[joint.position] - joint.lower) / (joint.upper - joint.lower), 0.0, 1.0);
    scene.Fill({left, bottom, width, height}, kGround);
    const int up = static_cast<int>(std::lround(share * (height - slider)));
    scene.Fill({left, bottom + up, width, slider}, ColourOf(share));
    left += width + width / 2;
  }
}

}  // namespace twin::render
