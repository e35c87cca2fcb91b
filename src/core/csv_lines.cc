#include "twin/core/csv_lines.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/error.h"

namespace twin {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view Trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace

std::ifstream OpenTextFile(const std::filesystem::path& path, std::uintmax_t most_bytes,
                           std::string_view kind) {
  std::error_code error;
  const bool is_file = std::filesystem::is_regular_file(path, error);
  if (!is_file) {
    throw InputError(fmt::format("{}: not a file that can be read{}", path.string(),
                                 error ? " (" + error.message() + ")" : ""));
  }
  const auto size = std::filesystem::file_size(path, error);
  if (!error && size > most_bytes) {
    throw InputError(
        fmt::format("{}: {} bytes; {} may have at most {}", path.string(), size, kind, most_bytes));
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw InputError(fmt::format("{}: cannot be opened; check its permissions", path.string()));
  }
  return file;
}

std::string QuotedForMessage(std::string_view text) {
  constexpr std::size_t kShown = 40;
  std::string shown = "'";
  for (const char c : text.substr(0, kShown)) {
    const auto code = static_cast<unsigned char>(c);
    shown += (code < 0x20 || code >= 0x7F) ? fmt::format("\\x{:02x}", code) : std::string(1, c);
  }
  shown += text.size() > kShown ? "...'" : "'";
  return shown;
}

CsvLines::CsvLines(std::istream& in, std::string name, const CsvFormat& format)
    : in_(in), name_(std::move(name)), format_(format) {
  fields_.reserve(format_.columns.size());
  if (!ReadLine()) return;
  if (line_.starts_with(kByteOrderMark)) line_.erase(0, kByteOrderMark.size());
  Split();
  if (count_ == format_.columns.size() && std::ranges::equal(fields_, format_.columns)) return;
  throw InputError(fmt::format("{}: the header is {}; it must be '{}' ({})", where_,
                               QuotedForMessage(line_), Header(), format_.units));
}

std::string CsvLines::Header() const {
  return fmt::format("{}", fmt::join(format_.columns, ","));
}

bool CsvLines::ReadLine() {
  if (!std::getline(in_, line_)) {
    if (in_.bad()) throw InputError(fmt::format("{}: reading failed", name_));
    return false;
  }
  if (line_.ends_with('\r')) line_.pop_back();
  where_ = fmt::format("{}:{}", name_, ++number_);
  return true;
}

void CsvLines::Split() {
  fields_.clear();
  count_ = 0;
  std::string_view rest = line_;
  while (true) {
    const auto comma = rest.find(',');
    if (++count_ <= format_.columns.size()) fields_.push_back(Trimmed(rest.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    rest.remove_prefix(comma + 1);
  }
}

bool CsvLines::Next() {
  std::string empty_line;
  while (ReadLine()) {
    if (Trimmed(line_).empty()) {
      if (empty_line.empty()) empty_line = where_;
      continue;
    }
    if (!empty_line.empty()) {
      throw InputError(
          fmt::format("{}: an empty line between {}; remove it", empty_line, format_.rows));
    }
    Split();
    if (count_ == format_.columns.size()) return true;
    throw InputError(fmt::format("{}: {} field{} in {}; {} are needed ({})", where_, count_,
                                 count_ == 1 ? "" : "s", QuotedForMessage(line_),
                                 format_.columns.size(), Header()));
  }
  return false;
}

double CsvLines::Number(std::size_t column, std::string_view unit) const {
  const std::string_view text = field(column);
  double value = 0;
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  if (result.ec == std::errc{} && result.ptr == end && std::isfinite(value)) return value;
  Refuse(column, fmt::format("it must be a finite number of {}, with a decimal point", unit));
}

void CsvLines::Refuse(std::size_t column, std::string_view why) const {
  throw InputError(fmt::format("{}: column {} is {}; {}", where_, format_.columns[column],
                               QuotedForMessage(field(column)), why));
}

}  // namespace twin
