#include "planning/shape_pairs.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace twin::planning {
namespace {

/// True if the model excludes the pair of bodies; MuJoCo 2.2.2 counts bodies from 1 there.
bool IsExcluded(const mjModel& model, int body_a, int body_b) {
  const auto [first, second] = std::minmax(body_a, body_b);
  const int signature = ((first + 1) << 16) + second + 1;
  const int* begin = model.exclude_signature;
  const int* end = begin + model.nexclude;
  return std::find(begin, end, signature) != end;
}

/// Bodies that cannot move relative to each other, and a body and its parent, make no contacts; the
/// world is the exception.
bool IsJoined(const mjModel& model, int body_a, int body_b) {
  const int a = model.body_weldid[body_a];
  const int b = model.body_weldid[body_b];
  if (a == b) return true;
  if (a == 0 || b == 0 || (model.opt.disableflags & mjDSBL_FILTERPARENT) != 0) return false;
  const int parent_a = model.body_weldid[model.body_parentid[a]];
  const int parent_b = model.body_weldid[model.body_parentid[b]];
  return a == parent_b || b == parent_a;
}

double Square(double x) {
  return x * x;
}

/// Squared distance of a point from a box, per axis of the box.
double SquaredDistanceFromBox(const mjModel& model, const mjData& data, int box, const double* p) {
  const double* centre = data.geom_xpos + 3 * box;
  const double* R = data.geom_xmat + 9 * box;
  const double* half = model.geom_size + 3 * box;
  const double d[3] = {p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]};
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double along = R[k] * d[0] + R[3 + k] * d[1] + R[6 + k] * d[2];
    sum += Square(std::max(0.0, std::abs(along) - half[k]));
  }
  return sum;
}

}  // namespace

bool CanCollide(const mjModel& model, int geom_a, int geom_b) {
  const int body_a = model.geom_bodyid[geom_a];
  const int body_b = model.geom_bodyid[geom_b];
  const bool masked = (model.geom_contype[geom_a] & model.geom_conaffinity[geom_b]) != 0 ||
                      (model.geom_contype[geom_b] & model.geom_conaffinity[geom_a]) != 0;
  const ShapePair pair = MakePair(model, geom_a, geom_b);
  const bool known =
      mjCOLLISIONFUNC[model.geom_type[pair.geom1]][model.geom_type[pair.geom2]] != nullptr;
  return masked && known && !IsJoined(model, body_a, body_b) && !IsExcluded(model, body_a, body_b);
}

ShapePair MakePair(const mjModel& model, int geom_a, int geom_b) {
  // By type, then by number, as in the engine: its narrow phase is not quite symmetric.
  if (std::pair(model.geom_type[geom_a], geom_a) > std::pair(model.geom_type[geom_b], geom_b)) {
    std::swap(geom_a, geom_b);
  }
  return {geom_a, geom_b, std::max(model.geom_margin[geom_a], model.geom_margin[geom_b])};
}

bool MayTouch(const mjModel& model, const mjData& data, int geom1, int geom2,
              double margin) noexcept {
  const double* p1 = data.geom_xpos + 3 * geom1;
  const double* p2 = data.geom_xpos + 3 * geom2;
  const double r2 = model.geom_rbound[geom2];
  if (model.geom_type[geom1] == mjGEOM_PLANE) {
    const double* R = data.geom_xmat + 9 * geom1;
    const double height = R[2] * (p2[0] - p1[0]) + R[5] * (p2[1] - p1[1]) + R[8] * (p2[2] - p1[2]);
    return height <= r2 + margin;
  }
  const double r1 = model.geom_rbound[geom1];
  const double squared = Square(p2[0] - p1[0]) + Square(p2[1] - p1[1]) + Square(p2[2] - p1[2]);
  if (squared > Square(r1 + r2 + margin)) return false;
  // Only mesh sorts after box, so a box may be either shape of the pair.
  if (model.geom_type[geom1] == mjGEOM_BOX &&
      SquaredDistanceFromBox(model, data, geom1, p2) > Square(r2 + margin)) {
    return false;
  }
  return model.geom_type[geom2] != mjGEOM_BOX ||
         SquaredDistanceFromBox(model, data, geom2, p1) <= Square(r1 + margin);
}

int NarrowPhase(const mjModel& model, const mjData& data, const ShapePair& pair, double margin,
                Contacts& contacts) {
  const mjfCollision collide =
      mjCOLLISIONFUNC[model.geom_type[pair.geom1]][model.geom_type[pair.geom2]];
  return collide(&model, &data, contacts.data(), pair.geom1, pair.geom2, margin);
}

}  // namespace twin::planning
