// SPDX-License-Identifier: BSD-3-Clause
// What two columns of one joint say of each other needs no model of the robot.
#include <gtest/gtest.h>

#include "diagnosis/findings/column_findings.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis {
namespace {

Finding make_late(const std::string& sensor) {
  Finding f;
  f.effect = "sensor_delay";
  f.family = "timing";
  f.where = {{"sensor", sensor}};
  f.grade = Grade::kSupported;
  f.parameters = {{"delay", "s", {0.02}, {0.001}, false}};
  return f;
}

Json make_unexplained() { return {{"verdict", "unexplained"}, {"findings", Json::array()}}; }

TEST(ColumnFindings, ALateVelocityIsSaidWhereASearchExplainsNothing) {
  Json report = make_unexplained();
  add_column_findings({make_late("/joint_states/elbow/velocity"), make_late("/joint_states/elbow/effort")}, &report);
  ASSERT_EQ(report["findings"].size(), 1u) << report.dump(1);  // efforts are judged by the model
  EXPECT_EQ(report["findings"][0]["where"]["sensor"], "/joint_states/elbow/velocity");
  EXPECT_EQ(report["verdict"], "partly_explained");
}

TEST(ColumnFindings, WhatTheSearchNamesAtTheColumnIsNotSaidTwice) {
  Json report = make_unexplained();
  report["findings"].push_back({{"effect", "sensor_scale"}, {"where", {{"sensor", "/joint_states/elbow/velocity"}}}});
  add_column_findings({make_late("/joint_states/elbow/velocity")}, &report);
  EXPECT_EQ(report["findings"].size(), 1u);
}

TEST(ColumnFindings, WithoutThemTheReportStays) {
  Json report = make_unexplained();
  add_column_findings({}, &report);
  EXPECT_EQ(report["verdict"], "unexplained");
}

}  // namespace
}  // namespace hrp::diagnosis
