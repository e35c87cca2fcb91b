#include "twin/experiment/calibration.h"

#include <cstddef>
#include <cstdint>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/fingerprint.h"
#include "twin/scenario/scenario.h"

namespace twin::experiment {
namespace {

class ByteHash {
 public:
  void Add(std::string_view text) noexcept {
    for (const char c : text) {
      value_ = (value_ ^ static_cast<unsigned char>(c)) * 0x100000001b3;
    }
  }
  [[nodiscard]] std::uint64_t value() const noexcept { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325;
};

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
  ByteHash hash;
  for (std::size_t i = 0; i < calibration.yaml.size(); ++i) {
    const auto file = std::string(CalibratedLoops()[i].file) + ".yaml";
    const scenario::Scenario loop = scenario::Load(scenarios / file);
    if (loop.loop != CalibratedLoops()[i].kind) {
      throw InputError(fmt::format("{}: its loop must be {}; the file stands for {}",
                                   (scenarios / file).string(), CalibratedLoops()[i].file,
                                   CalibratedLoops()[i].name));
    }
    calibration.yaml[i] = scenario::ToYaml(loop);
    hash.Add(calibration.yaml[i]);
  }
  calibration.hash = FormatHash(hash.value());
  return calibration;
}

}  // namespace twin::experiment
