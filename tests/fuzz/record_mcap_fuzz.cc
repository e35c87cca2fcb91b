#include <cstddef>
#include <cstdint>
#include <span>

#include "twin/core/error.h"
#include "twin/record/column_reader.h"
#include "twin/record/log_reader.h"

/// Reads any bytes as a log, and as columns: an InputError is the only way in which that may fail.
/// Entry of libFuzzer; record_fuzz_test calls it too.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    twin::record::LogReader reader(std::as_bytes(std::span(data, size)), "fuzz");
    twin::record::LogEntry entry;
    while (reader.Next(entry)) {
    }
  } catch (const twin::InputError&) {
  }
  try {
    const twin::record::ColumnReader reader(std::as_bytes(std::span(data, size)), "fuzz");
    for (const twin::record::TableInfo& table : twin::record::LogTables()) {
      static_cast<void>(reader.Read(table, table.Choose({}), {}, 1));
    }
  } catch (const twin::InputError&) {
  }
  return 0;
}
