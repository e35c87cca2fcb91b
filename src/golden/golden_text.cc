#include "golden/golden_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include <cerrno>
#include <charconv>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>
#include <system_error>

#include "twin/core/error.h"
#include "twin/core/quantity.h"
#include "twin/core/text.h"

namespace twin::golden {
namespace {

constexpr int kFormat = 1;

/// Hashes as one string, because YAML parses long lists slowly.
std::string HashesText(const std::vector<std::uint64_t>& hashes) {
  std::string text;
  for (const std::uint64_t hash : hashes) {
    if (!text.empty()) text += ' ';
    text += fmt::format("{:016x}", hash);
  }
  return YamlQuoted(text);
}

std::vector<std::uint64_t> HashesOf(const std::string& text) {
  std::vector<std::uint64_t> hashes;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    std::uint64_t hash = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), hash, 16);
    if (error != std::errc() || end != word.data() + word.size()) {
      throw InputError(fmt::format("\"{}\" is no hash", word));
    }
    hashes.push_back(hash);
  }
  return hashes;
}

template <typename Value>
Value Get(const YAML::Node& map, const char* key) {
  const YAML::Node node = map[key];
  if (!node) throw InputError(fmt::format("{} is missing", key));
  return node.as<Value>();
}

ViewPictures ViewOf(const YAML::Node& node) {
  ViewPictures view;
  view.name = Get<std::string>(node, "name");
  view.width = Get<int>(node, "width");
  view.height = Get<int>(node, "height");
  for (const auto frame : Get<std::vector<std::size_t>>(node, "keys")) {
    view.keys.emplace_back().frame = frame;
  }
  return view;
}

Golden GoldenOf(const YAML::Node& root) {
  if (Get<int>(root, "format") != kFormat) {
    throw InputError(
        fmt::format("format is {}; this program knows {}", Get<int>(root, "format"), kFormat));
  }
  Golden golden;
  golden.pictures.frames = Get<std::size_t>(root, "frames");
  golden.pictures.interval_s = Get<double>(root, "interval_s");
  golden.pictures.bodies = Get<std::vector<std::string>>(root, "bodies");
  for (const YAML::Node& view : root["views"]) golden.pictures.views.push_back(ViewOf(view));
  golden.states = HashesOf(Get<std::string>(root, "states"));
  for (const YAML::Node& rendering : root["renderings"]) {
    Rendering& hashes = golden.renderings.emplace_back();
    for (const YAML::Node& view : rendering) hashes.push_back(HashesOf(view.as<std::string>()));
  }
  for (const YAML::Node& approval : root["approvals"]) {
    golden.approvals.push_back({Get<std::string>(approval, "reason"),
                                Get<std::string>(approval, "changed"),
                                Get<std::string>(approval, "version")});
  }
  return golden;
}

/// Refuses values that no golden has.
void RequireSense(const Golden& golden) {
  const Pictures& pictures = golden.pictures;
  constexpr std::size_t kMostFrames = 1'000'000;
  if (pictures.frames == 0 || pictures.frames > kMostFrames || pictures.views.empty() ||
      pictures.bodies.empty()) {
    throw InputError("frames, views or bodies are not those of a golden");
  }
  for (const ViewPictures& view : pictures.views) {
    for (const KeyPicture& key : view.keys) {
      if (key.frame >= pictures.frames) {
        throw InputError(fmt::format("view {} has a key picture of frame {}, of {} frames",
                                     view.name, key.frame, pictures.frames));
      }
    }
  }
  for (const Rendering& rendering : golden.renderings) {
    bool fits = rendering.size() == pictures.views.size();
    for (const auto& hashes : rendering) fits = fits && hashes.size() == pictures.frames;
    if (!fits) throw InputError("a rendering has not a hash for each frame of each view");
  }
}

std::string ReadText(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  file.peek();  // a folder can be opened but not read
  if (!file.is_open() || file.bad()) {
    throw InputError(fmt::format("{}: cannot be read ({})", path.string(),
                                 std::generic_category().message(errno)));
  }
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

std::string TextOf(const Golden& golden) {
  const Pictures& pictures = golden.pictures;
  std::string text = fmt::format(
      "# Written by panda-twin video approve.\nformat: {}\nframes: {}\n"
      "interval_s: {}\nbodies:\n",
      kFormat, pictures.frames, FormatNumber(pictures.interval_s));
  for (const std::string& body : pictures.bodies) text += fmt::format("  - {}\n", YamlQuoted(body));
  text += "views:\n";
  for (const ViewPictures& view : pictures.views) {
    std::vector<std::size_t> keys;
    keys.reserve(view.keys.size());
    for (const KeyPicture& key : view.keys) keys.push_back(key.frame);
    text += fmt::format("  - {{name: {}, width: {}, height: {}, keys: [{}]}}\n",
                        YamlQuoted(view.name), view.width, view.height, fmt::join(keys, ", "));
  }
  text += fmt::format("states: {}\nrenderings:\n", HashesText(golden.states));
  for (const Rendering& rendering : golden.renderings) {
    const char* begin = "  - - ";
    for (const auto& hashes : rendering) {
      text += begin + HashesText(hashes) + '\n';
      begin = "    - ";
    }
  }
  text += "approvals:\n";
  for (const Approval& approval : golden.approvals) {
    text += fmt::format("  - reason: {}\n    changed: {}\n    version: {}\n",
                        YamlQuoted(approval.reason), YamlQuoted(approval.changed),
                        YamlQuoted(approval.version));
  }
  return text;
}

Golden ReadGoldenText(const std::filesystem::path& path) {
  const std::string text = ReadText(path);
  try {
    Golden golden = GoldenOf(YAML::Load(text));
    RequireSense(golden);
    return golden;
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}:{}: not as panda-twin video approve wrote it: {}",
                                 path.string(), error.mark.line + 1, error.msg));
  } catch (const std::exception& error) {
    throw InputError(fmt::format("{}: not as panda-twin video approve wrote it: {}", path.string(),
                                 error.what()));
  }
}

}  // namespace twin::golden
