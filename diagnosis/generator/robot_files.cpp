// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/format.h"
#include "diagnosis/generator/recorder.h"

namespace hrp::cases {
namespace {

std::string text(double value) { return format("%.10g", value); }

std::string text(const Vec3& v) { return text(v[0]) + " " + text(v[1]) + " " + text(v[2]); }
std::string yaml(const Vec3& v) { return "[" + text(v[0]) + ", " + text(v[1]) + ", " + text(v[2]) + "]"; }

std::string make_urdf_link(const RobotPlan& robot, std::size_t index) {
  const LinkPlan& link = robot.links[index];
  std::string out = "  <link name=\"" + link.name + "\"";
  if (link.mass == 0) return out + "/>\n";
  const auto& i = link.inertia;
  out += ">\n    <inertial><origin xyz=\"" + text(link.com) + "\" rpy=\"0 0 0\"/><mass value=\"" + text(link.mass) +
         "\"/><inertia ixx=\"" + text(i[0]) + "\" iyy=\"" + text(i[1]) + "\" izz=\"" + text(i[2]) + "\" ixy=\"" +
         text(i[3]) + "\" ixz=\"" + text(i[4]) + "\" iyz=\"" + text(i[5]) + "\"/></inertial>\n";
  out += "    <visual><origin xyz=\"" + text(link.com) + "\" rpy=\"0 0 0\"/><geometry><box size=\"" + text(link.box) +
         "\"/></geometry></visual>\n";
  for (const FootPlan& foot : robot.feet) {
    if (foot.link != static_cast<int>(index)) continue;
    out += "    <collision><origin xyz=\"" + text(foot.center) + "\" rpy=\"0 0 0\"/><geometry><box size=\"" +
           text(foot.size) + "\"/></geometry></collision>\n";
  }
  return out + "  </link>\n";
}

// Behind the gears of a robot on a fixed base.
std::string make_link_sensors(const RobotPlan& robot) {
  std::string out, joints;
  for (int j = 0; j < joint_count(robot); ++j) joints += (j > 0 ? ", " : "") + joint(robot, j).name;
  const auto name = [&](int link) { return robot.links[static_cast<std::size_t>(link)].name; };
  if (robot.joint_torques) out += "  joint_torque: [" + joints + "]\n";
  if (robot.link_encoders) out += "  link_encoder: [" + joints + "]\n";
  if (!robot.imu.empty())
    out += "  imu:\n    " + robot.imu + ":\n      link: " + name(robot.imu_link) +
           "\n      xyz: " + yaml(robot.imu_xyz) + "\n";
  if (!robot.wrist.empty()) out += "  wrench:\n    " + robot.wrist + ":\n      link: " + name(robot.wrist_link) + "\n";
  return out.empty() ? "" : "sensors:\n" + out;
}

std::string make_sensors(const RobotPlan& robot, const RecorderPlan& plan) {
  if (!robot.floating) return make_link_sensors(robot);
  if (robot.imu.empty()) return "";
  std::string out = "sensors:\n  imu:\n    " + robot.imu +
                    ":\n      link: " + robot.links[static_cast<std::size_t>(robot.imu_link)].name +
                    "\n      xyz: " + yaml(robot.imu_xyz) + "\n  wrench:\n";
  for (const FootPlan& foot : robot.feet) {
    out += "    " + foot.wrench + ":\n      link: " + robot.links[static_cast<std::size_t>(foot.link)].name + "\n";
  }
  return out + "  base_pose: " + (plan.with_base_pose ? "true" : "false") + "\n";
}

std::string make_loads(const RecordingPlan& recording) {
  std::string out;
  for (const Hidden& load : recording.loads)
    out += std::string(out.empty() ? "" : ", ") + "{link: " + load.where + ", mass: " + text(load.get("mass")) +
           ", com: " + yaml(load.get3("com")) + "}";
  return out.empty() ? "" : ", loads: [" + out + "]";
}

}  // namespace

std::string make_urdf(const RobotPlan& robot) {
  std::string out = "<?xml version=\"1.0\"?>\n<robot name=\"" + robot.name + "\">\n";
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    out += make_urdf_link(robot, i);
    if (i == 0) continue;
    const JointPlan& j = robot.links[i].joint;
    out += "  <joint name=\"" + j.name + "\" type=\"revolute\"><parent link=\"" +
           robot.links[static_cast<std::size_t>(robot.links[i].parent)].name + "\"/><child link=\"" +
           robot.links[i].name + "\"/><origin xyz=\"" + text(j.xyz) + "\" rpy=\"" + text(j.rpy) + "\"/><axis xyz=\"" +
           text(j.axis) + "\"/><limit lower=\"-3\" upper=\"3\" effort=\"" + text(j.limit) +
           "\" velocity=\"20\"/></joint>\n";
  }
  return out + "</robot>\n";
}

std::string make_experiment_yaml(const RobotPlan& robot, const RecorderPlan& plan,
                                 const std::vector<RecordingPlan>& recordings) {
  std::string out = "robot: robot.urdf\nbase: ";
  out += robot.floating ? "floating\n" : "fixed\n";
  if (!plan.with_commands) out += plan.effort_driven ? "drive: effort\n" : "drive: motion\n";
  out += "gravity: [0, 0, -9.81]\n";
  if (robot.floating) {
    out += "ground: {type: plane, height: 0, friction: " + text(robot.ground_friction) + "}\nfeet:\n";
    for (const FootPlan& foot : robot.feet)
      out += "  - " + robot.links[static_cast<std::size_t>(foot.link)].name + "\n";
  }
  out += "servo:\n  joints:\n";
  for (int j = 0; j < joint_count(robot); ++j) {
    const JointPlan& p = joint(robot, j);
    out +=
        "    " + p.name + ": {kp: " + text(p.kp) + ", kd: " + text(p.kd) + ", effort_limit: " + text(p.limit) + "}\n";
  }
  out += make_sensors(robot, plan);
  if (plan.noise_stated) {
    out += "noise: {position: " + text(plan.position_noise);
    if (plan.with_velocity) out += ", velocity: " + text(plan.velocity_noise);
    if (plan.with_effort && plan.effort_noises.empty()) out += ", effort: " + text(plan.effort_noise);
    out += "}\n";
  }
  out += "sample_rate: " + text(plan.rate) + "\ninitial:\n";
  if (robot.floating) out += "  position: " + yaml(robot.base_position) + "\n";
  out += "  joints:\n";
  for (int j = 0; j < joint_count(robot); ++j)
    out += "    " + joint(robot, j).name + ": " + text(joint(robot, j).start) + "\n";
  out += "recordings:\n";
  for (const RecordingPlan& r : recordings) out += "  - {file: " + r.file + ", role: " + r.role + make_loads(r) + "}\n";
  return out;
}

}  // namespace hrp::cases
