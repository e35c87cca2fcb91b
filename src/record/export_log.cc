#include "twin/record/export_log.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "record/column_decoder.h"
#include "record/csv_file.h"
#include "record/npz_file.h"
#include "twin/core/error.h"
#include "twin/record/column_reader.h"
#include "twin/record/columns.h"
#include "twin/record/log_reader.h"
#include "twin/record/mcap_reader.h"

namespace twin::record {
namespace {

void CreateFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) return;
  throw EnvironmentError(fmt::format("cannot create folder {}: {}; choose another one",
                                     folder.string(), error.message()));
}

/// Whether a table is exported when only some columns are.
bool IsWanted(const TableInfo& table, std::span<const std::string> names) {
  return names.empty() || std::ranges::any_of(table.columns, [&](const ColumnInfo& column) {
           return std::ranges::find(names, column.name) != names.end();
         });
}

void Count(const TableInfo& table, std::uint64_t rows, LogExport& written) {
  if (table.name == "cycles") written.cycles += rows;
  if (table.name == "ticks") written.ticks += rows;
  if (table.name == "events") written.events += rows;
}

/// A table as CSV: it begins with the first row, or at once if it is basic.
class CsvTable {
 public:
  CsvTable(const TableInfo& table, std::span<const std::string> names,
           const std::filesystem::path& folder)
      : decoder(table, table.Choose(names)), info_(table), path_(folder / (table.name + ".csv")) {
    if (table.is_basic) Begin();
  }

  RowDecoder decoder;

  /// Writes the decoded rows. @returns their number.
  std::size_t Flush() {
    RowBuffer& rows = decoder.rows();
    const std::size_t count = rows.rows;
    if (count > 0 && !file_) Begin();
    for (std::size_t row = 0; row < count; ++row) {
      for (const RowBuffer::Part& part : rows.parts) {
        for (std::size_t i = 0; i < part.width; ++i) AddValue(part, row * part.width + i);
      }
      file_->EndRow();
    }
    rows.Clear();
    return count;
  }

  void Commit() {
    if (file_) file_->Commit();
  }

  [[nodiscard]] const TableInfo& info() const { return info_; }

 private:
  void Begin() {
    file_.emplace(path_);
    for (const RowBuffer::Part& part : decoder.rows().parts) {
      for (std::size_t i = 0; i < part.width; ++i) {
        file_->Add(std::string_view(part.info->ElementName(i)));
      }
    }
    file_->EndRow();
  }

  void AddValue(const Column& column, std::size_t i) {
    switch (column.info->type) {
      case ColumnType::kFloat64: {
        const auto value = column.At<double>(i);
        if (column.info->may_be_absent && std::isnan(value)) {
          file_->Add(std::string_view());
        } else {
          file_->AddFloat(value);
        }
        return;
      }
      case ColumnType::kInt64: file_->Add(column.At<std::int64_t>(i)); return;
      case ColumnType::kUint64: file_->Add(column.At<std::uint64_t>(i)); return;
      case ColumnType::kUint32: file_->Add(column.At<std::uint32_t>(i)); return;
      case ColumnType::kBool: file_->Add(static_cast<int>(column.At<std::uint8_t>(i))); return;
      case ColumnType::kText:
        const auto code = static_cast<std::size_t>(column.At<std::int32_t>(i));
        file_->Add(std::string_view(column.texts[code]));
        return;
    }
  }

  const TableInfo& info_;
  std::filesystem::path path_;
  std::optional<CsvFile> file_;
};

}  // namespace

LogExport ExportCsv(const std::filesystem::path& log, const std::filesystem::path& folder,
                    std::span<const std::string> columns) {
  CheckColumns(columns);
  static_cast<void>(LogReader(log));  // refuses what is no log of ours
  McapReader reader(log);
  CreateFolder(folder);
  std::vector<std::unique_ptr<CsvTable>> tables;
  for (const TableInfo& table : LogTables()) {
    if (!IsWanted(table, columns)) continue;
    tables.push_back(std::make_unique<CsvTable>(table, columns, folder));
  }
  LogExport written;
  constexpr std::size_t kRows = 256;
  while (const auto message = reader.Next()) {
    try {
      for (const auto& table : tables) {
        if (!table->decoder.Takes(*message->channel)) continue;
        table->decoder.Decode(message->data);
        if (table->decoder.rows().rows < kRows) continue;
        Count(table->info(), table->Flush(), written);
      }
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: message {} of the file, on topic {}: {}", log.string(),
                                   reader.message_count(), message->channel->topic, error.what()));
    }
  }
  for (const auto& table : tables) Count(table->info(), table->Flush(), written);
  for (const auto& table : tables) table->Commit();
  written.truncated = reader.truncated();
  return written;
}

LogExport ExportNpz(const std::filesystem::path& log, const std::filesystem::path& folder,
                    std::span<const std::string> columns) {
  CheckColumns(columns);
  const ColumnReader reader(log);
  CreateFolder(folder);
  LogExport written;
  written.truncated = reader.truncated();
  for (const TableInfo& info : LogTables()) {
    if (!IsWanted(info, columns)) continue;
    const Table table = reader.Read(info, info.Choose(columns), {}, 1);
    if (table.rows == 0 && !info.is_basic) continue;
    NpzFile file(folder / (info.name + ".npz"));
    for (const auto& column : table.columns) file.Add(*column, table.rows);
    file.Commit();
    Count(info, table.rows, written);
  }
  return written;
}

}  // namespace twin::record
