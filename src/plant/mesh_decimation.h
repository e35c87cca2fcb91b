#pragma once

#include "plant/mesh_import.h"

namespace twin::plant {

/// The same surface with fewer triangles, to be drawn.
///
/// Edges are collapsed onto one of their own ends (meshoptimizer, by quadrics), so what vertices
/// are left are some of the part's. Of the normals given at a place a corner keeps the one that
/// fits its triangle best: curved faces stay smooth and creases sharp.
///
/// @param part  with a normal for each vertex. @param error  how far the surface may move, m, > 0:
/// root mean square over the area round a vertex; single points move by five times that.
/// @returns the part in the same colour; unchanged where less than a tetrahedron would be left.
/// Same input, same bytes. Threads: any.
[[nodiscard]] MeshPart Decimate(const MeshPart& part, double error);

}  // namespace twin::plant
