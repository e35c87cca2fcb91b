#include "plugins/ros2/type_description.h"

#include <array>
#include <string>
#include <vector>

#include <openssl/sha.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace twin::ros2 {
namespace {

std::string JsonOf(const Field& field) {
  return fmt::format(
      R"({{"name": "{}", "type": {{"type_id": {}, "capacity": {}, "string_capacity": {}, )"
      R"("nested_type_name": "{}"}}}})",
      field.name, field.type_id, field.capacity, field.string_capacity, field.nested);
}

std::string JsonOf(const std::string& name, const std::vector<Field>& fields) {
  std::vector<std::string> texts;
  for (const Field& field : fields) texts.push_back(JsonOf(field));
  return fmt::format(R"({{"type_name": "{}", "fields": [{}]}})", name, fmt::join(texts, ", "));
}

}  // namespace

std::string TypeDescription::ToJson() const {
  std::vector<std::string> referenced;
  for (const auto& [type, fields] : types) {
    if (type != name) referenced.push_back(JsonOf(type, fields));
  }
  return fmt::format(R"({{"type_description": {}, "referenced_type_descriptions": [{}]}})",
                     JsonOf(name, types.at(name)), fmt::join(referenced, ", "));
}

std::string TypeDescription::Hash() const {
  const std::string json = ToJson();
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(json.data()), json.size(), digest.data());
  return fmt::format("RIHS01_{:02x}", fmt::join(digest, ""));
}

std::string DdsName(std::string_view name) {
  std::string made;
  std::size_t begin = 0;
  for (std::size_t slash = name.find('/'); slash != std::string_view::npos;
       slash = name.find('/', begin)) {
    made += fmt::format("{}::", name.substr(begin, slash - begin));
    begin = slash + 1;
  }
  return fmt::format("{}dds_::{}_", made, name.substr(begin));
}

}  // namespace twin::ros2
