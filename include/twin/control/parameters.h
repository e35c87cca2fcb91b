#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/quantity.h"
#include "twin/core/time.h"

namespace twin::control {

/// One parameter as written, not yet interpreted.
struct Parameter {
  /// Dotted keys from the outermost in: "stiffness.translation".
  std::string key;
  std::vector<std::string> values;  ///< one value, or the list's
  bool is_list = false;
  std::string where{};  ///< "<file>:<line>"; empty if not read from a file

  /// Ignores `where`.
  bool operator==(const Parameter& other) const {
    return key == other.key && values == other.values && is_list == other.is_list;
  }
};

/// In written order; keys are unique.
using Parameters = std::vector<Parameter>;

/// Reads a controller's parameters by key: checks unit and range, and returns the default if the
/// key is absent. All bounds and results are in the dimension's base unit (core/quantity.h).
///
/// Throws InputError "<file>:<line>: <path>.<key>: what is wrong, what is accepted" for a bad
/// value. RefuseUnread() refuses parameters that were never read.
///
/// Threads: one thread. Not for real time.
class ParameterReader {
 public:
  /// @param parameters  must outlive the reader.
  /// @param path        prefix of all keys in messages.
  explicit ParameterReader(const Parameters& parameters,
                           std::string path = "controller.parameters");

  /// @returns true if the key, or a key below it, was given.
  [[nodiscard]] bool Has(std::string_view key) const;

  /// @returns all parameters below a key, unread and without the key's prefix, for another reader.
  /// They count as read.
  [[nodiscard]] Parameters Below(std::string_view key);

  /// A plain number, in [least, most].
  [[nodiscard]] double Number(std::string_view key, double otherwise, double least, double most);
  /// A number with its unit: "600 Nm/rad".
  [[nodiscard]] double Quantity(std::string_view key, Dimension dimension, double otherwise,
                                double least, double most);
  /// "100 ms".
  [[nodiscard]] Duration Time(std::string_view key, Duration otherwise, Duration least,
                              Duration most);
  /// "true" or "false".
  [[nodiscard]] bool Bool(std::string_view key, bool otherwise);
  /// A plain word or text.
  [[nodiscard]] std::string Text(std::string_view key, std::string_view otherwise);
  /// @returns one of the names.
  [[nodiscard]] std::string Choice(std::string_view key, std::string_view otherwise,
                                   std::initializer_list<std::string_view> names);
  /// One quantity for all axes, or a list of three.
  [[nodiscard]] Vector3 Vector(std::string_view key, Dimension dimension, const Vector3& otherwise,
                               double least, double most);
  /// One quantity for all joints, or {unit: Nm/rad, values: [7 plain numbers]}.
  [[nodiscard]] JointVector Joints(std::string_view key, Dimension dimension,
                                   const JointVector& otherwise, double least, double most);

  /// @returns "<file>:<line>: <path>.<key>: " for later messages; without the file if the key was
  /// not given.
  [[nodiscard]] std::string PlaceOf(std::string_view key) const;

  /// Refuses a given parameter for the controller's own reason. @throws InputError always.
  [[noreturn]] void Refuse(std::string_view key, std::string_view why) const;

  /// @throws InputError for the first parameter that was never read, listing the keys that were.
  void RefuseUnread() const;

 private:
  const Parameter* Find(std::string_view key);
  const std::string& Scalar(const Parameter& parameter, std::string_view wanted) const;
  double QuantityOf(const Parameter& parameter, std::string_view text, Dimension dimension,
                    double least, double most) const;
  double NumberOf(const Parameter& parameter, std::string_view text, double least,
                  double most) const;
  [[noreturn]] void Fail(const Parameter& parameter, std::string_view what) const;

  const Parameters& parameters_;
  std::string path_;
  std::vector<std::string> asked_;  ///< keys, in the order of their first read
};

}  // namespace twin::control
