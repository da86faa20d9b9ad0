// SPDX-License-Identifier: BSD-3-Clause
// Grades that hold for every engine: what may not be there is never more than ambiguous.
#include <gtest/gtest.h>

#include "diagnosis/findings/schema2.h"
#include "diagnosis/findings/simpler_law.h"

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

Json make_curve(double static_low, double speed_low, double viscous_low) {
  const auto estimate = [](double value, double low, double high) -> Json {
    return {{"value", value}, {"std", 0.0}, {"ci95", {low, high}}, {"unit", "N m"}};
  };
  Json f{{"effect", "stribeck_friction"}, {"grade", "certain"}, {"where", {{"joint", "elbow"}}}, {"alternatives", Json::array()}};
  f["parameters"] = {{"coulomb", estimate(0.3, 0.28, 0.32)},
                     {"static", estimate(0.33, static_low, 0.6)},
                     {"stribeck_velocity", estimate(0.012, speed_low, 0.1)},
                     {"viscous", estimate(0.01, viscous_low, 0.03)}};
  return {{"findings", {f}}};
}

// Plain dry friction of 0.3 N m in a simulation was named a Stribeck curve with these intervals, `certain`.
TEST(Grades, DryFrictionWhoseExcessAtRestIsNotToldIsCoulombs) {
  Json report = make_curve(0.06, -0.08, -0.014);
  name_simpler_laws(&report);
  ASSERT_EQ(report["findings"].size(), 1u);
  const Json& f = report["findings"][0];
  EXPECT_EQ(f["effect"], "coulomb_friction");
  EXPECT_EQ(f["grade"], "supported");
  EXPECT_EQ(f["parameters"]["level"]["value"], 0.3);
  EXPECT_EQ(f["alternatives"][0]["effect"], "stribeck_friction");
}

TEST(Grades, ViscousFrictionThatIsToldIsNamedBesideCoulombs) {
  Json report = make_curve(0.06, -0.08, 0.005);
  name_simpler_laws(&report);
  ASSERT_EQ(report["findings"].size(), 2u);
  EXPECT_EQ(report["findings"][1]["effect"], "viscous_friction");
}

TEST(Grades, AStribeckCurveWithAToldExcessOrSpeedStays) {
  for (const auto& [excess, speed] : {std::pair{0.32, -0.08}, std::pair{0.06, 0.002}}) {
    Json report = make_curve(excess, speed, -0.014);
    name_simpler_laws(&report);
    EXPECT_EQ(report["findings"][0]["effect"], "stribeck_friction");
    EXPECT_EQ(report["findings"][0]["grade"], "certain");
  }
}

}  // namespace
}  // namespace hrp::diagnosis
