#pragma once

#include <cstddef>
#include <span>
#include <string>

struct mjModel_;
struct mjData_;

namespace twin::plant {

/// Ground truth of a MuJoCo plant, which no robot can report. Only render, experiments and tests
/// may include this header, never the control path.
///
/// Threads: the plant's thread; model() is constant after construction, except dof_frictionloss
/// (changed by closed brakes), and readable from any thread.
class TruthProbe {
 public:
  virtual ~TruthProbe() = default;
  /// The compiled model, owned by the plant.
  [[nodiscard]] virtual const mjModel_& model() const noexcept = 0;
  /// The plant's data after the last step, owned by the plant.
  [[nodiscard]] virtual const mjData_& data() const noexcept = 0;
  /// Number of generalised positions; of one arm among several, those without the other arms, so
  /// that a model of this arm alone draws them.
  [[nodiscard]] virtual std::size_t qpos_size() const noexcept = 0;
  /// Copies the generalised positions. @pre out.size() == qpos_size().
  virtual void CopyQpos(std::span<double> out) const noexcept = 0;
  /// What the names of this arm's bodies begin with, in a model of several arms: "left/".
  [[nodiscard]] virtual const std::string& prefix() const noexcept = 0;
  /// The same with the positions of all arms, which draw model(); lives as long as this.
  [[nodiscard]] virtual const TruthProbe& whole() const noexcept { return *this; }
};

}  // namespace twin::plant
