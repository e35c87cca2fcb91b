#include "record/csv_file.h"

#include "twin/core/text.h"

namespace twin::record {
namespace {

/// Buffer size between two writes.
constexpr std::size_t kCsvBufferBytes = 1 << 18;

}  // namespace

CsvFile::CsvFile(const std::filesystem::path& path) : file_(path, PartialFile::Leftover::kRemove) {
  buffer_.reserve(kCsvBufferBytes);
}

void CsvFile::Add(std::string_view text) {
  Separate();
  buffer_ += CsvField(text);
}

void CsvFile::AddNames(std::string_view name, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    Separate();
    buffer_ += fmt::format("{}[{}]", name, i);
  }
}

void CsvFile::AddValues(std::span<const double> values) {
  for (const double value : values) Add(value);
}

void CsvFile::EndRow() {
  buffer_.push_back('\n');
  row_begun_ = false;
  if (buffer_.size() < kCsvBufferBytes) return;
  file_.Write(std::as_bytes(std::span(buffer_.data(), buffer_.size())));
  buffer_.clear();
}

void CsvFile::Commit() {
  file_.Write(std::as_bytes(std::span(buffer_.data(), buffer_.size())));
  file_.Commit();
}

void CsvFile::Separate() {
  if (row_begun_) buffer_.push_back(',');
  row_begun_ = true;
}

}  // namespace twin::record
