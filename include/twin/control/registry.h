#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "twin/control/controller.h"
#include "twin/control/controller_request.h"

namespace twin::control {

using ControllerFactory = std::function<std::unique_ptr<Controller>(const ControllerRequest&)>;

/// The program's controllers by name. The program's main fills it from an explicit list.
///
/// Threads: one thread.
class ControllerRegistry {
 public:
  /// @pre no controller of this name was added.
  void Add(std::string name, ControllerFactory factory);

  /// @throws InputError listing the known names if the name is unknown.
  [[nodiscard]] const ControllerFactory& Find(std::string_view name) const;

  [[nodiscard]] std::vector<std::string> Names() const;

 private:
  std::vector<std::pair<std::string, ControllerFactory>> entries_;
};

}  // namespace twin::control
