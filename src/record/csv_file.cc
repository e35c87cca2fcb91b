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

void CsvFile::AddFloat(double value) {
  Separate();
  const std::size_t begin = buffer_.size();
  fmt::format_to(std::back_inserter(buffer_), "{}", value);
  // Else it has a point, an exponent, or is nan or inf.
  if (buffer_.find_first_of(".en", begin) == std::string::npos) buffer_ += ".0";
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
