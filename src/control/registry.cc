#include "twin/control/registry.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/check.h"
#include "twin/core/error.h"

namespace twin::control {

void ControllerRegistry::Add(std::string name, ControllerFactory factory) {
  TWIN_CHECK(std::ranges::none_of(entries_, [&](const auto& e) { return e.first == name; }));
  entries_.emplace_back(std::move(name), std::move(factory));
}

const ControllerFactory& ControllerRegistry::Find(std::string_view name) const {
  for (const auto& [known, factory] : entries_) {
    if (known == name) return factory;
  }
  throw InputError(
      fmt::format("controller \"{}\" is unknown; there are: {}", name, fmt::join(Names(), ", ")));
}

std::vector<std::string> ControllerRegistry::Names() const {
  std::vector<std::string> names;
  for (const auto& entry : entries_) names.push_back(entry.first);
  return names;
}

}  // namespace twin::control
