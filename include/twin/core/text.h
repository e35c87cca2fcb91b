#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Text for messages and files. Threads: any.
namespace twin {

/// The candidate nearest to a misspelled `word` for "did you mean" messages; nullopt if more than a
/// third of the letters differ.
[[nodiscard]] std::optional<std::string_view> Nearest(std::string_view word,
                                                      std::span<const std::string_view> candidates);

/// Message for an unknown name of a `kind` of thing, listing the known ones.
[[nodiscard]] std::string UnknownName(std::string_view kind, std::string_view name,
                                      const std::vector<std::string>& known);

/// A YAML double-quoted scalar.
[[nodiscard]] std::string YamlQuoted(std::string_view text);

/// A field of a CSV row, quoted if it contains a comma, a quotation mark or a line break (RFC
/// 4180).
[[nodiscard]] std::string CsvField(std::string_view text);

/// A word of a command to copy: quoted where a shell would read more into it.
[[nodiscard]] std::string InShell(const std::string& word);

}  // namespace twin
