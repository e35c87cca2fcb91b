#include "scenario/profile_draw.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "scenario/schema.h"
#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/core/setting.h"

namespace twin::scenario {
namespace {

using Matrix = std::vector<std::vector<double>>;

/// Cholesky's factor. A pivot that is zero but for rounding makes a column of zeros.
Matrix RootOf(const Matrix& matrix, const YamlNode& node) {
  constexpr double kRounding = 1e-6;  // of the numbers in a file
  Matrix root(matrix.size(), std::vector<double>(matrix.size()));
  for (std::size_t c = 0; c < matrix.size(); ++c) {
    const auto rest = [&](std::size_t r) {
      double sum = matrix[r][c];
      for (std::size_t k = 0; k < c; ++k) sum -= root[r][k] * root[c][k];
      return sum;
    };
    const double pivot = rest(c);
    if (!(pivot >= -kRounding * std::abs(matrix[c][c]))) {
      node.Fail("is no covariance: it must be positive semi-definite");
    }
    if (pivot <= kRounding * matrix[c][c]) continue;
    root[c][c] = std::sqrt(pivot);
    for (std::size_t r = c + 1; r < matrix.size(); ++r) root[r][c] = rest(r) / root[c][c];
  }
  return root;
}

Matrix MatrixIn(const YamlNode& node, std::size_t size) {
  Matrix matrix;
  for (const YamlNode& row : node.Items()) {
    scenario::List(matrix.emplace_back(), [](double& x) {
      return Number(x, -1e18, 1e18);
    }).read(row);
    if (matrix.back().size() != size) row.Fail(fmt::format("needs {} numbers", size));
  }
  if (matrix.size() != size) node.Fail(fmt::format("needs {} rows, one for each key", size));
  for (std::size_t r = 0; r < size; ++r) {
    for (std::size_t c = 0; c < r; ++c) {
      const double largest = std::sqrt(std::abs(matrix[r][r] * matrix[c][c]));
      if (std::abs(matrix[r][c] - matrix[c][r]) <= 1e-6 * largest) continue;
      node.Fail(fmt::format("row {} and column {} differ; it must be symmetric", r + 1, r + 1));
    }
  }
  return matrix;
}

/// A number of a scenario, with the range that its key takes.
struct Bounded {
  double* value;
  double least;
  double most;
};

using Numbers = std::map<std::string, Bounded>;

void AddArray(Numbers& numbers, const std::string& key, std::span<double> values, double least,
              double most) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    numbers[fmt::format("{}[{}]", key, i)] = {&values[i], least, most};
  }
}

/// A body whose moments and products stand apart, as its keys have them.
struct Body {
  setting::Load* load;
  Vector3 moments;
  Vector3 products;
};

Body BodyOf(setting::Load& load) {
  const Matrix3& I = load.I_load;
  return {&load, {I[0], I[4], I[8]}, {I[3], I[6], I[7]}};
}

void AddBody(Numbers& numbers, const std::string& key, Body& body, double least_mass) {
  numbers[key + ".mass"] = {&body.load->m_load, least_mass, 100};
  AddArray(numbers, key + ".position", body.load->F_x_Cload, -10, 10);
  AddArray(numbers, key + ".inertia", body.moments, 0, 100);
  AddArray(numbers, key + ".products_of_inertia", body.products, -100, 100);
}

/// Takes the drawn inertia over if a body can have it.
void Store(const Body& body) {
  const auto [xx, yy, zz] = body.moments;
  const auto [xy, xz, yz] = body.products;
  setting::Load drawn = *body.load;
  drawn.I_load = {xx, xy, xz, xy, yy, yz, xz, yz, zz};
  if (!FindBadValue(drawn)) body.load->I_load = drawn.I_load;
  if (body.load->m_load == 0) body.load->I_load = {};
}

void AddPlant(Numbers& numbers, PlantSection& plant) {
  if (auto& law = plant.arm.friction_law) {
    AddArray(numbers, "plant.friction.viscous", law->viscous, 0, 100);
    AddArray(numbers, "plant.friction.coulomb", law->coulomb, 0, 100);
    AddArray(numbers, "plant.friction.offset", law->offset, -100, 100);
    AddArray(numbers, "plant.friction.steepness", law->steepness, 0.1, 1e4);
    AddArray(numbers, "plant.friction.shift", law->shift, -10, 10);
  }
  if (plant.arm.armature) AddArray(numbers, "plant.armature", *plant.arm.armature, 0, 10);
  AddArray(numbers, "plant.elasticity", plant.arm.stiffness, 1, 1e7);
  numbers["plant.mass_scale"] = {&plant.mass_scale, 0.5, 2};
  numbers["plant.noise.q"] = {&plant.noise_q, 0, 1};
  numbers["plant.noise.dq"] = {&plant.noise_dq, 0, 10};
  numbers["plant.noise.tau_J"] = {&plant.noise_tau_J, 0, 100};
}

}  // namespace

Covariance CovarianceIn(const YamlNode& node) {
  Covariance covariance;
  Value matrix = Anything();
  matrix.read = [&covariance](const YamlNode& of) {
    covariance.root = RootOf(MatrixIn(of, covariance.keys.size()), of);
  };
  Map map;
  map.Require("keys", scenario::List(covariance.keys, Text));
  map.Require("matrix", matrix);
  map.Read(node);
  return covariance;
}

void Draw(const Covariance& covariance, std::uint64_t seed, std::uint64_t draw,
          Scenario& scenario) {
  Numbers numbers;
  AddPlant(numbers, scenario.plant);
  double delay = ToSeconds(scenario.plant.arm.torque_delay);
  numbers["plant.delay.tau_J"] = {&delay, 0, ToSeconds(plant::kLongestTorqueDelay)};
  std::vector<Body> bodies{BodyOf(scenario.robot.load)};
  for (setting::Load& link : scenario.plant.arm.links) bodies.push_back(BodyOf(link));
  AddBody(numbers, "robot.load", bodies[0], 0);
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    AddBody(numbers, fmt::format("plant.links[{}]", i - 1), bodies[i], 1e-3);
  }
  const Random random(seed, RandomStream::kProfile);
  for (std::size_t r = 0; r < covariance.keys.size(); ++r) {
    const auto found = numbers.find(covariance.keys[r]);
    if (found == numbers.end()) {
      throw InputError(fmt::format("\"{}\" is no number of this profile that can be drawn",
                                   Shown(covariance.keys[r])));
    }
    const auto [value, least, most] = found->second;
    double by = 0;
    for (std::size_t c = 0; c <= r; ++c) {
      by += covariance.root[r][c] * random.Normal(draw, static_cast<std::uint32_t>(c));
    }
    *value = std::clamp(*value + by, least, most);
  }
  scenario.plant.arm.torque_delay = Duration(std::llround(delay * 1e9));
  std::ranges::for_each(bodies, Store);
}

}  // namespace twin::scenario
