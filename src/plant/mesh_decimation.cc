#include "plant/meshes.h"

#include <array>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include <meshoptimizer.h>

#include "twin/core/error.h"

namespace twin::plant {
namespace {

/// MuJoCo accepts no smaller mesh.
constexpr std::size_t kLeastVertices = 4;

using Vector = std::array<float, 3>;

Vector At(const std::vector<float>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

void Append(const Vector& v, std::vector<float>& values) {
  values.insert(values.end(), v.begin(), v.end());
}

Vector Minus(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

float Dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector Cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The surface without normals, with vertices merged by position. (Otherwise the simplifier would
/// treat every crease as a seam and keep it.)
struct Surface {
  std::vector<float> places;             ///< x y z each
  std::vector<unsigned> corners;         ///< three positions per triangle
  std::vector<std::vector<int>> shared;  ///< the part's vertices at each position
};

Surface WithoutNormals(const MeshPart& part) {
  Surface surface;
  std::map<Vector, unsigned> numbers;
  std::vector<unsigned> place_of;
  for (std::size_t i = 0; i < part.vertices.size() / 3; ++i) {
    const Vector p = At(part.vertices, i);
    const auto [known, is_new] = numbers.emplace(p, static_cast<unsigned>(numbers.size()));
    if (is_new) {
      Append(p, surface.places);
      surface.shared.emplace_back();
    }
    surface.shared[known->second].push_back(static_cast<int>(i));
    place_of.push_back(known->second);
  }
  surface.corners.reserve(part.faces.size());
  for (const int vertex : part.faces) {
    surface.corners.push_back(place_of[static_cast<std::size_t>(vertex)]);
  }
  return surface;
}

/// @returns the corners of the remaining triangles.
std::vector<unsigned> Simplify(const Surface& surface, double error) {
  constexpr std::size_t kStride = 3 * sizeof(float);
  const std::size_t count = surface.places.size() / 3;
  const float extent = meshopt_simplifyScale(surface.places.data(), count, kStride);
  std::vector<unsigned> kept(surface.corners.size());
  kept.resize(meshopt_simplify(kept.data(), surface.corners.data(), surface.corners.size(),
                               surface.places.data(), count, kStride, /*target_index_count=*/0,
                               static_cast<float>(error) / extent, /*options=*/0,
                               /*result_error=*/nullptr));
  return kept;
}

/// Collects triangles and the vertices that they use.
class PartWriter {
 public:
  PartWriter(const MeshPart& from, const Surface& surface)
      : from_(from), surface_(surface), numbers_(from.vertices.size() / 3, -1) {
    part_.colour = from.colour;
  }

  void Add(const std::array<unsigned, 3>& corners) {
    const Vector a = At(surface_.places, corners[0]);
    const Vector outwards =
        Cross(Minus(At(surface_.places, corners[1]), a), Minus(At(surface_.places, corners[2]), a));
    for (const unsigned place : corners) part_.faces.push_back(Number(Facing(place, outwards)));
  }

  [[nodiscard]] MeshPart Take() { return std::move(part_); }

 private:
  /// @returns the vertex at a position with the normal nearest to a direction.
  [[nodiscard]] std::size_t Facing(unsigned place, const Vector& direction) const {
    const std::vector<int>& there = surface_.shared[place];
    auto best = static_cast<std::size_t>(there.front());
    for (const int other : there) {
      const auto vertex = static_cast<std::size_t>(other);
      if (Dot(At(from_.normals, vertex), direction) > Dot(At(from_.normals, best), direction)) {
        best = vertex;
      }
    }
    return best;
  }

  int Number(std::size_t vertex) {
    if (numbers_[vertex] < 0) {
      numbers_[vertex] = static_cast<int>(part_.vertices.size() / 3);
      Append(At(from_.vertices, vertex), part_.vertices);
      Append(At(from_.normals, vertex), part_.normals);
    }
    return numbers_[vertex];
  }

  const MeshPart& from_;
  const Surface& surface_;
  std::vector<int> numbers_;  ///< in the new part; -1: not added
  MeshPart part_;
};

/// Orders triangles so that those that share vertices follow each other.
void OrderForVertexReuse(MeshPart& part) {
  std::vector<unsigned> corners(part.faces.begin(), part.faces.end());
  meshopt_optimizeVertexCache(corners.data(), corners.data(), corners.size(),
                              part.vertices.size() / 3);
  part.faces.assign(corners.begin(), corners.end());
}

}  // namespace

MeshPart Decimate(const MeshPart& part, double error) {
  TWIN_CHECK(error > 0 && !part.faces.empty() && part.normals.size() == part.vertices.size());
  const Surface surface = WithoutNormals(part);
  const std::vector<unsigned> kept = Simplify(surface, error);
  PartWriter writer(part, surface);
  for (std::size_t i = 0; i < kept.size(); i += 3) writer.Add({kept[i], kept[i + 1], kept[i + 2]});
  MeshPart fewer = writer.Take();
  if (fewer.vertices.size() / 3 < kLeastVertices) return part;
  OrderForVertexReuse(fewer);
  return fewer;
}

}  // namespace twin::plant
