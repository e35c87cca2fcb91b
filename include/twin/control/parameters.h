#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/quantity.h"
#include "twin/core/time.h"

namespace twin::control {

/// One parameter as it was written, before anybody knows what it means.
struct Parameter {
  /// Its keys from the outside in, dotted: "stiffness.translation".
  std::string key;
  std::vector<std::string> values;  ///< one, or those of a list
  bool is_list = false;
  std::string where{};  ///< "<file>:<line>"; empty when it was not read from a file

  /// Where it was read is no part of the comparison.
  bool operator==(const Parameter& other) const {
    return key == other.key && values == other.values && is_list == other.is_list;
  }
};

/// In the order in which they were written; no key twice.
using Parameters = std::vector<Parameter>;

/// Gives a controller its parameters: by key, checked for unit and range, the default when one was
/// not given. All bounds and results are in the dimension's base unit (core/quantity.h).
///
/// A value that does not fit is refused by an InputError "<file>:<line>: <path>.<key>: what is
/// wrong, what is accepted". What nobody asked for is refused by RefuseUnread().
///
/// Threads: one thread. Not for real time.
class ParameterReader {
 public:
  /// @param parameters  must outlive the reader.
  /// @param path        of all keys, for messages.
  explicit ParameterReader(const Parameters& parameters,
                           std::string path = "controller.parameters");

  /// Whether the key was given, or keys below it.
  [[nodiscard]] bool Has(std::string_view key) const;

  /// All parameters below a key, their keys without it, as they were written: for somebody else to
  /// understand. They count as asked for.
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
  /// One of the names. @returns it.
  [[nodiscard]] std::string Choice(std::string_view key, std::string_view otherwise,
                                   std::initializer_list<std::string_view> names);
  /// One quantity for all axes, or a list of three.
  [[nodiscard]] Vector3 Vector(std::string_view key, Dimension dimension, const Vector3& otherwise,
                               double least, double most);
  /// One quantity for all joints, or {unit: Nm/rad, values: [7 plain numbers]}.
  [[nodiscard]] JointVector Joints(std::string_view key, Dimension dimension,
                                   const JointVector& otherwise, double least, double most);

  /// "<file>:<line>: <path>.<key>: ", for messages of later; without the file when it was not
  /// given.
  [[nodiscard]] std::string PlaceOf(std::string_view key) const;

  /// Refuses a parameter that was given for a reason of the controller's own.
  [[noreturn]] void Refuse(std::string_view key, std::string_view why) const;

  /// @throws InputError for the first parameter that was never asked for, naming those that were.
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
  std::vector<std::string> asked_;  ///< keys, in the order in which they were first asked for
};

}  // namespace twin::control
