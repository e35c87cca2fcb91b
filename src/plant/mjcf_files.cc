#include "twin/plant/mjcf_files.h"

#include <cstddef>

namespace twin::plant {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

/// The name that ends before `equals`.
std::string_view AttributeBefore(std::string_view mjcf, std::size_t equals) {
  const std::string_view before = mjcf.substr(0, equals);
  const std::size_t end = before.find_last_not_of(kBlanks) + 1;  // 0: none
  const std::size_t blank = before.substr(0, end).find_last_of(" \t\r\n<>\"'");
  const std::size_t begin = blank == std::string_view::npos ? 0 : blank + 1;
  return before.substr(begin, end - begin);
}

}  // namespace

NamedFiles FilesNamedIn(std::string_view mjcf) {
  NamedFiles named;
  for (std::size_t at = mjcf.find('='); at != std::string_view::npos; at = mjcf.find('=', at)) {
    const std::string_view attribute = AttributeBefore(mjcf, at);
    const std::size_t quote = mjcf.find_first_not_of(kBlanks, ++at);
    if (quote == std::string_view::npos) break;
    if (mjcf[quote] != '"' && mjcf[quote] != '\'') continue;
    const std::size_t end = mjcf.find(mjcf[quote], quote + 1);
    if (end == std::string_view::npos) break;
    const std::string_view value = mjcf.substr(quote + 1, end - quote - 1);
    if (attribute.find("file") != std::string_view::npos) named.files.emplace_back(value);
    if (attribute.ends_with("dir")) named.folders.emplace_back(value);
    at = end + 1;
  }
  return named;
}

}  // namespace twin::plant
