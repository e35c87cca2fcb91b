#include "twin/render/scene_shapes.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/drawn_model.h"
#include "twin/core/error.h"

namespace twin::render {
namespace {

constexpr std::size_t kAlignment = 4;
constexpr int kHiddenGroup = 3;  ///< the first that Renderer does not draw

template <typename Number>
std::string Three(const Number* numbers) {
  return fmt::format("[{:.5g},{:.5g},{:.5g}]", numbers[0], numbers[1], numbers[2]);
}

/// Arrays one after the other, each aligned.
class Arrays {
 public:
  /// @returns the offset of the first value.
  template <typename Value>
  std::size_t Append(const Value* values, std::size_t count) {
    const std::size_t at = bytes_.size();
    bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(Value));
    bytes_.resize((bytes_.size() + kAlignment - 1) / kAlignment * kAlignment, '\0');
    return at;
  }
  [[nodiscard]] const std::string& bytes() const noexcept { return bytes_; }

 private:
  std::string bytes_;
};

/// Descriptions of what the geometries use, each in the order of its first use.
class UsedParts {
 public:
  /// @returns the number of the part that `describe()` describes; that of its first use, if any.
  template <typename Describe>
  std::size_t Add(int id, Describe&& describe) {
    const auto known = std::ranges::find(ids_, id);
    if (known == ids_.end()) {
      ids_.push_back(id);
      texts_.push_back(describe());
      return ids_.size() - 1;
    }
    return static_cast<std::size_t>(known - ids_.begin());
  }
  [[nodiscard]] std::string Text() const { return fmt::format("{}", fmt::join(texts_, ",")); }

 private:
  std::vector<int> ids_;
  std::vector<std::string> texts_;
};

std::string AppendMesh(const mjModel& model, int mesh, Arrays& arrays) {
  const std::ptrdiff_t first = std::ptrdiff_t{3} * model.mesh_vertadr[mesh];
  const auto vertices = static_cast<std::size_t>(model.mesh_vertnum[mesh]);
  const auto faces = static_cast<std::size_t>(model.mesh_facenum[mesh]);
  const std::size_t at = arrays.Append(model.mesh_vert + first, 3 * vertices);
  arrays.Append(model.mesh_normal + first, 3 * vertices);
  arrays.Append(model.mesh_face + std::ptrdiff_t{3} * model.mesh_faceadr[mesh], 3 * faces);
  return fmt::format(R"({{"at":{},"vertices":{},"faces":{}}})", at, vertices, faces);
}

std::string AppendTexture(const mjModel& model, int texture, Arrays& arrays) {
  const auto width = static_cast<std::size_t>(model.tex_width[texture]);
  const auto height = static_cast<std::size_t>(model.tex_height[texture]);
  const std::size_t at = arrays.Append(model.tex_rgb + model.tex_adr[texture], 3 * width * height);
  return fmt::format(R"({{"at":{},"width":{},"height":{}}})", at, width, height);
}

const char* TypeName(int type) {
  switch (type) {
    case mjGEOM_PLANE: return "plane";
    case mjGEOM_SPHERE: return "sphere";
    case mjGEOM_CAPSULE: return "capsule";
    case mjGEOM_ELLIPSOID: return "ellipsoid";
    case mjGEOM_CYLINDER: return "cylinder";
    case mjGEOM_BOX: return "box";
    default: return "mesh";
  }
}

/// Colour of a geometry by MuJoCo's rule: its own if it differs from the default, else its
/// material's.
const float* ColourOf(const mjModel& model, int geom) {
  constexpr std::array<float, 4> kDefault = {0.5F, 0.5F, 0.5F, 1};
  const float* const own = model.geom_rgba + std::ptrdiff_t{4} * geom;
  const int material = model.geom_matid[geom];
  if (material < 0 || !std::equal(kDefault.begin(), kDefault.end(), own)) return own;
  return model.mat_rgba + std::ptrdiff_t{4} * material;
}

/// Builds the description geometry by geometry.
class ShapesWriter {
 public:
  explicit ShapesWriter(const mjModel& model) : model_(model) {
    for (int geom = 0; geom < model.ngeom; ++geom) {
      if (model.geom_group[geom] < kHiddenGroup && ColourOf(model, geom)[3] > 0) Add(geom);
    }
  }

  [[nodiscard]] std::string Description() const;
  [[nodiscard]] const std::string& arrays() const noexcept { return arrays_.bytes(); }

 private:
  void Add(int geom);
  [[nodiscard]] int MeshOf(int geom);
  [[nodiscard]] int TextureOf(int geom);
  [[nodiscard]] std::string SkyText() const;
  [[nodiscard]] std::string LightsText() const;

  const mjModel& model_;
  Arrays arrays_;
  UsedParts meshes_;
  UsedParts textures_;
  std::vector<std::string> geoms_;
  int left_out_ = 0;
};

int ShapesWriter::MeshOf(int geom) {
  if (model_.geom_type[geom] != mjGEOM_MESH) return -1;
  const int mesh = model_.geom_dataid[geom];
  return static_cast<int>(meshes_.Add(mesh, [&] { return AppendMesh(model_, mesh, arrays_); }));
}

int ShapesWriter::TextureOf(int geom) {
  const int material = model_.geom_matid[geom];
  const int texture = material < 0 ? -1 : model_.mat_texid[material];
  if (texture < 0 || model_.geom_type[geom] != mjGEOM_PLANE ||
      model_.tex_type[texture] != mjTEXTURE_2D) {
    return -1;
  }
  return static_cast<int>(
      textures_.Add(texture, [&] { return AppendTexture(model_, texture, arrays_); }));
}

void ShapesWriter::Add(int geom) {
  if (model_.geom_type[geom] == mjGEOM_HFIELD) {
    ++left_out_;
    return;
  }
  const int material = model_.geom_matid[geom];
  const float* const colour = ColourOf(model_, geom);
  const mjtNum* const size = model_.geom_size + std::ptrdiff_t{3} * geom;
  const mjtNum* const quat = model_.geom_quat + std::ptrdiff_t{4} * geom;
  std::array<double, 2> repeat = {1, 1};
  if (material >= 0) {
    for (std::size_t i = 0; i < 2; ++i) {
      repeat[i] = static_cast<double>(model_.mat_texrepeat[2 * material + static_cast<int>(i)]);
      if (model_.mat_texuniform[material] != 0) repeat[i] *= 2 * size[i];
    }
  }
  geoms_.push_back(fmt::format(
      R"({{"body":{},"type":"{}","size":{},"pos":{},"quat":[{:.7g},{:.7g},{:.7g},{:.7g}],"colour":[{:.4g},{:.4g},{:.4g},{:.4g}],"specular":{:.4g},"shininess":{:.4g},"mesh":{},"texture":{},"repeat":[{:.5g},{:.5g}]}})",
      model_.geom_bodyid[geom], TypeName(model_.geom_type[geom]), Three(size),
      Three(model_.geom_pos + std::ptrdiff_t{3} * geom), quat[0], quat[1], quat[2], quat[3],
      colour[0], colour[1], colour[2], colour[3],
      material < 0 ? 0.5F : model_.mat_specular[material],
      material < 0 ? 0.5F : model_.mat_shininess[material], MeshOf(geom), TextureOf(geom),
      repeat[0], repeat[1]));
}

/// Mean colours of the upper and the lower face: a cube's faces stand below each other in the
/// order right, left, up, down, front, back.
std::string ShapesWriter::SkyText() const {
  constexpr std::size_t kUp = 2;
  constexpr std::size_t kDown = 3;
  const std::span<const int> types(model_.tex_type, static_cast<std::size_t>(model_.ntex));
  const auto found = std::ranges::find(types, static_cast<int>(mjTEXTURE_SKYBOX));
  if (found == types.end()) return "null";
  const auto texture = found - types.begin();
  const auto pixels = static_cast<std::size_t>(model_.tex_width[texture]) *
                      static_cast<std::size_t>(model_.tex_width[texture]);
  const bool is_cube = model_.tex_height[texture] == 6 * model_.tex_width[texture];
  const auto mean = [&](std::size_t face) {
    const mjtByte* const rgb =
        model_.tex_rgb + model_.tex_adr[texture] + (is_cube ? 3 * pixels * face : 0);
    std::array<double, 3> sum{};
    for (std::size_t i = 0; i < 3 * pixels; ++i) sum[i % 3] += rgb[i] / 255.0;
    for (double& value : sum) value /= static_cast<double>(pixels);
    return Three(sum.data());
  };
  return fmt::format("[{},{}]", mean(kUp), mean(kDown));
}

std::string ShapesWriter::LightsText() const {
  std::vector<std::string> lights;
  for (int light = 0; light < model_.nlight; ++light) {
    const std::ptrdiff_t at = std::ptrdiff_t{3} * light;
    if (model_.light_active[light] == 0) continue;
    lights.push_back(fmt::format(R"({{"to":{},"colour":{},"shadow":{}}})",
                                 Three(model_.light_dir0 + at), Three(model_.light_diffuse + at),
                                 model_.light_castshadow[light] != 0));
  }
  return fmt::format("{}", fmt::join(lights, ","));
}

std::string ShapesWriter::Description() const {
  const auto& headlight = model_.vis.headlight;
  const bool has_headlight = headlight.active != 0;
  constexpr std::array<float, 3> kDark = {};
  return fmt::format(
      R"({{"bodies":{},"base":{},"sky":{},"ambient":{},"headlight":{},"lights":[{}],"textures":[{}],"meshes":[{}],"geoms":[{}],"left_out":{}}})",
      model_.nbody, std::max(0, mj_name2id(&model_, mjOBJ_BODY, "panda_link0")), SkyText(),
      Three(has_headlight ? headlight.ambient : kDark.data()),
      Three(has_headlight ? headlight.diffuse : kDark.data()), LightsText(), textures_.Text(),
      meshes_.Text(), fmt::join(geoms_, ","), left_out_);
}

}  // namespace

std::string SceneShapes(const mjModel& model) {
  const ShapesWriter writer(model);
  std::string description = writer.Description();
  description.resize((description.size() + kAlignment - 1) / kAlignment * kAlignment, ' ');
  std::string file;
  for (std::size_t i = 0; i < 4; ++i) {
    file += static_cast<char>(description.size() >> (8 * i) & 0xff);
  }
  return file + description + writer.arrays();
}

void BodyPoses::FreeData::operator()(mjData* data) const noexcept {
  mj_deleteData(data);
}

BodyPoses::BodyPoses(const mjModel& model)
    : model_(model),
      data_(MujocoCall("poses of the bodies", [&] { return mj_makeData(&model); })),
      poses_(7 * static_cast<std::size_t>(model.nbody - 1)) {}

BodyPoses::~BodyPoses() = default;

std::span<const double> BodyPoses::At(std::span<const double> qpos) {
  TWIN_CHECK(qpos.size() == static_cast<std::size_t>(model_.nq));
  std::ranges::copy(qpos, data_->qpos);
  mj_kinematics(&model_, data_.get());
  double* out = poses_.data();
  for (std::ptrdiff_t body = 1; body < model_.nbody; ++body) {
    out = std::copy_n(data_->xpos + 3 * body, 3, out);
    out = std::copy_n(data_->xquat + 4 * body, 4, out);
  }
  return poses_;
}

}  // namespace twin::render
