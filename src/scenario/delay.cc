#include "twin/scenario/delay.h"

#include <tuple>

namespace twin::scenario {
namespace {

auto Parameters(const rt::ConstantDelay& law) {
  return std::tie(law.value);
}
auto Parameters(const rt::LogNormalDelay& law) {
  return std::tie(law.median, law.sigma, law.offset);
}
auto Parameters(const rt::NormalDelay& law) {
  return std::tie(law.mean, law.sigma);
}
auto Parameters(const rt::GammaDelay& law) {
  return std::tie(law.shape, law.scale, law.offset);
}
auto Parameters(const rt::EmpiricalDelay& law) {
  return std::tie(law.edges, law.weights);
}

}  // namespace

rt::DelayModel Delay::Model() const {
  return std::visit([](const auto& parameters) { return rt::DelayModel(parameters); }, law);
}

bool Delay::operator==(const Delay& other) const {
  if (law.index() != other.law.index()) return false;
  return std::visit(
      [&other]<typename T>(const T& mine) {
        return Parameters(mine) == Parameters(std::get<T>(other.law));
      },
      law);
}

}  // namespace twin::scenario
