#pragma once

#include <cstdio>
#include <string_view>

namespace twin::cli {

/// Writes `text` to `stream` (stdout, stderr). A failure is ignored: a reader that went away or a
/// full disk must not end a run, nor the report of an error.
void Say(std::FILE* stream, std::string_view text) noexcept;

/// For commands whose result is what they print: makes sure that it got out.
/// @throws EnvironmentError when any of it did not.
void FinishOutput();

}  // namespace twin::cli
