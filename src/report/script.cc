#include "report/script.h"

namespace twin::report {

std::string Quote(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') quoted += '\'';
    quoted += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? ' ' : c;
  }
  return quoted + "'";
}

std::string Title(const RunData& run, std::string_view what) {
  return fmt::format(
      "{}: {}{}{}", run.scenario, what,
      run.abort ? fmt::format(", aborted at {:.4g} s: {}", run.abort->time, run.abort->name) : "",
      run.truncated ? " (the run was killed: its end is missing)" : "");
}

}  // namespace twin::report
