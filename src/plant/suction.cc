#include "plant/suction.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "plant/applied_wrench.h"
#include "twin/core/time.h"

namespace twin::plant {
namespace {

constexpr std::size_t kRays = 16;
constexpr double kGive = 2e-3;    // of the lip, m; as the gap of its shapes (mjcf_writer.cc)
constexpr double kBehind = 5e-3;  // where rays begin, m: deeper than a touch

constexpr double kAir = 101'325;      // Pa
constexpr double kDensity = 1.2;      // kg/m^3
constexpr double kMost = 75'000;      // vacuum of the pump, Pa
constexpr double kDelivery = 0.2e-3;  // of air at kAir, m^3/s
constexpr double kVolume = 30e-6;     // m^3
constexpr double kBore = 4e-3;        // diameter, m
constexpr double kContraction = 0.6;

/// @returns distance along the ray to the shape; negative without a hit.
double Distance(const mjModel& model, const mjData& data, int geom, const Vector3& from,
                const mjtNum* along) noexcept {
  switch (model.geom_type[geom]) {
    case mjGEOM_MESH: return mj_rayMesh(&model, &data, geom, from.data(), along);
    case mjGEOM_HFIELD: return mj_rayHfield(&model, &data, geom, from.data(), along);
    default: break;
  }
  return mju_rayGeom(data.geom_xpos + 3 * geom, data.geom_xmat + 9 * geom,
                     model.geom_size + 3 * geom, from.data(), along, model.geom_type[geom]);
}

/// Radius of the link's lip; 0 of a link that is no cup.
double RadiusOf(const Link& link) noexcept {
  double radius = 0;
  for (const Shape& shape : link.collision) {
    if (shape.lip) radius = std::max(radius, std::hypot(shape.X_LS.p[0], shape.X_LS.p[1]));
  }
  return radius;
}

}  // namespace

Suction::Suction(const mjModel& model, const RobotDescription& robot) noexcept {
  for (const Link& link : robot.links) {
    const double radius = RadiusOf(link);
    if (radius == 0 || count_ == kMostCups) continue;
    cups_[count_++] = {mj_name2id(&model, mjOBJ_BODY, link.name.c_str()), radius};
  }
}

void Suction::Reset() noexcept {
  pulled_.count = 0;
  drive_ = {};
  sensors_ = {};
}

void Suction::Release(mjData& data) noexcept {
  for (const int body : pulled_.all()) mju_zero(data.xfrc_applied + 6 * body, 6);
  pulled_.count = 0;
}

void Suction::Apply(const mjModel& model, mjData& data) noexcept {
  double open = 0;
  for (const Cup& cup : std::span(cups_.data(), count_)) open += Pull(cup, model, data);
  Flow(open);
}

Suction::Touched Suction::TouchedBy(const Cup& cup, const mjModel& model,
                                    const mjData& data) noexcept {
  Touched touched;
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    if (model.geom_bodyid[contact.geom1] == cup.body) touched.Add(contact.geom2);
    if (model.geom_bodyid[contact.geom2] == cup.body) touched.Add(contact.geom1);
  }
  return touched;
}

double Suction::Pull(const Cup& cup, const mjModel& model, mjData& data) noexcept {
  const Touched touched = TouchedBy(cup, model, data);
  if (touched.count == 0) return 1;
  const double force =
      sensors_.vacuum * std::numbers::pi * cup.radius * cup.radius / static_cast<double>(kRays);
  const mjtNum* const R = data.xmat + 9 * cup.body;  // by rows
  const Vector3 out{R[2], R[5], R[8]};
  std::size_t open = 0;
  for (std::size_t ray = 0; ray < kRays; ++ray) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(ray) / kRays;
    const Vector3 local{cup.radius * std::cos(angle), cup.radius * std::sin(angle), 0};
    Vector3 rim{};
    mju_rotVecMat(rim.data(), local.data(), R);
    mju_addTo3(rim.data(), data.xpos + 3 * cup.body);
    Vector3 from{};
    mju_addScl3(from.data(), rim.data(), out.data(), -kBehind);
    double nearest = kBehind + kGive;
    int body = -1;
    for (const int geom : touched.all()) {
      const double distance = Distance(model, data, geom, from, out.data());
      if (distance < 0 || distance > nearest) continue;
      nearest = distance;
      body = model.geom_bodyid[geom];
    }
    if (body < 0) {
      ++open;
      continue;
    }
    Vector3 pull{};
    mju_scl3(pull.data(), out.data(), force);
    AddWrench(pull, {}, rim, cup.body, data);
    pulled_.Add(cup.body);
    if (body == 0) continue;  // the world
    mju_scl3(pull.data(), out.data(), -force);
    AddWrench(pull, {}, rim, body, data);
    pulled_.Add(body);
  }
  return static_cast<double>(open) / kRays;
}

// The step is implicit, p_k+1 = p_k + T dp/dt(p_k+1), a quadratic equation for the root of p: an
// open bore empties the volume in a few milliseconds.
void Suction::Flow(double open) noexcept {
  const double bores = open + (drive_.vents ? 1 : 0);
  const double let_in = kContraction * std::numbers::pi / 4 * kBore * kBore *
                        std::sqrt(2 / kDensity);  // of a bore, by the root of the vacuum
  const double gain = kCycleSeconds * kAir / kVolume;
  const double pumped = gain * std::clamp(drive_.power, 0.0, 1.0) * kDelivery;
  const double square = 1 + pumped / kMost;
  const double linear = gain * let_in * bores;
  const double known = sensors_.vacuum + pumped;
  const double root = (std::sqrt(linear * linear + 4 * square * known) - linear) / (2 * square);
  sensors_.vacuum = root * root;
}

}  // namespace twin::plant
