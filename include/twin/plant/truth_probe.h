#pragma once

#include <cstddef>
#include <span>

struct mjModel_;
struct mjData_;

namespace twin::plant {

/// Ground truth of a MuJoCo plant: what no robot could report. Only render, experiments and tests
/// may include this header; nothing on the control path may.
///
/// Threads: the plant's thread; model() is constant after construction, all but dof_frictionloss
/// (which closed brakes raise), and may be read from any thread.
class TruthProbe {
 public:
  virtual ~TruthProbe() = default;
  /// The compiled model, owned by the plant.
  [[nodiscard]] virtual const mjModel_& model() const noexcept = 0;
  /// The plant's data as of the last step, owned by the plant.
  [[nodiscard]] virtual const mjData_& data() const noexcept = 0;
  /// Number of generalised positions.
  [[nodiscard]] virtual std::size_t qpos_size() const noexcept = 0;
  /// Copies the generalised positions. @pre out.size() == qpos_size().
  virtual void CopyQpos(std::span<double> out) const noexcept = 0;
};

}  // namespace twin::plant
