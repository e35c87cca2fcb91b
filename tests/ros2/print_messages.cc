#include <cstddef>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "plugins/ros2/type_description.h"
#include "ros2/filled.h"

// Prints of each message: name, hash, name on the wire, and the bytes of one in which each field
// has a value of its own.
int main() {
  twin::ros2::ForEachMessageOfAll([]<typename M>() {
    const std::string name = twin::ros2::NameOf<M>();
    fmt::print("{} {} {} ", name, twin::ros2::Describe<M>().Hash(), twin::ros2::DdsName(name));
    for (const std::byte byte : twin::ros2::ToBytes(twin::ros2::Filled<M>())) {
      fmt::print("{:02x}", static_cast<unsigned>(byte));
    }
    fmt::print("\n");
  });
}
