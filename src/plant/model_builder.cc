#include "plant/model_builder.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <mutex>
#include <string_view>

#include <fmt/format.h>

#include "plant/base_joints.h"
#include "plant/meshes.h"
#include "plant/mjcf_writer.h"
#include "plant/scene_objects.h"
#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/plant/engine.h"
#include "twin/plant/model_cache.h"

namespace twin::plant {
namespace {

constexpr int kErrorSize = 1000;

/// MuJoCo's in-memory files. The structure takes 2 MB, hence not on the stack.
class VirtualFiles {
 public:
  VirtualFiles() : vfs_(std::make_unique<mjVFS>()) { mj_defaultVFS(vfs_.get()); }
  ~VirtualFiles() { mj_deleteVFS(vfs_.get()); }
  VirtualFiles(const VirtualFiles&) = delete;
  VirtualFiles& operator=(const VirtualFiles&) = delete;

  /// @param name  unused so far.
  void Add(const std::string& name, std::string_view bytes) {
    if (mj_makeEmptyFileVFS(vfs_.get(), name.c_str(), static_cast<int>(bytes.size())) != 0) {
      throw InputError(fmt::format("the model has too many files: no room for {}", name));
    }
    const int index = mj_findFileVFS(vfs_.get(), name.c_str());
    std::memcpy(vfs_->filedata[index], bytes.data(), bytes.size());
  }
  [[nodiscard]] const mjVFS* get() const noexcept { return vfs_.get(); }

 private:
  std::unique_ptr<mjVFS> vfs_;
};

bool HasMesh(const std::vector<Shape>& shapes, const std::string& uri) {
  for (const Shape& shape : shapes) {
    if (shape.kind == ShapeKind::kMesh && shape.mesh_uri == uri) return true;
  }
  return false;
}

/// Imports every mesh for all its uses.
void ImportMeshes(const ModelSources& sources, MeshAssets& visual, MeshAssets& collision) {
  int number = 0;
  for (const auto& [uri, mesh] : sources.meshes) {
    bool seen = false;
    bool touched = false;
    for (const ArmSources& arm : sources.arms) {
      for (const Link& link : arm.robot.links) {
        seen = seen || HasMesh(link.visual, uri);
        touched = touched || HasMesh(link.collision, uri);
      }
    }
    const auto name = [&number](std::string_view use) {
      return fmt::format("panda_twin_{}_{}.msh", use, number++);
    };
    if (seen) {
      for (const MeshPart& part : ImportVisualMesh(mesh.bytes, mesh.file.string())) {
        const double error = sources.visual_error;
        visual[uri].push_back(
            {name("visual"), EncodeMsh(error > 0 ? Decimate(part, error) : part), part.colour});
      }
    }
    if (touched) {
      const MeshPart part = ImportCollisionMesh(mesh.bytes, mesh.file.string());
      collision[uri].push_back({name("collision"), EncodeMsh(part), part.colour});
    }
  }
}

void AddAssets(const MeshAssets& assets, VirtualFiles& files) {
  for (const auto& [uri, parts] : assets) {
    for (const MeshAsset& part : parts) files.Add(part.file, part.msh);
  }
}

std::string SceneName(const ModelSources& sources) {
  return sources.scene_file.empty() ? "the built-in scene" : sources.scene_file.string();
}

bool Near(double a, double b) {
  return std::abs(a - b) <= 1e-9 * (1 + std::abs(b));
}

/// @returns the difference of the compiled body from `link`; empty if none.
std::string Difference(const mjModel& model, int body, const Link& link) {
  const Inertial wanted = link.inertial.value_or(Inertial{});
  if (!Near(model.body_mass[body], wanted.mass)) {
    return fmt::format("mass {} kg instead of {}", model.body_mass[body], wanted.mass);
  }
  const double trace = wanted.I[0] + wanted.I[4] + wanted.I[8];
  const mjtNum* inertia = model.body_inertia + std::ptrdiff_t{3} * body;
  if (!Near(inertia[0] + inertia[1] + inertia[2], trace)) return "another inertia";
  for (int k = 0; k < 3; ++k) {
    if (!Near(model.body_pos[3 * body + k], link.X_PL.p[k])) return "another place";
    if (link.inertial && !Near(model.body_ipos[3 * body + k], wanted.com[k])) {
      return "another centre of mass";
    }
  }
  return {};
}

/// A scene's compiler settings apply to the whole document (MJCF has one <compiler>), so they could
/// silently change the robot.
void RequireRobotUnchanged(const ModelSources& sources, const RobotDescription& robot,
                           const mjModel& model) {
  for (const Link& link : robot.links) {
    const int body = mj_name2id(&model, mjOBJ_BODY, link.name.c_str());
    const std::string difference = body < 0 ? "no body" : Difference(model, body, link);
    if (difference.empty()) continue;
    throw InputError(fmt::format(
        "{}: the scene changes the robot: link '{}' gets {}. Its <compiler> must not set "
        "coordinate, "
        "fusestatic, inertiafromgeom, boundmass, boundinertia, balanceinertia or settotalmass",
        SceneName(sources), link.name, difference));
  }
  if (model.opt.timestep != kCycleSeconds) throw EngineFault("the step is not 1 ms");
}

/// A finger's stops are a micrometre beyond its range, so that a finger at its limit adds no
/// constraint to solve in every step.
constexpr double kFingerClearance = 1e-6;

void SetJointRanges(const RobotDescription& robot, mjModel& model) {
  for (const Link& link : robot.links) {
    if (!HasRange(link.joint_kind)) continue;
    const std::ptrdiff_t joint = mj_name2id(&model, mjOBJ_JOINT, link.joint.c_str());
    const double clearance = link.joint_kind == JointKind::kPrismatic ? kFingerClearance : 0;
    model.jnt_range[2 * joint] = link.q_min - clearance;
    model.jnt_range[2 * joint + 1] = link.q_max + clearance;
  }
}

}  // namespace

BuiltModel BuildModel(const ModelSources& sources) {
  MeshAssets visual;
  MeshAssets collision;
  ImportMeshes(sources, visual, collision);
  VirtualFiles files;
  AddAssets(visual, files);
  AddAssets(collision, files);
  files.Add(kSceneFile, sources.scene_text);
  // The document's path is in the scene's folder, so that files of the scene are found.
  const std::string name = (sources.scene_file.parent_path() / "panda_twin_model.xml").string();
  files.Add("panda_twin_model.xml", WriteMjcf(sources, visual, collision));

  std::string message(kErrorSize, '\0');
  const EngineWarnings warnings;
  BuiltModel built;
  // The engine's reader keeps one document per process.
  static std::mutex reader;
  const std::scoped_lock lock(reader);
  try {
    built.model.reset(mj_loadXML(name.c_str(), files.get(), message.data(), kErrorSize));
    mj_freeLastXML();  // otherwise the engine keeps copies of all meshes
  } catch (const EngineFault& fault) {
    message = fault.what();
  }
  message.resize(std::strlen(message.c_str()));
  std::replace(message.begin(), message.end(), '\n', ' ');
  if (!built.model) {
    throw InputError(fmt::format("{}: the engine does not accept robot and scene: {}",
                                 SceneName(sources), message));
  }
  built.warnings = warnings.texts();
  if (!message.empty()) built.warnings.push_back(message);
  for (const ArmSources& arm : sources.arms) {
    RequireRobotUnchanged(sources, arm.robot, *built.model);
    SetJointRanges(arm.robot, *built.model);
  }
  return built;
}

std::string SerializeModel(const mjModel& model) {
  std::string bytes(static_cast<std::size_t>(mj_sizeModel(&model)), '\0');
  mj_saveModel(&model, nullptr, bytes.data(), static_cast<int>(bytes.size()));
  return bytes;
}

ModelPointer DeserializeModel(const std::string& bytes) {
  VirtualFiles files;
  files.Add("panda_twin_model.mjb", bytes);
  ModelPointer model;
  try {
    const EngineWarnings warnings;
    model.reset(mj_loadModel("panda_twin_model.mjb", files.get()));
    if (model && warnings.texts().empty()) return model;
  } catch (const EngineFault&) {
    model.reset();
  }
  throw EnvironmentError("the engine cannot load a model it has compiled itself");
}

void PrepareEngine() {
  InstallEngineHandlers();
  if (mj_version() != mjVERSION_HEADER) {
    throw EnvironmentError(
        fmt::format("MuJoCo {} is installed, but this program was built for {}; rebuild it, or "
                    "install that one",
                    mj_version(), mjVERSION_HEADER));
  }
}

namespace {

/// With the objects of the first compilation, by any process.
BuiltModel Fetch(const MujocoPlantOptions& options, const ModelSources& sources) {
  if (options.cache.empty() || !sources.scene_is_self_contained) return BuildModel(sources);
  const ModelCache cache(options.cache);
  if (!options.rebuild_cache) {
    if (const auto bytes = cache.Load(sources.key)) {
      try {
        return {DeserializeModel(*bytes), {}};
      } catch (const EnvironmentError&) {
        // Complete, but not loadable by this engine: compile and replace it.
      }
    }
  }
  BuiltModel built = BuildModel(sources);
  // A model with warnings is recompiled each time, so that they appear each time.
  if (built.warnings.empty()) cache.Store(sources.key, SerializeModel(*built.model));
  return built;
}

}  // namespace

BuiltModel LoadOrBuild(const MujocoPlantOptions& options, const ModelSources& sources) {
  BuiltModel built = Fetch(options, sources);
  if (options.base) PlaceBase(options.base->start, sources.arms.front().robot, *built.model);
  ShapeObjects(options.objects, *built.model);
  return built;
}

}  // namespace twin::plant
