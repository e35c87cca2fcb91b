#include "twin/experiment/calibration.h"

#include <cstddef>
#include <cstdint>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/hash.h"
#include "twin/scenario/scenario.h"

namespace twin::experiment {
namespace {

void AddBytes(std::string_view text, std::uint64_t& fnv1a) noexcept {
  for (const char c : text) fnv1a = (fnv1a ^ static_cast<unsigned char>(c)) * 0x100000001b3;
}

}  // namespace

const std::array<CalibratedLoop, 3>& CalibratedLoops() noexcept {
  static constexpr std::array<CalibratedLoop, 3> kLoops{{
      {"LF", "bare", loop::LoopKind::kBare},
      {"RS", "synchronous", loop::LoopKind::kSynchronous},
      {"RA", "asynchronous", loop::LoopKind::kAsynchronous},
  }};
  return kLoops;
}

Calibration ReadCalibration(const std::filesystem::path& scenarios) {
  Calibration calibration;
  std::uint64_t hash = 0xcbf29ce484222325;
  for (std::size_t i = 0; i < calibration.yaml.size(); ++i) {
    const auto file = std::string(CalibratedLoops()[i].file) + ".yaml";
    const scenario::Scenario loop = scenario::Load(scenarios / file);
    if (loop.loop != CalibratedLoops()[i].kind) {
      throw InputError(fmt::format("{}: its loop must be {}; the file stands for {}",
                                   (scenarios / file).string(), CalibratedLoops()[i].file,
                                   CalibratedLoops()[i].name));
    }
    calibration.yaml[i] = scenario::ToYaml(loop);
    AddBytes(calibration.yaml[i], hash);
  }
  calibration.hash = FormatHash(hash);
  return calibration;
}

}  // namespace twin::experiment
