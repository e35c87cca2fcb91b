#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenario/yaml_node.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {

/// The covariance of a profile's numbers.
struct Covariance {
  std::vector<std::string> keys;
  std::vector<std::vector<double>> root;  ///< lower triangle L, the matrix is L L^T
};

/// @throws InputError naming file and line: not symmetric, not positive semi-definite, ...
[[nodiscard]] Covariance CovarianceIn(const YamlNode& node);

/// Moves the scenario's numbers by a draw. @param seed  of the profile. @param draw  from 1.
/// @throws InputError naming a key of which the scenario has no number.
void Draw(const Covariance& covariance, std::uint64_t seed, std::uint64_t draw, Scenario& scenario);

}  // namespace twin::scenario
