#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

// Messages of ROS 2, and the only place where their layouts are written.
// From each one's Visit() come its bytes (cdr.h) and its description and hash
// (type_description.h). Names of types and fields, and their order, are those of the interface
// packages common_interfaces, rcl_interfaces, geometry2 and rmw_dds_common; a test compares bytes
// and hashes with those of the package rosbags.
//
// A message has a full name and a Visit(message, visitor), which calls visitor(field name, field)
// in order. Its fields are numbers, bool, std::string, std::vector, std::array and messages. All
// quantities are SI and rad, as ROS demands (REP 103).
namespace twin::ros2 {

/// A string of at most N bytes, `string<=N`.
template <std::size_t N>
struct BoundedString {
  std::string text;
  bool operator==(const BoundedString&) const = default;
};

namespace msg {
namespace detail {

/// ROS has no message without a field.
struct Nothing {
  std::uint8_t structure_needs_at_least_one_member = 0;
  static void Visit(auto& m, auto&& v) {
    v("structure_needs_at_least_one_member", m.structure_needs_at_least_one_member);
  }
};

}  // namespace detail

struct Time {
  static constexpr const char* kName = "builtin_interfaces/msg/Time";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  static void Visit(auto& m, auto&& v) {
    v("sec", m.sec);
    v("nanosec", m.nanosec);
  }
};

struct Duration {
  static constexpr const char* kName = "builtin_interfaces/msg/Duration";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  static void Visit(auto& m, auto&& v) {
    v("sec", m.sec);
    v("nanosec", m.nanosec);
  }
};

struct Clock {
  static constexpr const char* kName = "rosgraph_msgs/msg/Clock";
  Time clock;
  static void Visit(auto& m, auto&& v) { v("clock", m.clock); }
};

struct Header {
  static constexpr const char* kName = "std_msgs/msg/Header";
  Time stamp;
  std::string frame_id;
  static void Visit(auto& m, auto&& v) {
    v("stamp", m.stamp);
    v("frame_id", m.frame_id);
  }
};

struct String {
  static constexpr const char* kName = "std_msgs/msg/String";
  std::string data;
  static void Visit(auto& m, auto&& v) { v("data", m.data); }
};

struct JointState {
  static constexpr const char* kName = "sensor_msgs/msg/JointState";
  Header header;
  std::vector<std::string> name;
  std::vector<double> position;
  std::vector<double> velocity;
  std::vector<double> effort;
  static void Visit(auto& m, auto&& v) {
    v("header", m.header);
    v("name", m.name);
    v("position", m.position);
    v("velocity", m.velocity);
    v("effort", m.effort);
  }
};

struct Vector3 {
  static constexpr const char* kName = "geometry_msgs/msg/Vector3";
  double x = 0;
  double y = 0;
  double z = 0;
  static void Visit(auto& m, auto&& v) {
    v("x", m.x);
    v("y", m.y);
    v("z", m.z);
  }
};

struct Point {
  static constexpr const char* kName = "geometry_msgs/msg/Point";
  double x = 0;
  double y = 0;
  double z = 0;
  static void Visit(auto& m, auto&& v) {
    v("x", m.x);
    v("y", m.y);
    v("z", m.z);
  }
};

struct Quaternion {
  static constexpr const char* kName = "geometry_msgs/msg/Quaternion";
  double x = 0;
  double y = 0;
  double z = 0;
  double w = 1;
  static void Visit(auto& m, auto&& v) {
    v("x", m.x);
    v("y", m.y);
    v("z", m.z);
    v("w", m.w);
  }
};

struct Transform {
  static constexpr const char* kName = "geometry_msgs/msg/Transform";
  Vector3 translation;
  Quaternion rotation;
  static void Visit(auto& m, auto&& v) {
    v("translation", m.translation);
    v("rotation", m.rotation);
  }
};

struct TransformStamped {
  static constexpr const char* kName = "geometry_msgs/msg/TransformStamped";
  Header header;
  std::string child_frame_id;
  Transform transform;
  static void Visit(auto& m, auto&& v) {
    v("header", m.header);
    v("child_frame_id", m.child_frame_id);
    v("transform", m.transform);
  }
};

struct TFMessage {
  static constexpr const char* kName = "tf2_msgs/msg/TFMessage";
  std::vector<TransformStamped> transforms;
  static void Visit(auto& m, auto&& v) { v("transforms", m.transforms); }
};

struct Pose {
  static constexpr const char* kName = "geometry_msgs/msg/Pose";
  Point position;
  Quaternion orientation;
  static void Visit(auto& m, auto&& v) {
    v("position", m.position);
    v("orientation", m.orientation);
  }
};

struct Twist {
  static constexpr const char* kName = "geometry_msgs/msg/Twist";
  Vector3 linear;
  Vector3 angular;
  static void Visit(auto& m, auto&& v) {
    v("linear", m.linear);
    v("angular", m.angular);
  }
};

struct Accel {
  static constexpr const char* kName = "geometry_msgs/msg/Accel";
  Vector3 linear;
  Vector3 angular;
  static void Visit(auto& m, auto&& v) {
    v("linear", m.linear);
    v("angular", m.angular);
  }
};

struct Wrench {
  static constexpr const char* kName = "geometry_msgs/msg/Wrench";
  Vector3 force;
  Vector3 torque;
  static void Visit(auto& m, auto&& v) {
    v("force", m.force);
    v("torque", m.torque);
  }
};

struct Inertia {
  static constexpr const char* kName = "geometry_msgs/msg/Inertia";
  double m = 0;
  Vector3 com;
  double ixx = 0;
  double ixy = 0;
  double ixz = 0;
  double iyy = 0;
  double iyz = 0;
  double izz = 0;
  static void Visit(auto& self, auto&& v) {
    v("m", self.m);
    v("com", self.com);
    v("ixx", self.ixx);
    v("ixy", self.ixy);
    v("ixz", self.ixz);
    v("iyy", self.iyy);
    v("iyz", self.iyz);
    v("izz", self.izz);
  }
};

struct PoseStamped {
  static constexpr const char* kName = "geometry_msgs/msg/PoseStamped";
  Header header;
  Pose pose;
  static void Visit(auto& m, auto&& v) {
    v("header", m.header);
    v("pose", m.pose);
  }
};

struct TwistStamped {
  static constexpr const char* kName = "geometry_msgs/msg/TwistStamped";
  Header header;
  Twist twist;
  static void Visit(auto& m, auto&& v) {
    v("header", m.header);
    v("twist", m.twist);
  }
};

struct AccelStamped {
  static constexpr const char* kName = "geometry_msgs/msg/AccelStamped";
  Header header;
  Accel accel;
  static void Visit(auto& m, auto&& v) {
    v("header", m.header);
    v("accel", m.accel);
  }
};

struct WrenchStamped {
  static constexpr const char* kName = "geometry_msgs/msg/WrenchStamped";
  Header header;
  Wrench wrench;
  static void Visit(auto& m, auto&& v) {
    v("header", m.header);
    v("wrench", m.wrench);
  }
};

struct InertiaStamped {
  static constexpr const char* kName = "geometry_msgs/msg/InertiaStamped";
  Header header;
  Inertia inertia;
  static void Visit(auto& m, auto&& v) {
    v("header", m.header);
    v("inertia", m.inertia);
  }
};

struct JointTrajectoryPoint {
  static constexpr const char* kName = "trajectory_msgs/msg/JointTrajectoryPoint";
  std::vector<double> positions;
  std::vector<double> velocities;
  std::vector<double> accelerations;
  std::vector<double> effort;
  Duration time_from_start;
  static void Visit(auto& m, auto&& v) {
    v("positions", m.positions);
    v("velocities", m.velocities);
    v("accelerations", m.accelerations);
    v("effort", m.effort);
    v("time_from_start", m.time_from_start);
  }
};

struct JointTrajectory {
  static constexpr const char* kName = "trajectory_msgs/msg/JointTrajectory";
  Header header;
  std::vector<std::string> joint_names;
  std::vector<JointTrajectoryPoint> points;
  static void Visit(auto& m, auto&& v) {
    v("header", m.header);
    v("joint_names", m.joint_names);
    v("points", m.points);
  }
};

struct MultiDOFJointTrajectoryPoint {
  static constexpr const char* kName = "trajectory_msgs/msg/MultiDOFJointTrajectoryPoint";
  std::vector<Transform> transforms;
  std::vector<Twist> velocities;
  std::vector<Twist> accelerations;
  Duration time_from_start;
  static void Visit(auto& m, auto&& v) {
    v("transforms", m.transforms);
    v("velocities", m.velocities);
    v("accelerations", m.accelerations);
    v("time_from_start", m.time_from_start);
  }
};

struct MultiDOFJointTrajectory {
  static constexpr const char* kName = "trajectory_msgs/msg/MultiDOFJointTrajectory";
  Header header;
  std::vector<std::string> joint_names;
  std::vector<MultiDOFJointTrajectoryPoint> points;
  static void Visit(auto& m, auto&& v) {
    v("header", m.header);
    v("joint_names", m.joint_names);
    v("points", m.points);
  }
};

/// Identity of an endpoint or participant: of 16 bytes since Iron, of 24 in Humble.
template <std::size_t N>
struct GidOf {
  static constexpr const char* kName = "rmw_dds_common/msg/Gid";
  std::array<std::uint8_t, N> data{};  ///< .msg: char, which ROS 2 takes for uint8
  static void Visit(auto& m, auto&& v) { v("data", m.data); }
};
using Gid = GidOf<16>;

template <std::size_t N>
struct NodeEntitiesInfoOf {
  static constexpr const char* kName = "rmw_dds_common/msg/NodeEntitiesInfo";
  BoundedString<256> node_namespace;
  BoundedString<256> node_name;
  std::vector<GidOf<N>> reader_gid_seq;
  std::vector<GidOf<N>> writer_gid_seq;
  static void Visit(auto& m, auto&& v) {
    v("node_namespace", m.node_namespace);
    v("node_name", m.node_name);
    v("reader_gid_seq", m.reader_gid_seq);
    v("writer_gid_seq", m.writer_gid_seq);
  }
};
using NodeEntitiesInfo = NodeEntitiesInfoOf<16>;

template <std::size_t N>
struct ParticipantEntitiesInfoOf {
  static constexpr const char* kName = "rmw_dds_common/msg/ParticipantEntitiesInfo";
  GidOf<N> gid;
  std::vector<NodeEntitiesInfoOf<N>> node_entities_info_seq;
  static void Visit(auto& m, auto&& v) {
    v("gid", m.gid);
    v("node_entities_info_seq", m.node_entities_info_seq);
  }
};
using ParticipantEntitiesInfo = ParticipantEntitiesInfoOf<16>;

}  // namespace msg

/// Calls visitor.operator()<M>() for each message above.
void ForEachMessage(auto&& visitor) {
  visitor.template operator()<msg::Time>();
  visitor.template operator()<msg::Duration>();
  visitor.template operator()<msg::Clock>();
  visitor.template operator()<msg::Header>();
  visitor.template operator()<msg::String>();
  visitor.template operator()<msg::JointState>();
  visitor.template operator()<msg::Vector3>();
  visitor.template operator()<msg::Point>();
  visitor.template operator()<msg::Quaternion>();
  visitor.template operator()<msg::Transform>();
  visitor.template operator()<msg::TransformStamped>();
  visitor.template operator()<msg::TFMessage>();
  visitor.template operator()<msg::Pose>();
  visitor.template operator()<msg::Twist>();
  visitor.template operator()<msg::Accel>();
  visitor.template operator()<msg::Wrench>();
  visitor.template operator()<msg::Inertia>();
  visitor.template operator()<msg::PoseStamped>();
  visitor.template operator()<msg::TwistStamped>();
  visitor.template operator()<msg::AccelStamped>();
  visitor.template operator()<msg::WrenchStamped>();
  visitor.template operator()<msg::InertiaStamped>();
  visitor.template operator()<msg::JointTrajectoryPoint>();
  visitor.template operator()<msg::JointTrajectory>();
  visitor.template operator()<msg::MultiDOFJointTrajectoryPoint>();
  visitor.template operator()<msg::MultiDOFJointTrajectory>();
  visitor.template operator()<msg::Gid>();
  visitor.template operator()<msg::NodeEntitiesInfo>();
  visitor.template operator()<msg::ParticipantEntitiesInfo>();
}

}  // namespace twin::ros2
