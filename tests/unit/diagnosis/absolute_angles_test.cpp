// SPDX-License-Identifier: BSD-3-Clause
// Logs whose angles count against the base.
#include "diagnosis/conventions/absolute_angles.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "common/base/diagnostics.h"
#include "diagnosis/conventions/log_conventions.h"
#include "diagnosis/simulation/bodies.h"
#include "tests/unit/diagnosis/joint_sines.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

// Three links in a vertical plane. The second axis turns in the opposite sense.
constexpr char kPlanar[] = R"(<robot name="planar"><link name="base"/>
<link name="a"><inertial><origin xyz="0 0 -0.2"/><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>
<link name="b"><inertial><origin xyz="0.02 0 -0.15"/><mass value="1.5"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>
<link name="c"><inertial><origin xyz="0 0 -0.1"/><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
<joint name="j1" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/><limit lower="-9" upper="9" effort="150" velocity="9"/></joint>
<joint name="j2" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 -0.4"/><axis xyz="0 -1 0"/><limit lower="-9" upper="9" effort="150" velocity="9"/></joint>
<joint name="j3" type="revolute"><parent link="b"/><child link="c"/><origin xyz="0 0 -0.3"/><axis xyz="0 1 0"/><limit lower="-9" upper="9" effort="150" velocity="9"/></joint>
</robot>)";
constexpr int kJoints = 3;

// The log of a motion with friction; `of_base`: joints whose logged angle is against the base.
Experiment make_log(const std::string& name, const std::vector<int>& of_base, bool of_efforts,
                    const char* drive = "effort") {
  Experiment e = make_simulated_experiment(name, kPlanar, {"j1", "j2", "j3"}, {});
  e.scenario.drive = drive;
  const Plant plant = make_plant(e, {});
  for (size_t i = 0; i < e.recordings.size(); ++i) {
    Recording& r = e.recordings[i];
    const JointMotion m =
        make_joint_sines({kJoints, 0.01, 20.0, 0.9, 0.13, 0.5, [](int j) { return 0.3 * j; }}, static_cast<int>(i));
    Eigen::MatrixXd tau = calc_efforts(plant, m.q, m.v, m.a) + 0.3 * (m.v / 0.005).array().tanh().matrix(), q = m.q;
    const Eigen::MatrixXd of_joints = tau;
    for (int j = 1; j < kJoints; ++j) {  // each sense is the opposite of the one before
      if (std::find(of_base.begin(), of_base.end(), j) == of_base.end()) continue;
      q.col(j) -= q.col(j - 1);
      if (of_efforts) tau.col(j - 1) += of_joints.col(j);
    }
    r.time.clear();
    for (long k = 0; k < q.rows(); ++k) r.time.push_back(0.01 * static_cast<double>(k));
    for (int j = 0; j < kJoints; ++j) {
      JointColumns& joint = r.joints[static_cast<size_t>(j)];
      joint = {};
      joint.signal[0].assign(q.col(j).begin(), q.col(j).end());
      joint.signal[2].assign(tau.col(j).begin(), tau.col(j).end());
    }
  }
  return e;
}

AbsoluteAngles find(const Experiment& e) {
  const TorqueData data = make_torque_data(e);
  return find_absolute_angles(data, sample_motion(data), 1);
}

TEST(AbsoluteAngles, AJointThatIsMeasuredAgainstTheBaseIsFound) {
  const AbsoluteAngles found = find(make_log("absolute_one", {1}, false));
  ASSERT_EQ(found.joints.size(), 1u);
  EXPECT_EQ(found.joints[0].joint, 1);
  EXPECT_EQ(found.joints[0].sense, -1.0);
  EXPECT_FALSE(found.of_efforts);
}

TEST(AbsoluteAngles, MotorsOnTheBaseAreFound) {
  const AbsoluteAngles found = find(make_log("absolute_motors", {1, 2}, true));
  EXPECT_EQ(found.joints.size(), 2u);
  EXPECT_TRUE(found.of_efforts);
}

TEST(AbsoluteAngles, AnglesOfTheModelStay) { EXPECT_FALSE(find(make_log("relative", {}, false)).any()); }

TEST(AbsoluteAngles, ConvertedRecordingsAreThoseOfTheModel) {
  const Experiment of_model = make_log("converted_model", {}, false), logged = make_log("converted_log", {1, 2}, true);
  const Experiment converted = convert_angles(logged, {{{1, 0, -1.0}, {2, 1, -1.0}}, true});
  for (size_t j = 0; j < kJoints; ++j) {
    for (const int q : {0, 2}) {
      const std::vector<double>&is = converted.recordings[0].joints[j].signal[q],
            &was = of_model.recordings[0].joints[j].signal[q];
      for (size_t k = 0; k < was.size(); k += 97) EXPECT_NEAR(is[k], was[k], 1e-12);
    }
  }
}

// The law of a servo that holds such an angle is not that of the model's joint.
TEST(AbsoluteAngles, ServosThatHoldThemAreRefusedByName) {
  try {
    find(make_log("absolute_servo", {1}, false, "servo"));
    FAIL() << "not refused";
  } catch (const InputError& error) {
    EXPECT_THAT(std::string(error.what()),
                testing::HasSubstr("/joint_states/j2/position: is an angle against the base"));
  }
}

// Gravity along all axes, and a controller that compensates it, leave the same efforts.
TEST(PlanarArms, EffortsWithoutWeightMayMeanThatTheRobotLiesOnItsSide) {
  Experiment e = make_log("table", {}, false);
  const Plant plant = make_plant(e, {});
  for (Recording& r : e.recordings) {
    Eigen::MatrixXd q(static_cast<long>(r.size()), kJoints);
    for (int j = 0; j < kJoints; ++j)
      q.col(j) = Eigen::Map<const Eigen::VectorXd>(r.joints[static_cast<size_t>(j)].signal[0].data(), q.rows());
    const Eigen::MatrixXd weight = calc_efforts(plant, q, 0.0 * q, 0.0 * q);
    for (int j = 0; j < kJoints; ++j) {
      for (long k = 0; k < q.rows(); ++k)
        r.joints[static_cast<size_t>(j)].signal[2][static_cast<size_t>(k)] -= weight(k, j);
    }
  }
  const LogConventions found = find_conventions(e, 1);
  ASSERT_EQ(found.absent.part, Absent::kWeight);
  Reports reports;
  reports.report = {{"verdict", "explained"}, {"findings", Json::array()}, {"warnings", Json::array()}};
  reports.series = {{"notes", Json::array()}};
  add_conventions(e, found, &reports);
  const Json& finding = reports.report["findings"][0];
  EXPECT_EQ(finding["effect"], "gravity_compensation");
  EXPECT_EQ(finding["grade"], "ambiguous");
  EXPECT_EQ(finding["alternatives"][0]["effect"], "base_tilt");
}

}  // namespace
}  // namespace hrp::diagnosis
