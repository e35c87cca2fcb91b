#pragma once

#include <cstddef>
#include <span>

// What reads untrusted bytes of the Franka Control Interface, and the rules that must hold for any
// bytes; breaking one ends the program. Each is an entry of libFuzzer (fuzz_entry.cc), and
// fci_fuzz_test and fci_corpus_test drive them by seeded mutations.
namespace twin::fci::fuzz {

using Bytes = std::span<const std::byte>;

/// What all targets below are; no bytes at all are accepted like any others.
using Target = void (*)(Bytes);

/// What a server's arm, hand and vacuum gripper receive. The first byte says in what pieces the
/// others come. What is read as a request must be the request's bytes when written again.
void ArmRequests(Bytes data);
void HandRequests(Bytes data);
void VacuumRequests(Bytes data);

/// The same bytes in a session that answers them, beside a robot that changes: session_targets.h.
void ArmSession(Bytes data);
void HandSession(Bytes data);

/// What clients of arm and hand receive. The first byte says what was asked, the second in what
/// pieces the others come.
void ArmAnswers(Bytes data);
void HandAnswers(Bytes data);

/// Datagrams. What is read must be the datagram's bytes when written again; what is not leaves no
/// trace.
void StateDatagram(Bytes data);
void CommandDatagram(Bytes data);
void HandStateDatagram(Bytes data);
void VacuumStateDatagram(Bytes data);

/// All there is of the hand: the first byte says which of HandSession, HandAnswers and
/// HandStateDatagram gets the others.
void Gripper(Bytes data);

}  // namespace twin::fci::fuzz
