#include "plugins/ros2/robot_description.h"

#include <set>

#include <tinyxml2.h>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::ros2 {
namespace {

const tinyxml2::XMLElement& Load(const std::filesystem::path& file,
                                 tinyxml2::XMLDocument& document) {
  document.LoadFile(file.c_str());
  const tinyxml2::XMLElement* robot = document.FirstChildElement("robot");
  if (document.Error() || robot == nullptr) {
    throw InputError(fmt::format("{}: no URDF: {}", file.string(),
                                 document.Error() ? document.ErrorStr() : "it has no <robot>"));
  }
  return *robot;
}

}  // namespace

std::string DescriptionOf(const std::filesystem::path& arm, const std::filesystem::path& hand) {
  tinyxml2::XMLDocument whole;
  static_cast<void>(Load(arm, whole));
  tinyxml2::XMLElement* const robot = whole.FirstChildElement("robot");
  if (!hand.empty()) {
    std::set<std::string> links;
    for (const auto* link = robot->FirstChildElement("link"); link != nullptr;
         link = link->NextSiblingElement("link")) {
      links.insert(link->Attribute("name") == nullptr ? "" : link->Attribute("name"));
    }
    tinyxml2::XMLDocument mounted;
    // The hand's root is the arm's last link.
    for (const auto* child = Load(hand, mounted).FirstChildElement(); child != nullptr;
         child = child->NextSiblingElement()) {
      const char* name = child->Attribute("name");
      if (std::string_view(child->Name()) == "link" && name != nullptr && links.contains(name)) {
        continue;
      }
      robot->InsertEndChild(child->DeepClone(&whole));
    }
  }
  tinyxml2::XMLPrinter printer;
  whole.Print(&printer);
  return printer.CStr();
}

}  // namespace twin::ros2
