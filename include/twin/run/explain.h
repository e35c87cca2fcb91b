#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "twin/report/explanation.h"

namespace twin::run {

/// Explains how a run ended, and why, with what its log says about the scenario.
///
/// Threads: one thread. @param named  a log, or a run's folder. @param motion, parts  as
/// report::Explain's. @throws as FindLog and report::Explain.
[[nodiscard]] report::Explanation Explain(
    const std::filesystem::path& named, std::optional<std::uint64_t> motion = std::nullopt,
    report::ExplanationParts parts = report::ExplanationParts::kTextAndPage);

}  // namespace twin::run
