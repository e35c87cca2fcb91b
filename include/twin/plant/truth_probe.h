#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

struct mjModel_;
struct mjData_;

namespace twin::plant {

/// Ground truth of a MuJoCo plant: what no robot could report. Only render, experiments and tests
/// may include this header; nothing on the control path may.
///
/// Threads: the plant's thread; model() is constant after construction and may be read from any
/// thread.
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

  /// @returns how often the engine has warned since Create(): while compiling, and in steps. Zero
  /// in every healthy run. Real-time: noexcept, O(1).
  [[nodiscard]] virtual std::uint64_t warning_count() const noexcept = 0;

  /// @returns what it warned of, a line each; empty when warning_count() is zero.
  [[nodiscard]] virtual std::string DescribeWarnings() const = 0;
};

}  // namespace twin::plant
