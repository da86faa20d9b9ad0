// SPDX-License-Identifier: BSD-3-Clause
// Grades that hold for every engine: what may not be there is never more than ambiguous.
#include <gtest/gtest.h>

#include "diagnosis/findings/schema2.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

std::string lower(const std::string& effect, const Json& parameters) {
  Json report{{"findings", {{{"effect", effect}, {"grade", "supported"}, {"parameters", parameters}}}}};
  lower_grades(&report);
  return report["findings"][0]["grade"];
}

TEST(Grades, FrictionWhoseIntervalHoldsNoneIsAmbiguous) {
  EXPECT_EQ(lower("viscous_friction", {{"coefficient", {{"value", 0.1}, {"ci95", {-0.01, 0.21}}}}}), "ambiguous");
  EXPECT_EQ(lower("viscous_friction", {{"coefficient", {{"value", 0.1}, {"ci95", {0.01, 0.19}}}}}), "supported");
}

TEST(Grades, AScaleIsAbsentAtOneAndNotAtZero) {
  EXPECT_EQ(lower("sensor_scale", {{"scale", {{"value", 1.02}, {"ci95", {0.98, 1.06}}}}}), "ambiguous");
  EXPECT_EQ(lower("sensor_scale", {{"scale", {{"value", 0.4}, {"ci95", {-0.1, 0.9}}}}}), "supported");
}

TEST(Grades, AVectorIsThereIfOneAxisIs) {
  const Json none{{"value", {0.1, 0.0, 0.0}}, {"ci95", {{-0.1, 0.3}, {-0.1, 0.1}, {-0.1, 0.1}}}};
  const Json some{{"value", {0.1, 0.0, 0.0}}, {"ci95", {{0.05, 0.15}, {-0.1, 0.1}, {-0.1, 0.1}}}};
  EXPECT_EQ(lower("sensor_bias", {{"value", none}}), "ambiguous");
  EXPECT_EQ(lower("sensor_bias", {{"value", some}}), "supported");
}

}  // namespace
}  // namespace hrp::diagnosis
