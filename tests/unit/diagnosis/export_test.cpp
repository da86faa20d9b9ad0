// SPDX-License-Identifier: BSD-3-Clause
#include <mujoco/mujoco.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnosis/export/take_home.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kServo = "base: fixed\nservo: {default: {kp: 200, kd: 10, effort_limit: 50}}\n";
constexpr const char* kFound =
    "effects:\n"
    "  - {effect: viscous_friction, where: {joint: elbow}, parameters: {coefficient: 0.7}}\n"
    "  - {effect: coulomb_friction, where: {joint: elbow}, parameters: {level: 1.3}}\n"
    "  - {effect: rotor_inertia, where: {joint: shoulder}, parameters: {inertia: 0.21}}\n"
    "  - {effect: command_delay, where: {joint: shoulder}, parameters: {delay: 0.012}}\n"
    "  - {effect: torque_constant_error, where: {joint: elbow}, parameters: {scale: 0.9}}\n"
    "  - {effect: payload, where: {link: fore}, parameters: {mass: 0.5, com: [0.3, 0, 0]}}\n";

fs::path make_updated(const std::string& name, const std::string& effects) {
  fs::path folder = fs::temp_directory_path() / ("hrp_export_" + name);
  fs::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << kArm;
  std::ofstream(folder / "scenario.yaml") << "robot: robot.urdf\n" << kServo << effects;
  std::ofstream(folder / "nominal.yaml") << "robot: robot.urdf\n" << kServo;
  return folder;
}

std::string read(const fs::path& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

// A model of MuJoCo and its state.
class Loaded {
 public:
  explicit Loaded(const fs::path& path) {
    char error[500] = "";
    model = mj_loadXML(path.c_str(), nullptr, error, sizeof error);
    EXPECT_NE(model, nullptr) << error;
    if (model) data = mj_makeData(model);
  }
  ~Loaded() {
    mj_deleteData(data);
    mj_deleteModel(model);
  }
  int dof(const char* joint) const { return model->jnt_dofadr[mj_name2id(model, mjOBJ_JOINT, joint)]; }
  mjModel* model = nullptr;
  mjData* data = nullptr;
};

TEST(TakeHome, MujocoLoadsTheModelWithTheRotorsAndFrictionsThatWereFound) {
  const fs::path folder = make_updated("mjcf", kFound);
  write_take_home(folder.string());
  const Loaded mj(folder / "export/robot.xml");
  ASSERT_NE(mj.model, nullptr);
  const int elbow = mj.dof("elbow"), shoulder = mj.dof("shoulder");
  EXPECT_DOUBLE_EQ(mj.model->dof_damping[elbow], 0.7);
  EXPECT_DOUBLE_EQ(mj.model->dof_frictionloss[elbow], 1.3);
  EXPECT_DOUBLE_EQ(mj.model->dof_armature[shoulder], 0.21);
  EXPECT_DOUBLE_EQ(mj.model->dof_armature[elbow], 0.0);
  // The forearm's kilogram and the load's half.
  EXPECT_NEAR(mj.model->body_mass[mj_name2id(mj.model, mjOBJ_BODY, "fore")], 1.5, 1e-9);
  // Gains of the servo times the true gain of the drive.
  EXPECT_NEAR(mj.model->actuator_biasprm[mjNBIAS * mj_name2id(mj.model, mjOBJ_ACTUATOR, "elbow") + 1], -180.0, 1e-9);
  EXPECT_THAT(read(folder / "export/robot.xml"), HasSubstr("shoulder, not held: commands arrive 0.012 s late"));
}

// Arms are often bolted to a link of this name, which both formats keep for themselves.
TEST(TakeHome, ALinkThatIsCalledWorldGetsAnotherName) {
  const fs::path folder = make_updated("world", kFound);
  std::string urdf = kArm;
  for (size_t at = urdf.find("\"base\""); at != std::string::npos; at = urdf.find("\"base\"", at))
    urdf.replace(at, 6, "\"world\"");
  std::ofstream(folder / "robot.urdf") << urdf;
  write_take_home(folder.string());
  const Loaded mj(folder / "export/robot.xml");
  ASSERT_NE(mj.model, nullptr);
  EXPECT_THAT(read(folder / "export/robot.sdf"), testing::Not(HasSubstr("<link name=\"world\">")));
}

TEST(TakeHome, UrdfAndSdfHoldFrictionAndSayWhatTheyCannot) {
  const fs::path folder = make_updated("urdf", kFound);
  write_take_home(folder.string());
  const std::string urdf = read(folder / "export/robot.urdf"), sdf = read(folder / "export/robot.sdf");
  EXPECT_THAT(urdf, HasSubstr("<dynamics damping=\"0.7\" friction=\"1.3\"/>"));
  EXPECT_THAT(urdf, HasSubstr("not held: reflected inertia of the rotor, 0.21 kg m^2"));
  EXPECT_THAT(urdf, HasSubstr("payload"));
  EXPECT_THAT(sdf, HasSubstr("<damping>0.7</damping><friction>1.3</friction>"));
  // The same robot for every tool that reads URDF.
  Scenario scenario = load_scenario((folder / "scenario.yaml").string());
  scenario.robot = (folder / "export/robot.urdf").string();
  const RobotDescription robot = load_robot(scenario);
  EXPECT_DOUBLE_EQ(robot.tree.joint(kElbow).viscous_friction, 0.7);
  EXPECT_DOUBLE_EQ(robot.tree.joint(kElbow).coulomb_friction, 1.3);
}

TEST(TakeHome, IsaacLabsTableHasRotorFrictionAndDelay) {
  const fs::path folder = make_updated("isaac", kFound);
  write_take_home(folder.string());
  const std::string table = read(folder / "export/isaac_lab.yaml");
  EXPECT_THAT(table, HasSubstr("class: DelayedPDActuatorCfg"));
  EXPECT_THAT(table, HasSubstr("armature: 0.21"));
  EXPECT_THAT(table, HasSubstr("dynamic_friction: 1.3"));
  EXPECT_THAT(table, HasSubstr("viscous_friction: 0.7"));
}

TEST(TakeHome, MujocosServerGetsAScenarioWithWhatBothHold) {
  const fs::path folder = make_updated("server", kFound);
  write_take_home(folder.string());
  const Scenario scenario = load_scenario((folder / "export/mujoco.yaml").string());
  EXPECT_DOUBLE_EQ(scenario.rotor_inertia.at("shoulder"), 0.21);
  EXPECT_DOUBLE_EQ(scenario.servo_joints.at("elbow").kp, 180.0);
  EXPECT_TRUE(scenario.joint_laws.empty());
}

TEST(TakeHome, MujocosServerGetsNoEffectsThatTheExperimentStates) {
  const fs::path folder = make_updated("stated", kFound);
  std::ofstream(folder / "nominal.yaml") << "robot: robot.urdf\n" << kServo << kFound;
  write_take_home(folder.string());
  EXPECT_TRUE(load_scenario((folder / "export/mujoco.yaml").string()).joint_laws.empty());
}

// Root mean square of recorded less simulated positions [rad], the model driven by the recording's commands.
double calc_miss(const fs::path& model, const Recording& r) {
  const Loaded mj(model);
  const double kp = 200.0, kd = 10.0;
  const int at[] = {mj.dof("shoulder"), mj.dof("elbow")};
  double sum = 0.0;
  for (int j = 0; j < 2; ++j) {
    mj.data->qpos[at[j]] = r.joints[static_cast<size_t>(j)].signal[0][0];
    mj.data->qvel[at[j]] = r.joints[static_cast<size_t>(j)].signal[1][0];
  }
  for (size_t k = 0; k < r.size(); ++k) {
    for (size_t j = 0; j < 2; ++j) {
      const double e = r.joints[j].signal[0][k] - mj.data->qpos[at[j]];
      sum += e * e;
      mj.data->ctrl[j] = kp * r.joints[j].command[k] + kd * r.joints[j].command_rate[k];
    }
    while (mj.data->time < 0.005 * static_cast<double>(k + 1) - 1e-9) mj_step(mj.model, mj.data);
  }
  return std::sqrt(sum / static_cast<double>(2 * r.size()));
}

TEST(TakeHome, TheExportedModelFollowsInMujocoWhatTheNominalOneDoesNot) {
  const std::string effects =
      "effects:\n"
      "  - {effect: viscous_friction, where: {joint: elbow}, parameters: {coefficient: 3.0}}\n"
      "  - {effect: rotor_inertia, where: {joint: shoulder}, parameters: {inertia: 0.5}}\n";
  const Experiment e =
      simulate_arm("export_fit", {{EffectId::kViscous, kElbow, {3.0}}, {EffectId::kRotorInertia, kShoulder, {0.5}}});
  const fs::path nominal = make_updated("fit_before", ""), found = make_updated("fit_after", effects);
  write_take_home(nominal.string());
  write_take_home(found.string());
  const double before = calc_miss(nominal / "export/robot.xml", e.recordings[2]);
  const double after = calc_miss(found / "export/robot.xml", e.recordings[2]);
  // Commands are held for 5 ms here and interpolated there: some mrad remain whatever the model.
  EXPECT_LT(after, 0.3 * before);
}

}  // namespace
}  // namespace hrp::diagnosis
