#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "twin/record/columns.h"

namespace twin::record {

/// How a message carries a column.
enum class Coding : std::uint8_t {
  kDouble,
  kDoubles,  ///< repeated
  kTime,     ///< int64, ns
  kUint64,
  kUint32,
  kBool,
  kEnum,       ///< a text
  kErrors,     ///< repeated RobotError: names joined by '|'
  kViolation,  ///< a message: a sentence
  kString,
};

struct ColumnSource {
  std::vector<int> path;  ///< field numbers from the row's message down
  Coding coding = Coding::kDouble;
  std::vector<std::string> names{};  ///< kEnum: by number
  std::uint32_t most = UINT32_MAX;   ///< kUint32
};

/// Where a table's rows come from, at the place of its TableInfo.
struct TableSource {
  std::string type;  ///< full name of the topic's messages
  /// Field of the topic's message of which each occurrence is a row; 0: the message is the row. The
  /// first column is then a field of the topic's message, all others of the row's.
  int row_field = 0;
  std::vector<ColumnSource> columns{};
};

/// One for each of LogTables().
[[nodiscard]] const std::vector<TableSource>& TableSources();

/// @returns the source of a table of LogTables().
[[nodiscard]] const TableSource& SourceOf(const TableInfo& table);

}  // namespace twin::record
