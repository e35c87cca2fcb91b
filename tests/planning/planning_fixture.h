#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "twin/core/joint_vector.h"
#include "twin/core/random.h"
#include "twin/planning/arm_solutions.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::planning {

inline constexpr JointVector kReady{
    0, -0.78539816339744831, 0, -2.3561944901923448, 0, 1.5707963267948966, 0.78539816339744831};

inline std::filesystem::path SourceDir() {
  return TWIN_SOURCE_DIR;
}

/// The Panda with its hand on primitive shapes. @param scene  in models/scenes.
inline plant::MujocoPlantOptions Options(const std::string& scene) {
  plant::MujocoPlantOptions options;
  options.urdf = SourceDir() / "models" / "robots" / "panda" / "panda.urdf";
  options.scene = SourceDir() / "models" / "scenes" / scene;
  return options;
}

/// The same on the meshes that scripts/setup fetches.
inline plant::MujocoPlantOptions MeshOptions(const std::string& scene) {
  plant::MujocoPlantOptions options = Options(scene);
  options.mesh_package = SourceDir() / ".data" / "panda_description";
  return options;
}

inline bool HaveMeshes() {
  return std::filesystem::exists(MeshOptions("floor.xml").mesh_package);
}

/// The n-th of a sequence of configurations within the joint limits.
inline JointVector Drawn(std::uint64_t seed, std::uint64_t n) {
  const Random random(seed, RandomStream::kTest);
  const JointLimits limits = test::PandaLimits();
  JointVector q;
  for (std::size_t i = 0; i < kJoints; ++i) {
    q[i] = limits.q_min[i] +
           random.Uniform(n, static_cast<std::uint32_t>(i)) * (limits.q_max[i] - limits.q_min[i]);
  }
  return q;
}

/// A pose of the flange that points straight down, with the fingers to the left and the right.
inline Transform Down(double x, double y, double z) {
  const double s = std::sqrt(0.5);  // the hand is mounted at 45 degrees
  return {s, -s, 0, 0, -s, -s, 0, 0, 0, 0, -1, 0, x, y, z, 1};
}

/// The configuration next to the ready pose, one of many, that puts the flange there.
inline JointVector Reaching(const Transform& O_T_F) {
  const JointLimits limits = test::PandaLimits();
  JointVector nearest{};
  double least = 100;
  for (int k = -20; k <= 20; ++k) {
    const ArmSolutions solutions(O_T_F, kReady[6] + 0.1 * k);
    for (const JointVector& q : solutions.all()) {
      double furthest = 0;
      bool inside = true;
      for (std::size_t i = 0; i < kJoints; ++i) {
        furthest = std::max(furthest, std::abs(q[i] - kReady[i]));
        inside = inside && q[i] > limits.q_min[i] && q[i] < limits.q_max[i];
      }
      if (!inside || furthest >= least) continue;
      nearest = q;
      least = furthest;
    }
  }
  EXPECT_LT(least, 2) << "no configuration reaches the pose";
  return nearest;
}

/// The text of the exception of type E that `call` throws; fails the test when there is none.
template <typename E, typename Call>
std::string MessageOf(Call&& call) {
  try {
    call();
  } catch (const E& error) {
    return error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another exception: " << error.what();
    return {};
  }
  ADD_FAILURE() << "no exception";
  return {};
}

}  // namespace twin::planning
