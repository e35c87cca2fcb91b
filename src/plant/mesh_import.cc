#include "plant/meshes.h"

#include <algorithm>
#include <cstring>
#include <filesystem>

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <assimp/Importer.hpp>

#include "twin/core/error.h"

namespace twin::plant {
namespace {

constexpr unsigned kSteps = aiProcess_Triangulate | aiProcess_PreTransformVertices |
                            aiProcess_RemoveComponent | aiProcess_JoinIdenticalVertices |
                            aiProcess_SortByPType;
constexpr int kRemoved = aiComponent_TEXCOORDS | aiComponent_TANGENTS_AND_BITANGENTS |
                         aiComponent_COLORS | aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS |
                         aiComponent_TEXTURES | aiComponent_LIGHTS | aiComponent_CAMERAS |
                         aiComponent_NORMALS;
// Franka's files have one normal per face; smoothing up to this angle looks better and shares
// vertices, at a sixth of the memory.
constexpr float kSmoothingAngle_deg = 35;

/// @returns the scene, owned by `importer`.
const aiScene& Import(Assimp::Importer& importer, std::string_view bytes, const std::string& file,
                      unsigned further_steps) {
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, kRemoved);
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  importer.SetPropertyFloat(AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, kSmoothingAngle_deg);
  const std::string extension = std::filesystem::path(file).extension().string();
  const char* hint = extension.empty() ? "" : extension.c_str() + 1;
  const aiScene* scene =
      importer.ReadFileFromMemory(bytes.data(), bytes.size(), kSteps | further_steps, hint);
  if (scene == nullptr || scene->mNumMeshes == 0) {
    const std::string reason = importer.GetErrorString();
    throw InputError(fmt::format("{}: not a readable mesh: {}", file,
                                 reason.empty() ? "it holds no triangles" : reason));
  }
  return *scene;
}

Colour DiffuseColour(const aiScene& scene, const aiMesh& mesh) {
  aiColor4D colour(1, 1, 1, 1);
  scene.mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_COLOR_DIFFUSE, colour);
  return {colour.r, colour.g, colour.b, colour.a};
}

void Append(const aiMesh& mesh, bool with_normals, MeshPart& part) {
  const int first = static_cast<int>(part.vertices.size() / 3);
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const aiVector3D& v = mesh.mVertices[i];
    part.vertices.insert(part.vertices.end(), {v.x, v.y, v.z});
    if (!with_normals) continue;
    const aiVector3D& n = mesh.mNormals[i];
    part.normals.insert(part.normals.end(), {n.x, n.y, n.z});
  }
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    const aiFace& face = mesh.mFaces[i];
    for (unsigned k = 0; k < 3; ++k)
      part.faces.push_back(first + static_cast<int>(face.mIndices[k]));
  }
}

template <typename T>
void AppendBytes(const std::vector<T>& values, std::string& bytes) {
  const auto* begin = reinterpret_cast<const char*>(values.data());
  bytes.append(begin, values.size() * sizeof(T));
}

}  // namespace

std::vector<MeshPart> ImportVisualMesh(std::string_view bytes, const std::string& file) {
  Assimp::Importer importer;
  const aiScene& scene = Import(importer, bytes, file, aiProcess_GenSmoothNormals);
  std::vector<MeshPart> parts;
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[i];
    const Colour colour = DiffuseColour(scene, mesh);
    auto part = std::find_if(parts.begin(), parts.end(),
                             [&colour](const MeshPart& p) { return p.colour == colour; });
    if (part == parts.end()) {
      parts.emplace_back();
      part = parts.end() - 1;
      part->colour = colour;
    }
    Append(mesh, true, *part);
  }
  return parts;
}

MeshPart ImportCollisionMesh(std::string_view bytes, const std::string& file) {
  Assimp::Importer importer;
  const aiScene& scene = Import(importer, bytes, file, 0);
  MeshPart part;
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) Append(*scene.mMeshes[i], false, part);
  return part;
}

std::string EncodeMsh(const MeshPart& part) {
  const std::vector<int> header{static_cast<int>(part.vertices.size() / 3),
                                static_cast<int>(part.normals.size() / 3), 0,
                                static_cast<int>(part.faces.size() / 3)};
  std::string bytes;
  AppendBytes(header, bytes);
  AppendBytes(part.vertices, bytes);
  AppendBytes(part.normals, bytes);
  AppendBytes(part.faces, bytes);
  return bytes;
}

}  // namespace twin::plant
