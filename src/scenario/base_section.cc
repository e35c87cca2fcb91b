#include "twin/scenario/base_section.h"

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::scenario {
void BaseSection::Validate() const {
  Duration end{};
  for (std::size_t i = 0; i < drive.size(); ++i) {
    if (drive[i].at < end) {
      throw InputError(
          fmt::format("base.drive[{}].at: {} s is before the end of the drive before it, {} s",
                      i + 1, ToSeconds(drive[i].at), ToSeconds(end)));
    }
    end = drive[i].at + drive[i].span;
  }
}

}  // namespace twin::scenario
