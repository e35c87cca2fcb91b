#pragma once

#include "plant/mesh_import.h"

namespace twin::plant {

/// The same surface with fewer triangles, for rendering.
///
/// Edges collapse onto one of their ends (meshoptimizer, quadric error), so the remaining vertices
/// are some of the part's. A corner takes, of the normals at its position, the one nearest to its
/// triangle's: curved faces stay smooth and creases sharp.
///
/// @param part  with a normal per vertex. @param error  largest displacement of the surface, m, >
/// 0: root mean square around a vertex; single points move up to five times as far.
/// @returns the part in the same colour; unchanged if less than a tetrahedron would remain.
/// Same input, same bytes. Threads: any.
[[nodiscard]] MeshPart Decimate(const MeshPart& part, double error);

}  // namespace twin::plant
