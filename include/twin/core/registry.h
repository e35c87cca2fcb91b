#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "twin/core/error.h"
#include "twin/core/text.h"

namespace twin {

/// Factories of one kind by name. The program's main fills it from an explicit list.
///
/// Threads: one thread.
template <typename Factory>
class Registry {
 public:
  /// @param kind  of the factories' products, for messages: "backend".
  explicit Registry(std::string_view kind) : kind_(kind) {}

  /// @pre no factory of this name was added.
  void Add(std::string name, Factory factory) {
    for (const auto& entry : entries_) TWIN_CHECK(entry.first != name);
    entries_.emplace_back(std::move(name), std::move(factory));
  }

  /// @throws InputError listing the known names if the name is unknown.
  [[nodiscard]] const Factory& Find(std::string_view name) const {
    for (const auto& [known, factory] : entries_) {
      if (known == name) return factory;
    }
    throw InputError(UnknownName(kind_, name, Names()));
  }

  /// In order of addition.
  [[nodiscard]] std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& entry : entries_) names.push_back(entry.first);
    return names;
  }

 private:
  std::string kind_;
  std::vector<std::pair<std::string, Factory>> entries_;
};

}  // namespace twin
