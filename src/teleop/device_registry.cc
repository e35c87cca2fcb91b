#include "twin/teleop/device_registry.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/check.h"
#include "twin/core/error.h"

namespace twin::teleop {

void DeviceRegistry::Add(std::string name, DeviceFactory factory) {
  TWIN_CHECK(std::ranges::none_of(entries_, [&](const auto& e) { return e.first == name; }));
  entries_.emplace_back(std::move(name), std::move(factory));
}

const DeviceFactory& DeviceRegistry::Find(std::string_view name) const {
  for (const auto& [known, factory] : entries_) {
    if (known == name) return factory;
  }
  throw InputError(
      fmt::format("device \"{}\" is unknown; there are: {}", name, fmt::join(Names(), ", ")));
}

std::vector<std::string> DeviceRegistry::Names() const {
  std::vector<std::string> names;
  names.reserve(entries_.size());
  for (const auto& [name, factory] : entries_) names.push_back(name);
  return names;
}

}  // namespace twin::teleop
