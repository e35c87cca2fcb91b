#pragma once

#include <cstdint>
#include <filesystem>

namespace twin::run {

/// The fingerprint of all states of a run, out of its log: RunResult::states_hash, unless the log
/// was cut short.
///
/// Threads: one thread. Real-time: no. @throws as record::LogReader.
[[nodiscard]] std::uint64_t StatesHashOf(const std::filesystem::path& log);

}  // namespace twin::run
