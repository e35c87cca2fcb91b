#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <string>
#include <vector>

#include "twin/teleop/operator_sample.h"

// An operator's recorded input as comma-separated values: one row per sample, with the header
//   time,kind,x,y,z,rx,ry,rz,engaged,mode,gripper,frame,scale,stop,release,end
// time in s from the start; kind rate (axes are shares of full scale in [-1, 1]), pose (m and
// rad, in [-10, 10]) or joint1 to joint7 (x turns this joint alone); engaged 1 or 0; then the
// presses of each button since the previous row.
namespace twin::teleop {

inline constexpr std::uintmax_t kMostScriptBytes = std::uintmax_t{64} << 20;

/// Reads samples: times rise, sequences count from 1, presses are accumulated.
/// @param name  of the file, for messages.
/// @throws InputError "<name>:<line>: what is wrong", also if the presses of a button overflow
/// their counter, and if there is no row.
[[nodiscard]] std::vector<OperatorSample> ReadOperatorScript(std::istream& in,
                                                             const std::string& name);

/// As above. @throws InputError also if the file cannot be read or exceeds kMostScriptBytes.
[[nodiscard]] std::vector<OperatorSample> ReadOperatorScript(const std::filesystem::path& path);

/// The header line of a script, with newline.
[[nodiscard]] std::string OperatorScriptHeader();

/// The row of `sample`, with newline; `at` is its time from the start. Reads back to the same
/// values, bit by bit. @param before  the previous row's sample; for the first row, one without
/// presses.
[[nodiscard]] std::string OperatorScriptRow(const OperatorSample& sample,
                                            const OperatorSample& before);

}  // namespace twin::teleop
