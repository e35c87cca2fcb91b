#include "twin/backend/registry.h"

#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/check.h"
#include "twin/core/error.h"

namespace twin::backend {

void Registry::Add(std::string name, Factory factory) {
  for (const auto& [known, unused] : entries_) TWIN_CHECK(known != name);
  entries_.emplace_back(std::move(name), std::move(factory));
}

const Factory& Registry::Find(std::string_view name) const {
  for (const auto& [known, factory] : entries_) {
    if (known == name) return factory;
  }
  throw InputError(
      fmt::format("backend \"{}\" does not exist; there is: {}", name, fmt::join(Names(), ", ")));
}

std::vector<std::string> Registry::Names() const {
  std::vector<std::string> names;
  names.reserve(entries_.size());
  for (const auto& [name, factory] : entries_) names.push_back(name);
  return names;
}

}  // namespace twin::backend
