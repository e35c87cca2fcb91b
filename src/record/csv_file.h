#pragma once

#include <cstddef>
#include <filesystem>
#include <iterator>
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
    fmt::format_to(std::back_inserter(buffer_), "{}", value);
  }
  /// The shortest text that reads back, with a decimal point or an exponent: 1.0, 1e+22.
  void AddFloat(double value);
  /// Quotes text where necessary.
  void Add(std::string_view text);
  void EndRow();

  void Commit();

 private:
  void Separate();

  PartialFile file_;
  std::string buffer_;
  bool row_begun_ = false;
};

}  // namespace twin::record
