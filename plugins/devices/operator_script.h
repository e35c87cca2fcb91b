#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <string>
#include <vector>

#include "twin/teleop/operator_sample.h"

// What an operator did, as a file of comma-separated values: a row for each sample, with the header
//   time,kind,x,y,z,rx,ry,rz,engaged,mode,gripper,frame,scale,stop,release,end
// time in s from the beginning; kind rate (axes are shares of full scale in [-1, 1]) or pose (m and
// rad, in [-10, 10]); engaged 1 or 0; then how often each button was pressed since the row before.
namespace twin::devices {

inline constexpr std::uintmax_t kMostScriptBytes = std::uintmax_t{64} << 20;

/// Reads samples: times rise, sequences go from 1 on, presses are summed up.
/// @param name  of the file, for messages.
/// @throws InputError "<name>:<line>: what is wrong", also when the presses of a button do not fit
/// their counter; when there is no row.
[[nodiscard]] std::vector<teleop::OperatorSample> ReadOperatorScript(std::istream& in,
                                                                     const std::string& name);

/// As above. @throws InputError also when the file cannot be read, or is larger than
/// kMostScriptBytes.
[[nodiscard]] std::vector<teleop::OperatorSample> ReadOperatorScript(
    const std::filesystem::path& path);

/// The first line of a script, with its end.
[[nodiscard]] std::string OperatorScriptHeader();

/// The line of `sample`, with its end; `at` is its time from the beginning. From it the same values
/// are read, to the bit. @param before  the sample of the line before; of the first line, one
/// without presses.
[[nodiscard]] std::string OperatorScriptRow(const teleop::OperatorSample& sample,
                                            const teleop::OperatorSample& before);

}  // namespace twin::devices
