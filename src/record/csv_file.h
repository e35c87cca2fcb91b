#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "twin/record/partial_file.h"

namespace twin::record {

/// A CSV file being written: `.partial` until Commit(), removed without it.
///
/// Threads: one thread. Real-time: no. Errors: those of PartialFile.
class CsvFile {
 public:
  explicit CsvFile(const std::filesystem::path& path);

  /// Appends a field to the row.
  template <class Number>
  void Add(Number value) {
    Separate();
    buffer_ += fmt::format("{}", value);
  }
  /// Quotes text where necessary.
  void Add(std::string_view text);
  /// `name[0]`, `name[1]` ...
  void AddNames(std::string_view name, std::size_t size);
  void AddValues(std::span<const double> values);
  void EndRow();

  void Commit();

 private:
  void Separate();

  PartialFile file_;
  std::string buffer_;
  bool row_begun_ = false;
};

}  // namespace twin::record
