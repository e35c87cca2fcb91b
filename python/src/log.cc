#include <algorithm>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "log_arrow.h"
#include "twin/core/error.h"
#include "twin/record/column_reader.h"
#include "twin/record/columns.h"
#include "twin/run/result_folder.h"

namespace twin::python {
namespace {

using record::Column;
using record::ColumnReader;
using record::ColumnType;
using record::Table;
using record::TableInfo;
using ColumnArray = nb::ndarray<nb::numpy, nb::ro>;

nb::dlpack::dtype TypeOf(ColumnType type) {
  switch (type) {
    case ColumnType::kInt64: return nb::dtype<std::int64_t>();
    case ColumnType::kUint64: return nb::dtype<std::uint64_t>();
    case ColumnType::kUint32: return nb::dtype<std::uint32_t>();
    case ColumnType::kBool: return nb::dtype<bool>();
    case ColumnType::kText: return nb::dtype<std::int32_t>();
    default: return nb::dtype<double>();
  }
}

const std::shared_ptr<const Column>& ColumnOf(const Table& table, const std::string& name) {
  const record::ColumnInfo* const wanted = &table.info->columns[table.info->Find(name)];
  for (const auto& column : table.columns) {
    if (column->info == wanted) return column;
  }
  throw InputError(fmt::format("this log has no column {} in its {}", name, table.info->name));
}

/// A read-only array that shares the column's memory and keeps it.
ColumnArray ColumnArrayOf(const Table& table, const std::string& name) {
  const std::shared_ptr<const Column>& column = ColumnOf(table, name);
  const nb::capsule owner(new std::shared_ptr<const Column>(column), [](void* pointer) noexcept {
    delete static_cast<std::shared_ptr<const Column>*>(pointer);
  });
  const std::size_t shape[] = {table.rows, column->width};
  const std::byte* const values =
      column->values.data() + table.begin * column->width * record::BytesOf(column->info->type);
  return {values,  column->info->is_vector ? 2U : 1U, shape, owner,
          nullptr, TypeOf(column->info->type)};
}

std::vector<std::string> ColumnNamesOf(const Table& table) {
  std::vector<std::string> names;
  for (const auto& column : table.columns) names.push_back(column->info->name);
  return names;
}

/// The columns of both, of the same rows, in the table's order.
Table Joined(const Table& one, const Table& other) {
  TWIN_CHECK(one.info == other.info && one.begin == other.begin && one.rows == other.rows);
  Table joined = one;
  for (const auto& column : other.columns) {
    const auto after = std::ranges::lower_bound(joined.columns, column->info, {},
                                                [](const auto& known) { return known->info; });
    if (after == joined.columns.end() || (*after)->info != column->info) {
      joined.columns.insert(after, column);
    }
  }
  return joined;
}

Table Chosen(const Table& table, const std::vector<std::string>& names) {
  Table chosen = table;
  chosen.columns.clear();
  for (const std::string& name : names) chosen.columns.push_back(ColumnOf(table, name));
  return chosen;
}

/// A table of a log that is not ours. @param columns  name, values row after row in the column's
/// type, and the texts of a column of texts; the first is the time, which rises.
Table MakeTable(
    const std::string& name, std::size_t rows,
    const std::vector<std::tuple<std::string, nb::bytes, std::vector<std::string>>>& columns) {
  const TableInfo& info = record::FindTable(name);
  Table table{.info = &info, .begin = 0, .rows = rows, .columns = {}};
  for (const auto& [of, bytes, texts] : columns) {
    const record::ColumnInfo& column = info.columns[info.Find(of)];
    const std::size_t value = record::BytesOf(column.type);
    const auto* const begin = reinterpret_cast<const std::byte*>(bytes.c_str());
    const std::size_t width =
        column.width > 0 ? column.width : bytes.size() / value / std::max<std::size_t>(rows, 1);
    if (bytes.size() != rows * width * value) {
      throw InputError(fmt::format("column {} has {} values; it must have {} for each of {} rows",
                                   of, bytes.size() / value, width, rows));
    }
    Column made{.info = &column, .width = width};
    made.values.assign(begin, begin + bytes.size());
    made.texts = texts;
    const Table one{.info = &info,
                    .begin = 0,
                    .rows = rows,
                    .columns = {std::make_shared<const Column>(std::move(made))}};
    table = table.columns.empty() ? one : Joined(table, one);
  }
  return table;
}

/// Tables with name, topic, meaning and columns: name, type, width, unit, meaning, elements.
nb::list DescribeTables() {
  constexpr const char* kTypes[] = {"float64", "int64", "uint64", "uint32", "bool", "text"};
  nb::list tables;
  for (const TableInfo& table : record::LogTables()) {
    nb::list columns;
    for (const record::ColumnInfo& column : table.columns) {
      std::vector<std::string> elements;
      for (std::size_t i = 0; i < column.width; ++i) elements.push_back(column.ElementName(i));
      columns.append(nb::make_tuple(column.name, kTypes[static_cast<int>(column.type)],
                                    column.is_vector, column.unit, column.meaning, elements));
    }
    tables.append(nb::make_tuple(table.name, table.topic, table.meaning, columns));
  }
  return tables;
}

}  // namespace

void AddLog(nb::module_& module) {
  nb::class_<Table>(module, "LogTable")
      .def_prop_ro("rows", [](const Table& table) { return table.rows; })
      .def_prop_ro("names", &ColumnNamesOf)
      .def("array", &ColumnArrayOf, nb::arg("name"))
      .def(
          "texts",
          [](const Table& table, const std::string& name) { return ColumnOf(table, name)->texts; },
          nb::arg("name"))
      .def("between", &Table::Between, nb::arg("from_ns"), nb::arg("until_ns"))
      .def("joined", &Joined, nb::arg("other"))
      .def("chosen", &Chosen, nb::arg("names"))
      .def("arrow_stream", &ArrowStreamOf);

  nb::class_<ColumnReader>(module, "LogFile")
      .def(nb::init<const std::filesystem::path&>(), nb::arg("path"), nb::call_guard<GilReleased>())
      .def_prop_ro("scenario", [](const ColumnReader& log) { return log.run().scenario; })
      .def_prop_ro("scenario_yaml", [](const ColumnReader& log) { return log.run().scenario_yaml; })
      .def_prop_ro("seed", [](const ColumnReader& log) { return log.run().seed; })
      .def_prop_ro("version", [](const ColumnReader& log) { return log.run().version; })
      .def_prop_ro("drive", [](const ColumnReader& log) { return log.run().drive; })
      .def_prop_ro("truncated", &ColumnReader::truncated)
      .def_prop_ro("first_ns", &ColumnReader::first_ns)
      .def_prop_ro("last_ns", &ColumnReader::last_ns)
      .def(
          "bytes_in",
          [](const ColumnReader& log, std::int64_t from_ns, std::int64_t until_ns) {
            return log.BytesIn({from_ns, until_ns});
          },
          nb::arg("from_ns"), nb::arg("until_ns"))
      .def(
          "read",
          [](const ColumnReader& log, const std::string& table,
             const std::vector<std::string>& names, std::int64_t from_ns, std::int64_t until_ns,
             int threads) {
            const TableInfo& info = record::FindTable(table);
            for (const std::string& name : names) static_cast<void>(info.Find(name));
            return log.Read(info, info.Choose(names), {from_ns, until_ns}, threads);
          },
          nb::arg("table"), nb::arg("names"), nb::arg("from_ns"), nb::arg("until_ns"),
          nb::arg("threads"), nb::call_guard<GilReleased>());

  module.def("make_log_table", &MakeTable, nb::arg("name"), nb::arg("rows"), nb::arg("columns"));
  module.def(
      "log_tables", &DescribeTables,
      nb::sig("def log_tables() -> list[tuple[str, str, str, list[tuple[str, str, bool, str, "
              "str, list[str]]]]]"));
  module.def(
      "check_log_column",
      [](const std::string& table, const std::string& name) {
        static_cast<void>(record::FindTable(table).Find(name));
      },
      nb::arg("table"), nb::arg("name"));
  module.def(
      "check_log_columns",
      [](const std::vector<std::string>& names) { record::CheckColumns(names); }, nb::arg("names"));
  module.def("find_log", &run::FindLog, nb::arg("path"));
}

}  // namespace twin::python
