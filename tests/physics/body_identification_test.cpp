// SPDX-License-Identifier: BSD-3-Clause
// Mikami et al. 2014, equations 2 and 3: the robot's own parameters from what its base and its drives feel.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include <unistd.h>

#include "diagnosis/identification/identify.h"
#include "diagnosis/identification/motions.h"
#include "diagnosis/identification/physical_body.h"
#include "tests/test_places.h"

namespace hrp::identification {
namespace {

const std::string kScenario = source_dir() + "/models/scenarios/paper_b/foot.yaml";

struct Found {
  Scenario scenario;
  BodyFit body;
};

// Sensors with noise and bias, half a minute of motion, a description that is wrong by a tenth.
Found identify_simulated_body() {
  const std::string folder = (std::filesystem::temp_directory_path() / ("body_" + std::to_string(getpid()))).string();
  std::filesystem::create_directories(folder);
  Found found{load_scenario(kScenario), {}};
  std::vector<Source> sources = {
      {kHanging, run_in_process(load_scenario(write_hanging(found.scenario, folder))), false}};
  for (const MotionPlan& plan : make_plans(0.6)) {
    if (plan.name != "swing1" && plan.name != "swing3" && plan.name != "tilt2" && plan.name != "squat") continue;
    sources.push_back(
        {plan.name, run_in_process(load_scenario(write_motion(plan, found.scenario, folder))), plan.name != "squat"});
  }
  std::filesystem::remove_all(folder);
  const BushObserver observer(found.scenario);
  const Observation o = observe(observer, sources);
  const BushFit fit = fit_bush(o.fitted, o.zeros, observer.bush_centres(), o.options);
  found.body = identify_body(found.scenario, sources, o.zeros, fit, true);
  return found;
}

TEST(BodyIdentification, FindsMassesWithoutTorquesAndFrictionWithThem) {
  const Found found = identify_simulated_body();
  const BodyRig rig(found.scenario);
  const Eigen::VectorXd truth = found.body.T * make_inertial_parameters(rig.model);
  // The vertical force and the accelerometer's zero are known to 1e-4 of the weight.
  EXPECT_NEAR(found.body.parameters[0].estimate.value / truth[0], 1.0, 1e-3);
  EXPECT_GT(std::abs(found.body.parameters[0].described / truth[0] - 1.0), 0.01) << "the description is wrong";
  int shown = 0, near = 0;
  for (size_t i = 1; i < found.body.parameters.size(); ++i) {
    const BodyParameter& p = found.body.parameters[i];
    if (!p.is_shown()) continue;
    ++shown;
    near += std::abs(p.estimate.value - truth[static_cast<Eigen::Index>(i)]) < 4.0 * p.estimate.std;
  }
  std::printf("%d of %zu parameters shown, %d within four standard deviations\n", shown, found.body.parameters.size(),
              near);
  EXPECT_GE(shown, 2);  // half a minute tells the mass, one moment of mass, and combinations of the others
  EXPECT_EQ(near, shown);
  int joints = 0, knees = 0;
  for (const JointEstimate& joint : found.body.joints) {
    if (joint.name.find("KNEE") != std::string::npos) {
      // [M14 eq. 3] with what the ankles exert on the leg, tens of N m: its friction of 3 N m is small beside it.
      std::printf("%s: Coulomb %.3f +- %.3f\n", joint.name.c_str(), joint.values[2].value, joint.values[2].std);
      EXPECT_NEAR(joint.values[2].value, 3.0, 1.5) << joint.name << ", three of its standard deviations";
      ++knees;
    }
    if (joint.name.find("WRIST") == std::string::npos) continue;
    ++joints;
    std::printf("%s: rotor %.4f, viscous %.3f, Coulomb %.3f\n", joint.name.c_str(), joint.values[0].value,
                joint.values[1].value, joint.values[2].value);
    const double rotor = make_joint_parameters(rig.model)[kJointParameters * joint.joint];
    // A tenth of noise on 0.4 N m of friction, some hundred independent samples a joint.
    EXPECT_NEAR(joint.values[0].value / rotor, 1.0, 0.15) << joint.name;
    EXPECT_NEAR(joint.values[1].value / 0.5, 1.0, 0.1) << joint.name;
    EXPECT_NEAR(joint.values[2].value / 0.4, 1.0, 0.1) << joint.name;
  }
  EXPECT_EQ(joints, 4);
  EXPECT_EQ(knees, 2);
  EXPECT_GT(found.body.smallest_eigenvalue, 0.0);
  for (const BodyError& e : found.body.errors) {
    EXPECT_LT(e.physical[0], 0.1 * e.described[0]) << e.motion;
    if (e.fitted) continue;
    EXPECT_LT(e.physical[0], 0.02 * e.largest[0]) << e.motion;  // noise of 0.02 N m a sensor on 5 N m, and the vertical
  }
}

TEST(BodyIdentification, BodiesStayBodiesWhenDataPullThemOut) {
  const BodyRig rig(load_scenario(kScenario));
  const Eigen::VectorXd truth = make_inertial_parameters(rig.model);
  EXPECT_GT(calc_smallest_eigenvalue(distort_bodies(truth, 0.2, 3)), 0.0);
  // Data that say with certainty that the pelvis has half its mass less than nothing.
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(truth.size(), truth.size());
  Eigen::VectorXd b = Eigen::VectorXd::Zero(truth.size());
  A(0, 0) = 1e8;
  b[0] = -0.5 * truth[0] * 1e8;
  const Eigen::VectorXd nearest = solve_bodies(A, b, make_body_prior(truth, 0.2));
  EXPECT_GT(calc_smallest_eigenvalue(nearest), 0.0);
  EXPECT_GT(nearest[0], 0.0);
  EXPECT_LT(nearest[0], 0.1 * truth[0]);
  // Where nothing is said they stay.
  EXPECT_NEAR((nearest.tail(kInertialParameters) - truth.tail(kInertialParameters)).norm() /
                  truth.tail(kInertialParameters).norm(),
              0.0, 1e-3);
}

}  // namespace
}  // namespace hrp::identification
