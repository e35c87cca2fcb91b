#pragma once

#include <string>

// The format of scenario files, described from the same source as their reader and writer.
namespace twin::scenario {

/// JSON Schema (draft 2020-12) of scenario files: keys, spellings, units, defaults, and ranges of
/// plain numbers. It refuses no file that Load() takes, except for the spelling of plain values (a
/// number in quotes, a text that reads as a number). Load() also refuses what a schema cannot say:
/// quantities out of range, and sections that contradict each other.
[[nodiscard]] std::string JsonSchema();

/// The table of all keys with units, ranges, defaults and meaning, as Markdown:
/// models/scenarios/KEYS.md.
[[nodiscard]] std::string KeyTable();

}  // namespace twin::scenario
