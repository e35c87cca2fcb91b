#pragma once

#include <variant>

#include "twin/rt/delay_model.h"

namespace twin::scenario {

/// How long something takes: the parameters of an rt::DelayModel, as a value that can be compared
/// and written down.
struct Delay {
  using Law = std::variant<rt::ConstantDelay, rt::LogNormalDelay, rt::NormalDelay, rt::GammaDelay,
                           rt::EmpiricalDelay>;
  Law law;

  /// @throws InputError when a parameter is outside its range.
  [[nodiscard]] rt::DelayModel Model() const;
  bool operator==(const Delay& other) const;
};

}  // namespace twin::scenario
