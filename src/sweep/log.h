#pragma once

#include <filesystem>

#include "twin/run/catalogue.h"
#include "twin/sweep/result.h"

namespace twin::sweep {

/// Whether a sweep keeps the log of a run with this result.
[[nodiscard]] bool KeepsLog(const Sweep& sweep, const Result& result) noexcept;

/// Carries a run out once more, with its log, into LogFolderOf(out, address); there whole or not at
/// all. @returns whether it is there now; false after an interrupt. @throws as RunCase,
/// EnvironmentError when it cannot be written.
bool KeepLog(const PreparedCase& prepared, const run::Catalogue& catalogue,
             const run::RunFiles& files, const std::filesystem::path& out,
             const volatile bool* interrupted);

}  // namespace twin::sweep
