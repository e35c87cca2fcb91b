#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// A log as tables of typed columns. One description, LogTables(), serves the exports, the Python
// package and the document of logs (docs/reference/logs.md).
namespace twin::record {

enum class ColumnType : std::uint8_t { kFloat64, kInt64, kUint64, kUint32, kBool, kText };

/// Bytes of a value: 8, 8, 8, 4, 1; of a text the 4 of its code.
[[nodiscard]] constexpr std::size_t BytesOf(ColumnType type) noexcept {
  switch (type) {
    case ColumnType::kBool: return 1;
    case ColumnType::kUint32:
    case ColumnType::kText: return 4;
    default: return 8;
  }
}

struct ColumnInfo {
  std::string name;
  ColumnType type = ColumnType::kFloat64;
  std::size_t width = 1;                ///< values in a row; 0: as many as the log has
  bool is_vector = false;               ///< `name[0]`, `name[1]` ... as text
  bool may_be_absent = false;           ///< an absent value is NaN, and empty in CSV
  std::string unit{};                   ///< empty: none, or several
  std::string meaning{};                ///< one sentence, with the frame
  std::vector<std::string> elements{};  ///< names of the values in a row; empty: by number

  /// Name of a value in a row: `q[3]`, `message_id`.
  [[nodiscard]] std::string ElementName(std::size_t i) const;
};

/// A table: what a topic of the log has, or a list within its messages.
struct TableInfo {
  std::string name;
  std::string topic;
  std::string meaning;
  bool is_basic = false;            ///< exported even without rows
  std::vector<ColumnInfo> columns;  ///< the first has the time of a row, ns

  /// @returns the number of a column. @throws InputError for an unknown name, with the nearest one.
  [[nodiscard]] std::size_t Find(std::string_view column) const;
  /// @returns the columns of this table among `names`, after the time; all without names; only the
  /// time if none is of this table.
  [[nodiscard]] std::vector<std::size_t> Choose(std::span<const std::string> names) const;
};

/// All tables: cycles, config, ticks, events, base, contacts, pushes, scenes, plans.
[[nodiscard]] const std::vector<TableInfo>& LogTables();
/// @throws InputError for an unknown name, listing the known ones.
[[nodiscard]] const TableInfo& FindTable(std::string_view name);
/// @throws InputError for a name that no table has, with the nearest one.
void CheckColumns(std::span<const std::string> names);

/// The tables as a Markdown document: topics, columns, types, units.
[[nodiscard]] std::string DescribeLogTables();

/// The values of one column.
struct Column {
  const ColumnInfo* info = nullptr;
  std::size_t width = 1;            ///< as info->width, or found in the log
  std::vector<std::byte> values{};  ///< row after row, little-endian
  /// kText: the texts that codes (int32) number. Names of an enumeration are all there, in its
  /// order; of other texts, "" first, then each in order of its first row.
  std::vector<std::string> texts{};

  template <class T>
  [[nodiscard]] T At(std::size_t i) const noexcept {
    T value;
    std::memcpy(&value, values.data() + i * sizeof(T), sizeof(T));
    return value;
  }
};

/// Rows of a table. Columns are shared by its slices.
struct Table {
  const TableInfo* info = nullptr;
  std::size_t begin = 0;  ///< first row in the columns
  std::size_t rows = 0;
  std::vector<std::shared_ptr<const Column>> columns{};  ///< the first has the time

  /// Rows with from_ns <= time < until_ns. @pre times rise.
  [[nodiscard]] Table Between(std::int64_t from_ns, std::int64_t until_ns) const;
};

/// Part of a run.
struct Interval {
  std::int64_t from_ns = std::numeric_limits<std::int64_t>::min();
  std::int64_t until_ns = std::numeric_limits<std::int64_t>::max();  ///< exclusive

  [[nodiscard]] bool Has(std::int64_t ns) const noexcept { return from_ns <= ns && ns < until_ns; }
};

}  // namespace twin::record
