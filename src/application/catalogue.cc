#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "application/compliance.h"
#include "application/pick_and_place.h"
#include "application/plan_and_execute.h"
#include "application/teleoperation.h"
#include "twin/application/application.h"
#include "twin/control/parameters.h"
#include "twin/core/error.h"

namespace twin::application {
namespace {

using Maker = std::unique_ptr<Application> (*)(control::ParameterReader& parameters);

struct Entry {
  std::string_view name;
  Maker make;
};

constexpr std::array<Entry, 4> kApplications{{
    {"compliance", MakeCompliance},
    {"pick_and_place", MakePickAndPlace},
    {"plan_and_execute", MakePlanAndExecute},
    {"teleoperation", MakeTeleoperation},
}};

/// "<file>:<line>: " when the name was read from there.
std::string PlaceOf(const scenario::Scenario& scenario) {
  const scenario::Place& place = scenario.places.application;
  return place.name == scenario.application->type && !place.where.empty() ? place.where + ": " : "";
}

}  // namespace

std::unique_ptr<Application> Make(const scenario::Scenario& scenario) {
  const scenario::ApplicationSection& wanted = scenario.application.value();
  const auto* entry = std::ranges::find(kApplications, wanted.type, &Entry::name);
  if (entry == kApplications.end()) {
    throw InputError(fmt::format("{}application \"{}\" is unknown; there are: {}",
                                 PlaceOf(scenario), wanted.type, fmt::join(Names(), ", ")));
  }
  control::ParameterReader reader(wanted.parameters, "application.parameters");
  std::unique_ptr<Application> application = entry->make(reader);
  reader.RefuseUnread();
  if (scenario.base && !application->drives_base()) {
    throw InputError(
        fmt::format("{}application {}: it takes the arm to stand on the world; leave base out",
                    PlaceOf(scenario), wanted.type));
  }
  application->Require(scenario);
  return application;
}

std::vector<std::string> Names() {
  std::vector<std::string> names;
  names.reserve(kApplications.size());
  for (const Entry& entry : kApplications) names.emplace_back(entry.name);
  return names;
}

}  // namespace twin::application
