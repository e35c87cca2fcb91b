#include "twin/record/columns.h"

#include <algorithm>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/text.h"

namespace twin::record {
namespace {

std::string_view NameOf(ColumnType type) {
  switch (type) {
    case ColumnType::kFloat64: return "float64";
    case ColumnType::kInt64: return "int64";
    case ColumnType::kUint64: return "uint64";
    case ColumnType::kUint32: return "uint32";
    case ColumnType::kBool: return "bool";
    case ColumnType::kText: return "text";
  }
  return "unknown";
}

std::string ShapeOf(const ColumnInfo& column) {
  if (column.width == 0) return "[n]";
  return column.is_vector ? fmt::format("[{}]", column.width) : std::string();
}

[[noreturn]] void FailUnknown(std::string_view name, std::string_view where,
                              std::span<const std::string_view> known) {
  const auto nearest = Nearest(name, known);
  throw InputError(
      fmt::format("{} no column {}{}; docs/reference/logs.md lists all", where, name,
                  nearest ? fmt::format("; did you mean {}?", *nearest) : std::string()));
}

}  // namespace

std::string ColumnInfo::ElementName(std::size_t i) const {
  if (!elements.empty()) return elements[i];
  return is_vector ? fmt::format("{}[{}]", name, i) : name;
}

std::size_t TableInfo::Find(std::string_view column) const {
  std::vector<std::string_view> known;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].name == column) return i;
    known.push_back(columns[i].name);
  }
  FailUnknown(column, fmt::format("table {} has", name), known);
}

std::vector<std::size_t> TableInfo::Choose(std::span<const std::string> names) const {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (i == 0 || names.empty() || std::ranges::find(names, columns[i].name) != names.end()) {
      chosen.push_back(i);
    }
  }
  return chosen;
}

const TableInfo& FindTable(std::string_view name) {
  std::vector<std::string> known;
  for (const TableInfo& table : LogTables()) {
    if (table.name == name) return table;
    known.push_back(table.name);
  }
  throw InputError(UnknownName("table", name, known));
}

void CheckColumns(std::span<const std::string> names) {
  std::vector<std::string_view> known;
  for (const TableInfo& table : LogTables()) {
    for (const ColumnInfo& column : table.columns) known.push_back(column.name);
  }
  for (const std::string& name : names) {
    if (std::ranges::find(known, name) == known.end()) FailUnknown(name, "a log has", known);
  }
}

std::string DescribeLogTables() {
  std::string text = "# Tables of a log\n";
  for (const TableInfo& table : LogTables()) {
    text += fmt::format("\n## {}\n\nTopic `{}`. {}\n\n| column | type | unit | meaning |\n",
                        table.name, table.topic, table.meaning);
    text += "|---|---|---|---|\n";
    for (const ColumnInfo& column : table.columns) {
      text += fmt::format("| `{}` | {}{} | {} | {}{} |\n", column.name, NameOf(column.type),
                          ShapeOf(column), column.unit, column.meaning,
                          column.may_be_absent ? "; may be absent" : "");
    }
  }
  return text;
}

Table Table::Between(std::int64_t from_ns, std::int64_t until_ns) const {
  const Column& times = *columns.front();
  const auto first_at = [&](std::int64_t ns) {
    std::size_t low = begin;
    std::size_t high = begin + rows;
    while (low < high) {
      const std::size_t middle = low + (high - low) / 2;
      if (times.At<std::int64_t>(middle) < ns) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low;
  };
  Table part = *this;
  part.begin = first_at(from_ns);
  part.rows = std::max(first_at(until_ns), part.begin) - part.begin;
  return part;
}

}  // namespace twin::record
