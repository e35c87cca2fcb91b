#include "plant/robot_description.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <string_view>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>
#include <Eigen/Geometry>

#include "twin/core/error.h"

namespace twin::plant {
namespace {

/// The shortest rotation from z to a direction; to -z about -x. Like Eigen's FromTwoVectors, but
/// without its singular value decomposition for -z, which took half of this file's compile time.
Eigen::Quaterniond TurnFromZ(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d to = direction.normalized();
  const double c = to.dot(z);
  if (c < -1 + 1e-12) return {0, -1, 0, 0};
  const double s = std::sqrt((1 + c) * 2);
  const Eigen::Vector3d part = z.cross(to) * (1 / s);
  return {s * 0.5, part.x(), part.y(), part.z()};
}

/// Reads one primitives file; all errors name its file and line.
class PrimitivesReader {
 public:
  PrimitivesReader(const std::string& text, const std::string& where)
      : where_(where), root_(YAML::Load(text)) {
    RequireKeys(root_, {"unit", "colours", "links"});
    for (const char* key : {"colours", "links"}) {
      if (!root_[key] || !root_[key].IsMap()) Fail(root_, fmt::format("'{}' must be a map", key));
    }
    if (Text(root_, "unit") != "m") Fail(root_["unit"], "unit must be m");
    for (const auto& entry : root_["colours"]) {
      colours_[entry.first.as<std::string>()] = Numbers<4>(entry.second, "a colour");
    }
  }

  /// Gives `link` the file's shapes instead of its meshes.
  void Apply(Link& link) const {
    const auto is_mesh = [](const Shape& shape) { return shape.kind == ShapeKind::kMesh; };
    const auto meshes =
        std::erase_if(link.visual, is_mesh) + std::erase_if(link.collision, is_mesh);
    if (meshes == 0) return;
    const YAML::Node shapes = root_["links"][link.name];
    if (!shapes || !shapes.IsSequence()) {
      Fail(root_["links"], fmt::format("no list of shapes for link '{}'", link.name));
    }
    for (const auto& node : shapes) AddShape(node, link);
  }

 private:
  [[noreturn]] void Fail(const YAML::Node& node, std::string_view message) const {
    throw InputError(fmt::format("{}: line {}: {}", where_, node.Mark().line + 1, message));
  }

  void RequireKeys(const YAML::Node& node, std::initializer_list<std::string_view> keys) const {
    if (!node.IsMap()) Fail(node, "expected a map");
    for (const auto& entry : node) {
      const auto key = entry.first.as<std::string>();
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
        Fail(entry.first, fmt::format("unknown key '{}'", key));
      }
    }
  }

  std::string Text(const YAML::Node& node, const std::string& key) const {
    const YAML::Node value = node[key];
    if (!value || !value.IsScalar()) Fail(node, fmt::format("key '{}' is missing", key));
    return value.Scalar();
  }

  double Number(const YAML::Node& node, std::string_view what) const {
    double value = 0;
    if (!YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
      Fail(node, fmt::format("{} must be a finite number", what));
    }
    return value;
  }

  template <std::size_t N>
  std::array<double, N> Numbers(const YAML::Node& node, std::string_view what) const {
    if (!node.IsSequence() || node.size() != N) {
      Fail(node, fmt::format("{} must be a list of {} numbers", what, N));
    }
    std::array<double, N> values{};
    for (std::size_t i = 0; i < N; ++i) values[i] = Number(node[i], what);
    return values;
  }

  Vector3 Point(const YAML::Node& node, const std::string& key) const {
    const YAML::Node value = node[key];
    if (!value) Fail(node, fmt::format("key '{}' is missing", key));
    return Numbers<3>(value, key);
  }

  double Radius(const YAML::Node& node) const {
    const YAML::Node value = node["radius"];
    if (!value) Fail(node, "key 'radius' is missing");
    const double radius = Number(value, "radius");
    if (radius <= 0) Fail(value, fmt::format("radius is {}; it must be above 0", radius));
    return radius;
  }

  /// A solid of revolution between two points, along z of the shape.
  Shape Between(const YAML::Node& node, ShapeKind kind) const {
    RequireKeys(node, {"shape", "from", "to", "radius", "colour", "use"});
    const Vector3 from = Point(node, "from");
    const Vector3 to = Point(node, "to");
    const Eigen::Map<const Eigen::Vector3d> a(from.data());
    const Eigen::Map<const Eigen::Vector3d> b(to.data());
    const Eigen::Vector3d along = b - a;
    if (along.norm() < 1e-6) Fail(node, "'from' and 'to' are the same point");
    const Eigen::Quaterniond q = TurnFromZ(along);
    Shape shape;
    shape.kind = kind;
    shape.size = {Radius(node), along.norm() / 2, 0};
    Eigen::Map<Eigen::Vector3d>(shape.X_LS.p.data()) = (a + b) / 2;
    shape.X_LS.quat = {q.w(), q.x(), q.y(), q.z()};
    return shape;
  }

  Shape ReadShape(const YAML::Node& node) const {
    const std::string name = node.IsMap() ? Text(node, "shape") : std::string();
    if (name == "capsule") return Between(node, ShapeKind::kCapsule);
    if (name == "cylinder") return Between(node, ShapeKind::kCylinder);
    Shape shape;
    if (name == "sphere") {
      RequireKeys(node, {"shape", "at", "radius", "colour", "use"});
      shape.kind = ShapeKind::kSphere;
      shape.size = {Radius(node), 0, 0};
    } else if (name == "box") {
      RequireKeys(node, {"shape", "at", "half", "colour", "use"});
      shape.kind = ShapeKind::kBox;
      shape.size = Point(node, "half");
    } else {
      Fail(node, fmt::format("shape '{}' must be capsule, cylinder, sphere or box", name));
    }
    shape.X_LS.p = Point(node, "at");
    return shape;
  }

  void AddShape(const YAML::Node& node, Link& link) const {
    Shape shape = ReadShape(node);
    const std::string colour = Text(node, "colour");
    const auto found = colours_.find(colour);
    if (found == colours_.end()) Fail(node, fmt::format("unknown colour '{}'", colour));
    shape.colour = found->second;
    const std::string use = node["use"] ? Text(node, "use") : "both";
    if (use != "both" && use != "visual" && use != "collision") {
      Fail(node, fmt::format("use '{}' must be visual, collision or left out", use));
    }
    if (use != "collision") link.visual.push_back(shape);
    if (use != "visual") link.collision.push_back(shape);
  }

  std::string where_;
  YAML::Node root_;
  std::map<std::string, Colour> colours_;
};

}  // namespace

void UsePrimitives(const std::string& text, const std::string& where, RobotDescription& robot) {
  try {
    const PrimitivesReader reader(text, where);
    for (Link& link : robot.links) reader.Apply(link);
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}: {}", where, error.what()));
  }
}

}  // namespace twin::plant
