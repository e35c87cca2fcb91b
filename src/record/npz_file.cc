#include "record/npz_file.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "record/mcap_format.h"
#include "twin/core/error.h"

namespace twin::record {
namespace {

/// NumPy's name of a little-endian type.
std::string NpyType(ColumnType type) {
  switch (type) {
    case ColumnType::kFloat64: return "<f8";
    case ColumnType::kInt64: return "<i8";
    case ColumnType::kUint64: return "<u8";
    case ColumnType::kUint32: return "<u4";
    case ColumnType::kBool: return "|b1";
    case ColumnType::kText: return "<i4";
  }
  return {};
}

/// Code points of well-formed UTF-8.
std::u32string Decode(const std::string& text) {
  std::u32string points;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      points.push_back(byte);
    } else if (byte >= 0xC0) {
      points.push_back(byte & (byte >= 0xF0 ? 0x07U : byte >= 0xE0 ? 0x0FU : 0x1FU));
    } else {
      points.back() = points.back() << 6 | (byte & 0x3FU);
    }
  }
  return points;
}

constexpr std::uint32_t kLocalHeader = 0x04034b50;
constexpr std::uint32_t kDirectoryHeader = 0x02014b50;
constexpr std::uint32_t kDirectoryEnd = 0x06054b50;
constexpr std::uint16_t kVersion = 20;
constexpr std::uint16_t kUtf8Names = 1U << 11;
constexpr std::uint32_t kDate = (1U << 5 | 1U) << 16;  // 1980-01-01 00:00, the first that zip has

}  // namespace

NpzFile::NpzFile(const std::filesystem::path& path) : file_(path, PartialFile::Leftover::kRemove) {}

void NpzFile::Add(const Column& column, std::size_t rows) {
  const std::string& name = column.info->name;
  const bool is_vector = column.info->is_vector;
  AddMember(name, NpyType(column.info->type),
            is_vector ? fmt::format("({}, {})", rows, column.width) : fmt::format("({},)", rows),
            column.values);
  if (column.info->type != ColumnType::kText) return;
  std::size_t longest = 1;
  std::vector<std::u32string> texts;
  for (const std::string& text : column.texts) {
    texts.push_back(Decode(text));
    longest = std::max(longest, texts.back().size());
  }
  for (std::u32string& text : texts) text.resize(longest);
  std::u32string all;
  for (const std::u32string& text : texts) all += text;
  AddMember(name + ".names", fmt::format("<U{}", longest), fmt::format("({},)", texts.size()),
            std::as_bytes(std::span(all)));
}

void NpzFile::AddMember(const std::string& name, const std::string& type, const std::string& shape,
                        std::span<const std::byte> values) {
  constexpr std::size_t kAlign = 64;
  constexpr std::size_t kPreamble = 10;
  std::string npy =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", type, shape);
  npy.append((2 * kAlign - (npy.size() + 1 + kPreamble) % kAlign) % kAlign, ' ');
  npy += '\n';
  mcap::Bytes head;
  mcap::PutBytes(head, mcap::AsBytes(std::string_view("\x93NUMPY\x01\x00", 8)));
  mcap::Put(head, static_cast<std::uint16_t>(npy.size()));
  mcap::PutBytes(head, mcap::AsBytes(npy));

  const std::string path = name + ".npy";
  const std::uint64_t size = head.size() + values.size();
  const std::uint64_t offset = file_.size();
  if (size + offset + directory_.size() > std::numeric_limits<std::uint32_t>::max() - 1024) {
    throw InputError(fmt::format("{} would be larger than 4 GiB; export fewer columns, or as CSV",
                                 file_.path().string()));
  }
  mcap::Bytes common;  // what a member's header and the directory both say
  mcap::Put(common, kVersion);
  mcap::Put(common, kUtf8Names);
  mcap::Put(common, std::uint16_t{0});  // stored
  mcap::Put(common, kDate);
  mcap::Put(common, mcap::Crc32(mcap::Crc32(0, head), values));
  mcap::Put(common, static_cast<std::uint32_t>(size));
  mcap::Put(common, static_cast<std::uint32_t>(size));
  mcap::Put(common, static_cast<std::uint16_t>(path.size()));
  mcap::Put(common, std::uint16_t{0});  // extra field

  mcap::Bytes local;
  mcap::Put(local, kLocalHeader);
  mcap::PutBytes(local, common);
  mcap::PutBytes(local, mcap::AsBytes(path));
  mcap::PutBytes(local, head);
  file_.Write(local);
  file_.Write(values);

  mcap::Put(directory_, kDirectoryHeader);
  mcap::Put(directory_, kVersion);  // made by
  mcap::PutBytes(directory_, common);
  mcap::PutBytes(directory_, mcap::Bytes(2 + 2 + 2 + 4));  // comment, disk, attributes
  mcap::Put(directory_, static_cast<std::uint32_t>(offset));
  mcap::PutBytes(directory_, mcap::AsBytes(path));
  ++members_;
}

void NpzFile::Commit() {
  const std::uint64_t offset = file_.size();
  mcap::Bytes end = directory_;
  mcap::Put(end, kDirectoryEnd);
  mcap::Put(end, std::uint32_t{0});  // disks
  mcap::Put(end, members_);
  mcap::Put(end, members_);
  mcap::Put(end, static_cast<std::uint32_t>(directory_.size()));
  mcap::Put(end, static_cast<std::uint32_t>(offset));
  mcap::Put(end, std::uint16_t{0});  // comment
  file_.Write(end);
  file_.Commit();
}

}  // namespace twin::record
