#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace twin::plant {

/// What an MJCF text names outside itself, in the text's order.
struct NamedFiles {
  std::vector<std::string> files;    ///< file="...", fileright="..." etc.
  std::vector<std::string> folders;  ///< meshdir="...", assetdir="..." etc., where files may lie
};

/// Names what comments have, too. Threads: any. Not real-time.
[[nodiscard]] NamedFiles FilesNamedIn(std::string_view mjcf);

}  // namespace twin::plant
