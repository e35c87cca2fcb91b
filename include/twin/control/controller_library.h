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
#include "twin/control/controller_request.h"

// Users' own controllers, in shared libraries that are loaded by path. A library says which it has
// by one line in one of its sources:
//
//   TWIN_CONTROLLERS({"soft_spring", &twin::control::MakeController<mine::SoftSpring>});
//
// and is built with the compiler and the headers of the panda-twin that loads it.
namespace twin::control {

/// Version of the border between program and library: the entry, Controller, and what its calls
/// pass. Raised whenever one of these changes.
inline constexpr std::uint32_t kControllerLibraryAbi = 2;

/// Sizes of what crosses the border: equal versions built from unequal headers differ in it.
inline constexpr std::uint64_t kControllerLayout =
    sizeof(RobotState) +
    8191 * (sizeof(ControllerOutput) +
            8191 * (sizeof(ControllerRequest) +
                    8191 * (sizeof(reference::Trajectory) + 8191 * sizeof(Parameter))));

/// Why a controller could not be made, as text that needs no memory of either side.
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
  const char* type = nullptr;  ///< as scenarios name it
  /// @returns a controller that the caller deletes; or null, and says why in `failure`.
  Controller* (*make)(const ControllerRequest& request, MakeFailure& failure) = nullptr;
};

/// What the entry of a library tells of it. The first two members stay what they are in all
/// versions.
struct ControllerLibraryInfo {
  std::uint32_t abi = kControllerLibraryAbi;  ///< of the headers it was compiled with
  std::uint32_t count = 0;                    ///< of its controllers
  std::uint64_t layout = kControllerLayout;
  const ControllerEntry* controllers = nullptr;  ///< `count` of them
};

/// The name and the type of a library's entry.
inline constexpr const char* kControllerLibraryEntry = "panda_twin_controllers";
using ControllerLibraryEntry = const ControllerLibraryInfo* (*)();

/// Makes a T(request), and keeps its exceptions inside the library.
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

/// Looks for the file, and runs nothing of it. @throws InputError as LoadController when there is
/// none.
void RequireLibrary(const std::filesystem::path& library);

/// Loads a library, which runs code of it, and makes one of its controllers. The library stays
/// loaded until the program ends. Its symbols are all bound here, so that none is looked for in
/// real time; what its Configure() and Activate() throw comes out as an InputError that names the
/// library.
/// @param type  empty: the only one the library has.
/// @throws InputError naming the file and the cure when: there is no such file; it is no library
/// for this machine, or wants symbols or libraries that are not there; it lacks the entry, or its
/// entry throws or tells nothing; it was built for another version of panda-twin; it has no such
/// controller; the controller cannot be made.
[[nodiscard]] std::unique_ptr<Controller> LoadController(const std::filesystem::path& library,
                                                         std::string_view type,
                                                         const ControllerRequest& request);

}  // namespace twin::control

/// The entry of a library: its controllers, {"type", &make} each.
#define TWIN_CONTROLLERS(...)                                                                   \
  extern "C" __attribute__((visibility("default"))) const twin::control::ControllerLibraryInfo* \
  panda_twin_controllers() {                                                                    \
    static const twin::control::ControllerEntry controllers[] = {__VA_ARGS__};                  \
    static const twin::control::ControllerLibraryInfo info{                                     \
        .count = sizeof(controllers) / sizeof(controllers[0]), .controllers = controllers};     \
    return &info;                                                                               \
  }                                                                                             \
  static_assert(true)
