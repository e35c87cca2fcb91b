#include "campaign/shrink.h"

#include <cstddef>
#include <sstream>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace twin::campaign {
namespace {

using Lines = std::vector<std::string>;

Lines LinesOf(const std::string& text) {
  std::istringstream in(text);
  Lines lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string TextOf(const Lines& lines) {
  return fmt::format("{}\n", fmt::join(lines, "\n"));
}

/// The first line after a line and the deeper ones below it.
Lines::const_iterator EndOf(const Lines& lines, Lines::const_iterator line) {
  const std::size_t depth = line->find_first_not_of(' ');
  do ++line;
  while (line != lines.end() && line->find_first_not_of(' ') > depth);
  return line;
}

bool Stays(const std::string& line) {
  return line.starts_with("name:") || line.starts_with("description:");
}

}  // namespace

std::string Shrink(const std::string& yaml,
                   const std::function<bool(const std::string& less)>& fails) {
  Lines lines = LinesOf(yaml);
  for (bool smaller = true; std::exchange(smaller, false);) {
    for (std::size_t i = 0; i < lines.size();) {
      const auto line = lines.cbegin() + static_cast<std::ptrdiff_t>(i);
      Lines less(lines.cbegin(), line);
      less.insert(less.end(), EndOf(lines, line), lines.cend());
      if (Stays(*line) || !fails(TextOf(less))) {
        ++i;
        continue;
      }
      lines = std::move(less);
      smaller = true;
    }
  }
  return TextOf(lines);
}

}  // namespace twin::campaign
