#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include <mujoco/mujoco.h>

#include "twin/plant/compiled_model.h"

namespace twin::planning {

/// Names of a model's parts: its bodies, and each shape fixed to the world. A part's number is that
/// of its body, or the number of bodies plus that of the shape.
class PartNames {
 public:
  explicit PartNames(const mjModel& model);

  [[nodiscard]] int OfShape(int geom) const noexcept { return of_shape_[geom]; }
  /// Valid as long as this object.
  [[nodiscard]] const std::string& NameOf(int part) const { return names_.at(part); }
  /// @throws InputError listing all parts if the name is unknown.
  [[nodiscard]] int Find(const std::string& name) const;

 private:
  std::vector<int> of_shape_;
  std::map<int, std::string> names_;
};

/// For each body the number of the arm's joints (1 to 7) that move it; 0 for fixed bodies.
[[nodiscard]] std::vector<int> JointsBefore(const plant::CompiledModel& compiled);

/// The body's free joint. @throws InputError listing the free bodies if it has none.
[[nodiscard]] int FreeJointOf(const mjModel& model, const std::string& body);

/// For each joint of the arm an upper bound, over all positions of the other joints, of the
/// distance from its axis to a shape beyond it, m. Computed from the distances between joints;
/// exact where the arm can be stretched.
/// @param data      after mj_kinematics(). @param joints_before  of bodies, as JointsBefore().
/// @param held      the free body at the flange, -1 for none.
[[nodiscard]] JointVector ReachOf(const plant::CompiledModel& compiled, const mjData& data,
                                  const std::vector<int>& joints_before, int held);

}  // namespace twin::planning
