#pragma once

#include <cstddef>
#include <cstdint>

// Constants of the pcapng format and of the headers inside. Source: IETF draft-ietf-opsawg-pcapng;
// RFC 791 (IPv4), 768 (UDP), 9293 (TCP).
namespace twin::record::pcapng {

inline constexpr std::uint32_t kSectionHeader = 0x0a0d0d0a;
inline constexpr std::uint32_t kInterfaceDescription = 1;
inline constexpr std::uint32_t kEnhancedPacket = 6;
inline constexpr std::uint32_t kByteOrderMagic = 0x1a2b3c4d;

/// Magic numbers of the older format pcap, microseconds and nanoseconds, in the writer's byte
/// order. Source: IETF draft-ietf-opsawg-pcap.
inline constexpr std::uint32_t kClassicMicroseconds = 0xa1b2c3d4;
inline constexpr std::uint32_t kClassicNanoseconds = 0xa1b23c4d;

/// Options of an interface description.
inline constexpr std::uint16_t kOptionEnd = 0;
inline constexpr std::uint16_t kOptionTimeResolution = 9;

/// Link types of an interface.
inline constexpr std::uint16_t kLinkEthernet = 1;
inline constexpr std::uint16_t kLinkRaw = 101;
inline constexpr std::uint16_t kLinkLinuxCooked = 113;
inline constexpr std::uint16_t kLinkIpv4 = 228;

inline constexpr std::size_t kIpBytes = 20;
inline constexpr std::size_t kUdpBytes = 8;
inline constexpr std::size_t kTcpBytes = 20;
inline constexpr std::uint8_t kTcp = 6;
inline constexpr std::uint8_t kUdp = 17;

}  // namespace twin::record::pcapng
