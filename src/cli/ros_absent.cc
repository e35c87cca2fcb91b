#include "cli/ros_flags.h"

#include <CLI/CLI.hpp>

#include "twin/core/error.h"

// A program that was built without ROS 2.
namespace twin::cli {

void AddRos(CLI::App& app, RosFlags& flags) {
  app.add_flag("--ros", flags.wanted, "Not in this program, which was built without Fast DDS");
}

void AddRosNames(CLI::App& /*app*/, RosFlags& /*flags*/) {}

void RequireRosFlags(const RosFlags& flags) {
  RefuseIf(
      flags.wanted,
      "--ros: this program was built without Fast DDS; install libfastrtps-dev, libssl-dev and "
      "libtinyxml2-dev (scripts/setup does), and build again");
}

RosFlags RosOf(const RosFlags& flags, const std::string& /*robot*/, bool /*has_scene*/) {
  return flags;
}

std::unique_ptr<RosBridge> MakeRosBridge(const RosFlags& /*flags*/, record::RecordSink* /*next*/) {
  return nullptr;
}

}  // namespace twin::cli
