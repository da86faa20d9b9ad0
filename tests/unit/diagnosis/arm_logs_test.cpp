// SPDX-License-Identifier: BSD-3-Clause
// Logs of an arm whose efforts, signs or order of joints are not the model's.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/base/diagnostics.h"
#include "diagnosis/conventions/absent_torque.h"
#include "diagnosis/conventions/exchanged_joints.h"
#include "diagnosis/measurement/joint_zeros.h"
#include "diagnosis/simulation/bodies.h"
#include "tests/unit/diagnosis/joint_sines.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

constexpr int kJoints = 4;
constexpr double kStep = 0.01, kSeconds = 20.0;

// An upright axis, two level ones, and one along the forearm, which bears what is not on its axis.
std::string make_urdf(double gripper) {
  std::ostringstream s;
  s << "<robot name=\"arm\"><link name=\"base\"/>";
  const char *origin[] = {"0 0 0.1", "0 0 0.2", "0.4 0 0", "0.3 0 0"}, *axis[] = {"0 0 1", "0 1 0", "0 1 0", "1 0 0"};
  const double mass[] = {3.0, 4.0, 2.0, 0.5 + gripper}, x[] = {0.02, 0.2, 0.15, 0.05}, y[] = {0.0, 0.01, 0.02, 0.03};
  for (int j = 0; j < kJoints; ++j) {
    s << "<link name=\"l" << j + 1 << "\"><inertial><origin xyz=\"" << x[j] << " " << y[j] << " 0\"/><mass value=\""
      << mass[j]
      << "\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" izz=\"0.02\"/></inertial></link><joint "
         "name=\"j"
      << j + 1 << "\" type=\"revolute\"><parent link=\"" << (j == 0 ? "base" : "l" + std::to_string(j))
      << "\"/><child link=\"l" << j + 1 << "\"/><origin xyz=\"" << origin[j] << "\"/><axis xyz=\"" << axis[j]
      << "\"/><limit lower=\"-3\" upper=\"3\" effort=\"150\" velocity=\"9\"/></joint>";
  }
  s << "</robot>";
  return s.str();
}

using Motion = JointMotion;

Motion make_motion(int recording) {
  return make_joint_sines({kJoints, kStep, kSeconds, 0.9, 0.13, 0.5, [](int j) { return 0.4 * (j + 1) - 0.8; }},
                          recording);
}

Eigen::MatrixXd calc_friction(const Motion& m) {
  return (0.6 * (m.v / 0.005).array().tanh() + 0.4 * m.v.array()).matrix();
}

// The efforts of the log, of friction, the arm without a gripper and the arm with it [N m].
using Efforts = std::function<Eigen::MatrixXd(const Motion&, const Plant& nominal, const Plant& with_gripper)>;

void write_recording(const std::filesystem::path& path, const Motion& m, const Eigen::MatrixXd& effort) {
  std::ofstream csv(path);
  csv.precision(9);
  csv << "time";
  for (int j = 1; j <= kJoints; ++j) csv << ",/joint_states/j" << j << "/position,/joint_states/j" << j << "/effort";
  for (long k = 0; k < m.q.rows(); ++k) {
    csv << "\n" << kStep * static_cast<double>(k);
    for (int j = 0; j < kJoints; ++j) csv << "," << m.q(k, j) << "," << effort(k, j);
  }
  csv << "\n";
}

Experiment load(const std::filesystem::path& folder, double gripper) {
  std::ofstream(folder / "robot.urdf") << make_urdf(gripper);
  return load_experiment((folder / "experiment.yaml").string());
}

Experiment make_arm(const std::string& name, const Efforts& efforts) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("hrp_arm_logs_" + name);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "experiment.yaml") << "robot: robot.urdf\nbase: fixed\ndrive: effort\nrecordings:\n"
                                               "- {file: r0.csv, role: train}\n- {file: r1.csv, role: validate}\n";
  for (int r = 0; r < 2; ++r)
    write_recording(folder / ("r" + std::to_string(r) + ".csv"), make_motion(r), calc_friction(make_motion(r)));
  const Plant with_gripper = make_plant(load(folder, 1.0), {}), nominal = make_plant(load(folder, 0.0), {});
  TestNoise noise;
  for (int r = 0; r < 2; ++r) {
    const Motion m = make_motion(r);
    Eigen::MatrixXd y = efforts(m, nominal, with_gripper);
    for (long k = 0; k < y.rows(); ++k) {
      for (long j = 0; j < y.cols(); ++j) y(k, j) += 0.02 * noise.draw();
    }
    write_recording(folder / ("r" + std::to_string(r) + ".csv"), m, y);
  }
  return load(folder, 0.0);
}

Eigen::MatrixXd calc_weight(const Plant& arm, const Motion& m) { return calc_efforts(arm, m.q, 0.0 * m.v, 0.0 * m.a); }
Eigen::MatrixXd calc_all(const Plant& arm, const Motion& m) { return calc_efforts(arm, m.q, m.v, m.a); }

TEST(ArmLogs, AControllersTorqueBesideItsGravityCompensationLacksTheWeightThoughAGripperPulls) {
  const Experiment e = make_arm("weight", [](const Motion& m, const Plant& nominal, const Plant& with_gripper) {
    return Eigen::MatrixXd(calc_friction(m) + calc_all(with_gripper, m) - calc_weight(nominal, m));
  });
  EXPECT_EQ(find_absent_torque(make_torque_data(e)).part, Absent::kWeight);
}

TEST(ArmLogs, AnExternalTorqueLacksWeightAndInertiaThoughAGripperPulls) {
  const Experiment e = make_arm("external", [](const Motion& m, const Plant& nominal, const Plant& with_gripper) {
    return Eigen::MatrixXd(calc_friction(m) + calc_all(with_gripper, m) - calc_all(nominal, m));
  });
  EXPECT_EQ(find_absent_torque(make_torque_data(e)).part, Absent::kBodies);
  const Experiment returned = return_torque(e, Absent::kBodies);
  EXPECT_EQ(find_absent_torque(make_torque_data(returned)).part, Absent::kNothing);
}

TEST(ArmLogs, CurrentsAndTorquesLackNothing) {
  for (const double unit : {1.0, 0.08}) {
    const Experiment e = make_arm("whole", [unit](const Motion& m, const Plant&, const Plant& with_gripper) {
      return Eigen::MatrixXd(unit * (calc_friction(m) + calc_all(with_gripper, m)));
    });
    EXPECT_EQ(find_absent_torque(make_torque_data(e)).part, Absent::kNothing) << unit;
  }
}

TEST(ArmLogs, TheJointThatIsTurnedIsFoundThoughAnotherOneBeforeItDoesAPart) {
  const Experiment e = make_arm("turned", [](const Motion& m, const Plant& nominal, const Plant&) {
    Motion turned = m;
    for (Eigen::MatrixXd* x : {&turned.q, &turned.v, &turned.a}) x->col(2) *= -1.0;
    Eigen::MatrixXd tau = calc_all(nominal, turned);
    tau.col(2) *= -1.0;
    return Eigen::MatrixXd(tau + calc_friction(m));
  });
  const JointZeros found = find_joint_zeros(make_torque_data(e));
  ASSERT_EQ(found.joints.size(), 1U);
  EXPECT_EQ(found.joints[0].joint, 2);
  EXPECT_TRUE(found.joints[0].turned);
}

void check_for_exchanged_joints(const Experiment& e) {
  const TorqueData data = make_torque_data(e);
  check_exchanged_joints(data, sample_motion(data), 1);
}

TEST(ArmLogs, ExchangedJointsAreNamed) {
  const Experiment e = make_arm("exchanged", [](const Motion& m, const Plant& nominal, const Plant&) {
    Motion other = m;
    for (Eigen::MatrixXd* x : {&other.q, &other.v, &other.a}) x->col(1).swap(x->col(2));
    Eigen::MatrixXd tau = calc_all(nominal, other);
    tau.col(1).swap(tau.col(2));
    return Eigen::MatrixXd(tau + calc_friction(m));
  });
  try {
    check_for_exchanged_joints(e);
    FAIL() << "not seen";
  } catch (const InputError& error) {
    EXPECT_THAT(std::string(error.what()), testing::HasSubstr("the columns of j2 and j3 exchanged"));
  }
}

TEST(ArmLogs, AnArmInOrderIsNotRefused) {
  const Experiment e = make_arm("in_order", [](const Motion& m, const Plant&, const Plant& with_gripper) {
    return Eigen::MatrixXd(calc_friction(m) + calc_all(with_gripper, m));
  });
  EXPECT_NO_THROW(check_for_exchanged_joints(e));
}

}  // namespace
}  // namespace hrp::diagnosis
