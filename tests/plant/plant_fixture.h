#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "twin/plant/mujoco_plant.h"

namespace twin::plant {

inline constexpr JointVector kReady{
    0, -0.78539816339744831, 0, -2.3561944901923448, 0, 1.5707963267948966, 0.78539816339744831};

inline std::filesystem::path SourceDir() {
  return TWIN_SOURCE_DIR;
}

/// Where scripts/setup puts the meshes.
inline std::filesystem::path MeshPackage() {
  return SourceDir() / ".data" / "panda_description";
}

/// Primitive shapes, no hand, no cache, frictionless, no armature: what formulas describe exactly.
inline MujocoPlantOptions BareOptions() {
  MujocoPlantOptions options;
  options.urdf = SourceDir() / "models" / "robots" / "panda" / "panda.urdf";
  options.hand = HandKind::kNone;
  options.friction = FrictionProfile::kNone;
  options.armature = false;
  return options;
}

/// What a run uses by default, on primitive shapes.
inline MujocoPlantOptions DefaultOptions() {
  MujocoPlantOptions options;
  options.urdf = BareOptions().urdf;
  options.scene = SourceDir() / "models" / "scenes" / "floor.xml";
  return options;
}

/// A folder of this test's own, removed at its end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() /
            (std::string("panda-twin-") + test->test_suite_name() + "." + test->name());
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  /// @returns the file's path.
  std::filesystem::path Write(const std::string& name, const std::string& content) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << content;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

inline std::string ReadText(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// @returns the text of the exception of type E that `call` throws; fails the test when there is
/// none.
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

}  // namespace twin::plant
