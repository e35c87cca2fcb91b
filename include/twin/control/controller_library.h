#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "twin/control/controller.h"
#include "twin/control/registry.h"

// Users' controllers in shared libraries, loaded by path. A library lists its controllers with one
// line in one of its sources:
//
//   TWIN_CONTROLLERS({"soft_spring", &twin::control::MakeController<mine::SoftSpring>});
//
// Build it with the compiler and the headers of the panda-twin that loads it.
namespace twin::control {

/// Version of the interface between program and library: the entry, Controller, and the types that
/// its calls pass. Raised whenever one of them changes.
inline constexpr std::uint32_t kControllerLibraryAbi = 3;

/// Sizes of the types that cross the interface: detects equal versions built from different
/// headers.
inline constexpr std::uint64_t kControllerLayout =
    sizeof(RobotState) +
    8191 * (sizeof(ControllerOutput) +
            8191 * (sizeof(ControllerRequest) +
                    8191 * (sizeof(reference::Trajectory) + 8191 * sizeof(Parameter))));

/// Why a controller could not be made. Fixed-size text, so that neither side frees the other's
/// memory.
struct MakeFailure {
  std::array<char, 1024> text{};

  void Set(std::string_view why) noexcept {
    const std::size_t length = std::min(why.size(), text.size() - 1);
    std::copy_n(why.data(), length, text.data());
    text[length] = '\0';
  }
};

/// One controller of a library.
struct ControllerEntry {
  const char* type = nullptr;  ///< name in scenarios
  /// @returns a controller that the caller deletes; null on failure, with the reason in `failure`.
  Controller* (*make)(const ControllerRequest& request, MakeFailure& failure) = nullptr;
};

/// Description of a library, returned by its entry. The first two members keep their meaning in all
/// versions.
struct ControllerLibraryInfo {
  std::uint32_t abi = kControllerLibraryAbi;  ///< of the headers that the library was compiled with
  std::uint32_t count = 0;                    ///< number of controllers
  std::uint64_t layout = kControllerLayout;
  const ControllerEntry* controllers = nullptr;  ///< `count` entries
};

/// Name and type of a library's entry.
inline constexpr const char* kControllerLibraryEntry = "panda_twin_controllers";
using ControllerLibraryEntry = const ControllerLibraryInfo* (*)();

/// Makes a T(request); no exception leaves the library.
template <typename T>
Controller* MakeController(const ControllerRequest& request, MakeFailure& failure) noexcept {
  try {
    return std::make_unique<T>(request).release();
  } catch (const std::exception& error) {
    failure.Set(error.what());
  } catch (...) {
    failure.Set("its constructor threw something that is no std::exception");
  }
  return nullptr;
}

/// Checks that the file exists; executes no code from it. @throws InputError as LoadController if
/// it does not exist.
void RequireLibrary(const std::filesystem::path& library);

/// Loads a library, which executes its code, and makes one of its controllers. The library stays
/// loaded until the program ends. All its symbols are bound here, so that none is resolved in real
/// time. Exceptions of Configure() and Activate() leave as InputError that names the library.
/// @param type  empty: the library's only controller.
/// @throws InputError naming file and cure if the file does not exist; it is not a library for this
/// machine; symbols or libraries that it needs are missing; it lacks the entry, or the entry throws
/// or returns null; it was built for another version of panda-twin; it lacks the controller; or the
/// controller cannot be made.
[[nodiscard]] std::unique_ptr<Controller> LoadController(const std::filesystem::path& library,
                                                         std::string_view type,
                                                         const ControllerRequest& request);

}  // namespace twin::control

/// Defines the entry of a library from its controllers, {"type", &make} each.
#define TWIN_CONTROLLERS(...)                                                                   \
  extern "C" __attribute__((visibility("default"))) const twin::control::ControllerLibraryInfo* \
  panda_twin_controllers() {                                                                    \
    static const twin::control::ControllerEntry controllers[] = {__VA_ARGS__};                  \
    static const twin::control::ControllerLibraryInfo info{                                     \
        .count = sizeof(controllers) / sizeof(controllers[0]), .controllers = controllers};     \
    return &info;                                                                               \
  }                                                                                             \
  static_assert(true)
