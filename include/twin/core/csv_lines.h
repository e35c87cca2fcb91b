#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <istream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace twin {

/// What a file of comma-separated values must look like. All that is referred to outlives it.
struct CsvFormat {
  std::span<const std::string_view> columns;  ///< names in the header, in order
  std::string_view units;                     ///< for messages: "time in s, q in rad"
  std::string_view rows = "rows";             ///< what a row is, several of them: "points"
};

/// Opens a file of text for reading. @param kind  for messages: "a trajectory file".
/// @throws InputError naming the path: no file, larger than `most_bytes`, not to be opened.
[[nodiscard]] std::ifstream OpenTextFile(const std::filesystem::path& path,
                                         std::uintmax_t most_bytes, std::string_view kind);

/// Text of a file for a message: short, in quotes, and printable whatever was in the file.
[[nodiscard]] std::string QuotedForMessage(std::string_view text);

/// The rows of a file of comma-separated values, one after the other. Strict: the header is the
/// format's, and every row has a field for each column. Spaces around fields, a byte order mark,
/// carriage returns and empty lines at the end are passed over. What does not fit is refused by an
/// InputError "<name>:<line>: what is wrong, what is accepted".
///
/// Threads: one thread. Not for real time.
class CsvLines {
 public:
  /// Reads the header; of an empty file there is none, and no row.
  /// @param in    must outlive this. @param name  of the file, for messages.
  CsvLines(std::istream& in, std::string name, const CsvFormat& format);

  /// Goes to the next row. @returns whether there is one.
  bool Next();

  /// Of the row: "<name>:<line>".
  [[nodiscard]] const std::string& where() const noexcept { return where_; }
  [[nodiscard]] std::string_view field(std::size_t column) const { return fields_.at(column); }

  /// A field as a finite number. @param unit  for messages: "rad".
  [[nodiscard]] double Number(std::size_t column, std::string_view unit) const;

  /// Refuses a field: "<name>:<line>: column <its name> is <the field>; <why>".
  [[noreturn]] void Refuse(std::size_t column, std::string_view why) const;

 private:
  bool ReadLine();
  void Split();
  [[nodiscard]] std::string Header() const;

  std::istream& in_;
  std::string name_;
  CsvFormat format_;
  std::string line_;
  std::string where_;
  std::vector<std::string_view> fields_;  ///< of line_; at most one more than there are columns
  std::size_t count_ = 0;                 ///< of the line's fields
  std::size_t number_ = 0;                ///< of the line, from 1
};

}  // namespace twin
