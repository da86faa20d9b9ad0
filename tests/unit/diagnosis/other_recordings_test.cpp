// SPDX-License-Identifier: BSD-3-Clause
// Real sets as other people would hand them over: what is named there may be less, but nothing else.
#include <gtest/gtest.h>

#include <filesystem>

#include "diagnosis/evidence/torque_findings.h"
#include "test_places.h"

namespace hrp::diagnosis {
namespace {

std::filesystem::path find_set(const std::string& name) {
  return std::filesystem::path(HRP_SOURCE_DIR) / "../shared/recordings" / name / "experiment.yaml";
}

// With kd 1.5 and kp 20 a delay of 12 ms is a rotor of 0.018 kg m^2 and viscous friction of 0.24 N m s/rad: what its authors
// found in each hip and thigh. Late commands explain no more than these and took their place, supported, at twelve joints.
TEST(OtherRecordings, WithRolesExchangedADelayTakesNotThePlaceOfARealRobotsRotors) {
  const std::filesystem::path path = find_set("go2_hanging");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  Experiment e = load_experiment(path.string());
  for (Recording& r : e.recordings) r.spec.train = !r.spec.train;
  int rotors = 0;
  for (const Finding& f : judge_torque(e, 1).evidence.findings) {
    rotors += f.effect == "rotor_inertia" ? 1 : 0;
    EXPECT_FALSE(f.effect == "command_delay" && f.grade == Grade::kSupported) << f.statement;
  }
  EXPECT_GE(rotors, 7);  // more than half of twelve
}

}  // namespace
}  // namespace hrp::diagnosis
