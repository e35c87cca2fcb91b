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

/// Format of a file of comma-separated values. Referenced data must outlive it.
struct CsvFormat {
  std::span<const std::string_view> columns;  ///< header, in order
  std::string_view units;                     ///< for messages: "time in s, q in rad"
  std::string_view rows = "rows";             ///< for messages, name of the rows: "points"
};

/// Opens a text file for reading. @param kind  for messages: "a trajectory file".
/// @throws InputError naming the path: not found, larger than `most_bytes`, or not readable.
[[nodiscard]] std::ifstream OpenTextFile(const std::filesystem::path& path,
                                         std::uintmax_t most_bytes, std::string_view kind);

/// Text of a file for a message: short, quoted, and printable whatever its bytes.
[[nodiscard]] std::string QuotedForMessage(std::string_view text);

/// Reads a file of comma-separated values row by row. Strict: the header must match the format, and
/// every row must have a field per column. Spaces around fields, a byte order mark, carriage
/// returns and empty lines at the end are ignored. Anything else raises InputError "<name>:<line>:
/// what is wrong, what is accepted".
///
/// Threads: one thread. Not for real time.
class CsvLines {
 public:
  /// Reads the header; an empty file has neither header nor rows.
  /// @param in    must outlive this. @param name  of the file, for messages.
  CsvLines(std::istream& in, std::string name, const CsvFormat& format);

  /// Advances to the next row. @returns whether there is one.
  bool Next();

  /// Location of the row: "<name>:<line>".
  [[nodiscard]] const std::string& where() const noexcept { return where_; }
  [[nodiscard]] std::string_view field(std::size_t column) const { return fields_.at(column); }

  /// A field as a finite number. @param unit  for messages: "rad".
  [[nodiscard]] double Number(std::size_t column, std::string_view unit) const;

  /// Rejects a field: "<name>:<line>: column <its name> is <the field>; <why>".
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
  std::vector<std::string_view> fields_;  ///< of line_; at most one more than columns
  std::size_t count_ = 0;                 ///< number of fields in the line
  std::size_t number_ = 0;                ///< line number, from 1
};

}  // namespace twin
