#pragma once

#include <cstddef>
#include <span>

// What reads untrusted bytes of operators' devices, and the rules that must hold for any bytes;
// breaking one ends the program. As the targets of fci_targets.h, and driven as they are.
namespace twin::devices::fuzz {

/// A datagram of a device's own program, and one of its feedback. What is read must be the same
/// bytes when written again, and within the ranges of its fields.
void OperatorDatagram(std::span<const std::byte> data);

/// The file of an operator's script. What is read has times that rise and axes in range, and is
/// read again from what is written of it; what is refused is refused in one printable line.
void OperatorScript(std::span<const std::byte> data);

}  // namespace twin::devices::fuzz
