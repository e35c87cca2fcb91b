#include "record/mcap_format.h"

#include <zlib.h>

namespace twin::record::mcap {

std::uint32_t Crc32(std::uint32_t crc, std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      ::crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::span<const std::byte> AsBytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

void PutBytes(Bytes& out, std::span<const std::byte> bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}

void PutString(Bytes& out, std::string_view text) {
  Put(out, static_cast<std::uint32_t>(text.size()));
  PutBytes(out, AsBytes(text));
}

void PutMap(Bytes& out, const TextMap& map) {
  const std::size_t begin = BeginArray(out);
  for (const auto& [key, value] : map) {
    PutString(out, key);
    PutString(out, value);
  }
  EndArray(out, begin);
}

std::size_t BeginRecord(Bytes& out, Opcode opcode) {
  const std::size_t begin = out.size();
  Put(out, opcode);
  Put(out, std::uint64_t{0});
  return begin;
}

void EndRecord(Bytes& out, std::size_t begin) {
  const std::uint64_t length = out.size() - begin - kRecordHeaderBytes;
  std::memcpy(&out[begin + 1], &length, sizeof(length));
}

std::size_t BeginArray(Bytes& out) {
  const std::size_t begin = out.size();
  Put(out, std::uint32_t{0});
  return begin;
}

void EndArray(Bytes& out, std::size_t begin) {
  const auto length = static_cast<std::uint32_t>(out.size() - begin - sizeof(std::uint32_t));
  std::memcpy(&out[begin], &length, sizeof(length));
}

}  // namespace twin::record::mcap
