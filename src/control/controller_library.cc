#include "twin/control/controller_library.h"

#include <dlfcn.h>

#include <span>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::control {
namespace {

template <typename... Arguments>
[[noreturn]] void Refuse(const std::filesystem::path& library,
                         fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  throw InputError(fmt::format("controller library {}: {}", library.string(),
                               fmt::format(text, std::forward<Arguments>(arguments)...)));
}

std::string LoaderError() {
  const char* text = ::dlerror();
  return text == nullptr ? "no reason given" : text;
}

/// Calls user code. @returns its result. @throws InputError for any exception of the user code.
template <typename Call>
auto Guarded(const std::filesystem::path& library, std::string_view what, Call call) {
  try {
    return call();
  } catch (const InputError&) {
    throw;  // already a message for users, such as a ParameterReader's
  } catch (const std::exception& error) {
    Refuse(library, "{} threw an exception: {}", what, error.what());
  } catch (...) {
    Refuse(library, "{} threw something that is no std::exception", what);
  }
}

const ControllerLibraryInfo& InfoOf(const std::filesystem::path& library) {
  RequireLibrary(library);
  // Uses the absolute path, because dlopen searches elsewhere for a name without a slash. Never
  // closed, because its objects and code may outlive every scope here.
  void* handle = ::dlopen(std::filesystem::absolute(library).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    Refuse(
        library,
        "cannot be loaded: {}; is it a shared library for this machine, linked with all it needs?",
        LoaderError());
  }
  void* const symbol = ::dlsym(handle, kControllerLibraryEntry);
  if (symbol == nullptr) {
    Refuse(library, "has no entry {}; say TWIN_CONTROLLERS(...) in one of its sources",
           kControllerLibraryEntry);
  }
  const auto entry = reinterpret_cast<ControllerLibraryEntry>(symbol);
  const ControllerLibraryInfo* info = Guarded(library, "its entry", entry);
  if (info == nullptr) Refuse(library, "its entry returns null; it must tell of its controllers");
  if (info->abi != kControllerLibraryAbi) {
    Refuse(library,
           "was built for version {} of the controller interface, this panda-twin has {}; "
           "build it anew with the headers of this one",
           info->abi, kControllerLibraryAbi);
  }
  if (info->layout != kControllerLayout) {
    Refuse(library,
           "was built with other headers than this panda-twin, though of the same version "
           "of the controller interface; build it anew with the headers of this one");
  }
  return *info;
}

const ControllerEntry& FindController(const std::filesystem::path& library,
                                      const ControllerLibraryInfo& info, std::string_view type) {
  const std::span<const ControllerEntry> all(info.controllers, info.count);
  if (type.empty() && all.size() == 1) return all.front();
  std::string names;
  for (const ControllerEntry& one : all) {
    if (one.type == type) return one;
    names += (names.empty() ? "" : ", ") + std::string(one.type);
  }
  Refuse(library, "has no controller \"{}\"; it has: {}", type, names);
}

/// A controller from a library; translates its exceptions.
class LibraryController final : public Controller {
 public:
  LibraryController(std::unique_ptr<Controller> controller, std::filesystem::path library)
      : controller_(std::move(controller)), library_(std::move(library)) {}

  [[nodiscard]] CommandInterface command_interface() const noexcept override {
    return controller_->command_interface();
  }
  void Configure(ParameterReader& parameters) override {
    Guarded(library_, "Configure()", [&] { controller_->Configure(parameters); });
  }
  void Activate(const RobotState& state, Time now) override {
    Guarded(library_, "Activate()", [&] { controller_->Activate(state, now); });
  }
  void Update(const RobotState& state, Time now,
              ControllerOutput& output) noexcept TWIN_REALTIME override {
    controller_->Update(state, now, output);
  }
  void Deactivate() noexcept override { controller_->Deactivate(); }
  [[nodiscard]] bool follows_pose() const noexcept override { return controller_->follows_pose(); }
  [[nodiscard]] std::string Explain() const override {
    return Guarded(library_, "Explain()", [&] { return controller_->Explain(); });
  }

 private:
  std::unique_ptr<Controller> controller_;
  std::filesystem::path library_;
};

}  // namespace

void RequireLibrary(const std::filesystem::path& library) {
  std::error_code error;
  if (std::filesystem::is_regular_file(library, error)) return;
  Refuse(library, "there is no such file; build it, or give its path");
}

std::unique_ptr<Controller> LoadController(const std::filesystem::path& library,
                                           std::string_view type,
                                           const ControllerRequest& request) {
  const ControllerLibraryInfo& info = InfoOf(library);
  const ControllerEntry& found = FindController(library, info, type);
  MakeFailure failure;
  std::unique_ptr<Controller> controller(
      Guarded(library, fmt::format("making controller \"{}\"", found.type),
              [&] { return found.make(request, failure); }));
  if (!controller) {
    Refuse(
        library, "controller \"{}\" could not be made: {}", found.type,
        failure.text[0] == '\0' ? "its factory returned null, and no reason" : failure.text.data());
  }
  return std::make_unique<LibraryController>(std::move(controller), library);
}

}  // namespace twin::control
