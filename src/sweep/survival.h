#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "twin/sweep/merge.h"

namespace twin::sweep {

/// Counts when runs fail.
class SurvivalCount {
 public:
  /// Groups runs by the values of the first axis when a grid has at most eight of them; else all
  /// runs are one group.
  explicit SurvivalCount(const Sweep& sweep);

  void Add(const Case& one, const Result& result);

  /// In the order in which the groups came.
  [[nodiscard]] std::vector<SurvivalCurve> Curves() const;

 private:
  struct Group {
    std::string label;
    std::uint64_t runs = 0;
    double end_s = 0;
    std::map<std::int64_t, std::uint64_t> failures{};  ///< how many, by robot's time, ms
  };

  const Sweep& sweep_;
  const bool is_grouped_;
  std::vector<Group> groups_;
};

}  // namespace twin::sweep
