#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "twin/sweep/merge.h"

namespace twin::sweep {

/// A set of addresses, 16 bytes each.
class AddressSet {
 public:
  void Add(const std::string& address) { numbers_.push_back(NumberOf(address)); }
  /// Before Holds(), and after all Add().
  void Sort();
  [[nodiscard]] bool Holds(const std::string& address) const;

 private:
  using Number = std::array<std::uint64_t, 2>;
  [[nodiscard]] static Number NumberOf(const std::string& address);

  std::vector<Number> numbers_;
};

/// Looks through the folder's results. @param read, not_needed  sorted.
[[nodiscard]] LeftAside CountLeftAside(const std::filesystem::path& out, const AddressSet& read,
                                       const AddressSet& not_needed);

}  // namespace twin::sweep
