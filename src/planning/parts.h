#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include <mujoco/mujoco.h>

#include "twin/plant/compiled_model.h"

namespace twin::planning {

/// The parts of a model by name: its bodies, and each shape that is fixed to the world for itself.
/// A part's number is its body's, or the number of bodies plus that of the shape.
class PartNames {
 public:
  explicit PartNames(const mjModel& model);

  [[nodiscard]] int OfShape(int geom) const noexcept { return of_shape_[geom]; }
  /// Lives as long as this object.
  [[nodiscard]] const std::string& NameOf(int part) const { return names_.at(part); }
  /// @throws InputError naming all parts when there is none of that name.
  [[nodiscard]] int Find(const std::string& name) const;

 private:
  std::vector<int> of_shape_;
  std::map<int, std::string> names_;
};

/// For each body the number of the arm's joints (1 to 7) that move it; 0 for what stands still.
[[nodiscard]] std::vector<int> JointsBefore(const plant::CompiledModel& compiled);

/// The body's free joint. @throws InputError naming the bodies that have one when it has none.
[[nodiscard]] int FreeJointOf(const mjModel& model, const std::string& body);

/// For each joint of the arm the largest distance of a shape beyond it from its axis, whatever the
/// other joints do, m:  a bound by the distances from joint to joint, exact where the arm can be
/// stretched.
/// @param data      after mj_kinematics(). @param joints_before  of bodies, as JointsBefore().
/// @param held      the free body at the flange, -1 for none.
[[nodiscard]] JointVector ReachOf(const plant::CompiledModel& compiled, const mjData& data,
                                  const std::vector<int>& joints_before, int held);

}  // namespace twin::planning
