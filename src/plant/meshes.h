#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "plant/robot_description.h"

namespace twin::plant {

/// Triangles of one colour, in metres, in the file's frame.
struct MeshPart {
  Colour colour{1, 1, 1, 1};
  std::vector<float> vertices;  ///< x y z each
  std::vector<float> normals;   ///< x y z each, one per vertex; may be empty
  std::vector<int> faces;       ///< three vertex indices each, counter-clockwise from outside
};

/// Reads a visual mesh (Collada, STL, or another format of assimp) and splits it by colour;
/// materials of equal appearance become one part.
///
/// A Collada file's up axis is ignored: Franka's files use the link's own axes.
/// @param bytes  content of the file. @param file  its name, for format and messages.
/// @throws InputError naming the file if it is not readable or has no triangles.
[[nodiscard]] std::vector<MeshPart> ImportVisualMesh(std::string_view bytes,
                                                     const std::string& file);

/// As ImportVisualMesh, but one part without colours and normals, with equal vertices merged.
[[nodiscard]] MeshPart ImportCollisionMesh(std::string_view bytes, const std::string& file);

/// @returns `part` in MuJoCo's binary mesh format (MSH).
[[nodiscard]] std::string EncodeMsh(const MeshPart& part);

/// The same surface with fewer triangles, for rendering.
///
/// Edges collapse onto one of their ends (meshoptimizer, quadric error), so the remaining vertices
/// are some of the part's. A corner takes, of the normals at its position, the one nearest to its
/// triangle's: curved faces stay smooth and creases sharp. Triangles that share vertices follow
/// each other, so that Mesa, which keeps the last vertices, computes fewer of them twice.
///
/// @param part  with a normal per vertex. @param error  largest displacement of the surface, m, >
/// 0: root mean square around a vertex; single points move up to five times as far.
/// @returns the part in the same colour; unchanged if less than a tetrahedron would remain.
/// Same input, same bytes. Threads: any.
[[nodiscard]] MeshPart Decimate(const MeshPart& part, double error);

}  // namespace twin::plant
