#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "plant/robot_description.h"

namespace twin::plant {

/// Triangles of one colour, in metres, in the frame of the file.
struct MeshPart {
  Colour colour{1, 1, 1, 1};
  std::vector<float> vertices;  ///< x y z each
  std::vector<float> normals;   ///< x y z each, one per vertex; empty: none
  std::vector<int> faces;       ///< three vertex numbers each, counter-clockwise from outside
};

/// Reads a visual mesh (Collada, STL, or what else assimp reads) and splits it by colour; materials
/// that look the same become one part.
///
/// A Collada file's up axis is ignored: Franka's files are written in the link's own axes.
/// @param bytes  content of the file. @param file  its name, for its format and for messages.
/// @throws InputError naming the file when it cannot be read or holds no triangles.
[[nodiscard]] std::vector<MeshPart> ImportVisualMesh(std::string_view bytes,
                                                     const std::string& file);

/// As ImportVisualMesh, but one part without colours and normals, equal vertices joined.
[[nodiscard]] MeshPart ImportCollisionMesh(std::string_view bytes, const std::string& file);

/// @returns `part` in MuJoCo's binary mesh format (MSH).
[[nodiscard]] std::string EncodeMsh(const MeshPart& part);

}  // namespace twin::plant
