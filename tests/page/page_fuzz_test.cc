#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "fuzz/mutations.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace twin::page::page_fuzz_test {
namespace {

void Feed(std::span<const std::byte> bytes) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

std::vector<std::byte> BytesOf(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

TEST(MessageFuzzTest, WhateverABrowserSaysIsAMessageOrNone) {
  const std::vector<std::vector<std::byte>> whole = {
      BytesOf(R"({"type":"hello","token":"0123456789abcdef0123456789abcdef"})"),
      BytesOf(R"({"type":"hands","axes":[0.5,-1,0,0,1e-3,1],"engaged":true,"sent_ms":12.5})"),
      BytesOf(R"({"type":"press","button":"gripper"})"),
      BytesOf(R"({"type":"camera","number":3})"),
      BytesOf(R"({"type":"record","on":true})"),
      BytesOf(R"({"type":"ping","sent_ms":1e3})"),
      BytesOf("{\"type\":\"st\\u006fp\"}")};
  constexpr std::uint64_t kSeed = 11;
  RecordProperty("seed", static_cast<int>(kSeed));
  fci::fuzz::FeedMutations(&Feed, whole, kSeed, 20'000);
}

}  // namespace
}  // namespace twin::page::page_fuzz_test
