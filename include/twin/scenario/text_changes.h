#pragma once

#include <filesystem>
#include <string>
#include <vector>

// Texts of scenarios as trees of keys and values, before anything is checked.
namespace twin::scenario {

/// A scenario's text with the values of another one laid over it: maps are merged key by key; any
/// other value replaces the old one; a null removes the key. Comments are lost.
///
/// Threads: any. @param file  names `text` in messages. @param changes  YAML or JSON; a map.
/// @throws InputError "<file>:<line>: ..." for what is not YAML, or no map.
[[nodiscard]] std::string WithChanges(const std::string& text, const std::filesystem::path& file,
                                      const std::string& changes);
/// With several laid over it, one after the other.
[[nodiscard]] std::string WithChanges(const std::string& text, const std::filesystem::path& file,
                                      const std::vector<std::string>& changes);

/// A scenario's text as JSON. Plain values that read as a number, true, false or null become one.
/// Threads: any. @throws InputError for what is not YAML, or no map.
[[nodiscard]] std::string ToJson(const std::string& text, const std::filesystem::path& file);

}  // namespace twin::scenario
