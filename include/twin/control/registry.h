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

/// The controllers a program knows, by name. Filled from an explicit list by the program's main.
///
/// Threads: one thread.
class ControllerRegistry {
 public:
  /// @pre no controller of this name was added.
  void Add(std::string name, ControllerFactory factory);

  /// @throws InputError when there is no such controller; the text lists those there are.
  [[nodiscard]] const ControllerFactory& Find(std::string_view name) const;

  [[nodiscard]] std::vector<std::string> Names() const;

 private:
  std::vector<std::pair<std::string, ControllerFactory>> entries_;
};

}  // namespace twin::control
