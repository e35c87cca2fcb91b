#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <type_traits>

#include <nlohmann/json.hpp>

#include "twin/model/mass_properties.h"

namespace twin::model {

/// tests/data/model_reference.json: what a second implementation answers, see README.md there.
class ModelReference {
 public:
  ModelReference() : json_(Parse()) {}

  [[nodiscard]] const nlohmann::json& samples() const { return json_.at("samples"); }

  [[nodiscard]] Payload Load(const std::string& name) const {
    const nlohmann::json& load = json_.at("loads").at(name);
    if (load.is_null()) return {};
    return {load.at("m").get<double>(), load.at("F_x_C").get<Vector3>(),
            load.at("I").get<Matrix3>()};
  }

  /// Compares actual(q, dq, payload) with the field of every sample.
  template <typename Call>
  void ExpectEverySample(const std::string& field, Call actual) const {
    constexpr double kTolerance = 1e-9;  // the file's own digits, see there
    for (std::size_t i = 0; i < samples().size(); ++i) {
      const nlohmann::json& sample = samples()[i];
      const auto q = sample.at("q").get<JointVector>();
      const auto dq = sample.at("dq").get<JointVector>();
      const auto load = sample.at("load").get<std::string>();
      const auto result = actual(q, dq, Load(load));
      const auto expected = sample.at(field).get<std::remove_cv_t<decltype(result)>>();
      EXPECT_THAT(result, testing::Pointwise(testing::DoubleNear(kTolerance), expected))
          << field << " of sample " << i << ", load " << load;
    }
  }

 private:
  static nlohmann::json Parse() {
    std::ifstream file(TWIN_SOURCE_DIR "/tests/data/model_reference.json");
    return nlohmann::json::parse(file);
  }

  nlohmann::json json_;
};

}  // namespace twin::model
