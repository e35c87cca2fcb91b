#include "twin/model/model_library.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <system_error>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::model {
namespace {

namespace fs = std::filesystem;

/// Magic number of ELF files.
constexpr std::array<char, 4> kElf{0x7f, 'E', 'L', 'F'};

const char* FileName(ModelFigures figures) {
  return figures == ModelFigures::kPlant ? "libpanda_model_plant.so" : "libpanda_model.so";
}

}  // namespace

fs::path FindModelLibrary(const fs::path& program, ModelFigures figures) {
  const fs::path place = fs::path("lib") / "panda-twin" / FileName(figures);
  const fs::path installed = (program.parent_path() / ".." / place).lexically_normal();
  const fs::path built = (program.parent_path() / place).lexically_normal();
  for (const fs::path& candidate : {installed, built}) {
    std::error_code error;
    if (fs::is_regular_file(candidate, error)) return candidate;
  }
  throw EnvironmentError(
      fmt::format("the model library that clients load was not found; looked for {} and {}; build "
                  "the target panda_model_library, or install the twin again",
                  installed.string(), built.string()));
}

std::vector<std::byte> ReadModelLibrary(const fs::path& file) {
  const auto fail = [&](const std::string& what) {
    throw EnvironmentError(fmt::format(
        "the model library {} {}; build the target panda_model_library, or install the twin again",
        file.string(), what));
  };
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) fail(fmt::format("cannot be read ({})", error.message()));
  if (size > kLargestModelLibrary) {
    fail(fmt::format("has {} bytes, more than the {} a client takes", size, kLargestModelLibrary));
  }
  std::ifstream stream(file, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
  if (bytes.size() != size) fail("cannot be read to its end");
  if (size < kElf.size() || !std::equal(kElf.begin(), kElf.end(), bytes.begin())) {
    fail("is no shared object");
  }
  std::vector<std::byte> library(bytes.size());
  std::transform(bytes.begin(), bytes.end(), library.begin(),
                 [](char byte) { return static_cast<std::byte>(byte); });
  return library;
}

}  // namespace twin::model
