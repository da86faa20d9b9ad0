// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "common/base/format.h"
#include "diagnosis/generator/joint_reality.h"
#include "diagnosis/generator/reality.h"

namespace hrp::cases {
namespace {

std::string text(double value) { return format("%.12g", value); }

template <std::size_t N>
std::string text(const std::array<double, N>& values) {
  std::string out;
  for (double value : values) out += (out.empty() ? "" : " ") + text(value);
  return out;
}

// Adds a point mass at `at` (link frame) by the parallel-axis theorem about the new common centre.
void add_point_mass(LinkPlan& link, double mass, const Vec3& at) {
  const double total = link.mass + mass;
  Vec3 d{};
  for (std::size_t i = 0; i < 3; ++i) {
    d[i] = at[i] - link.com[i];
    link.com[i] += mass / total * d[i];
  }
  const double reduced = link.mass * mass / total, dd = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  for (std::size_t i = 0; i < 3; ++i) link.inertia[i] += reduced * (dd - d[i] * d[i]);
  link.inertia[3] -= reduced * d[0] * d[1];
  link.inertia[4] -= reduced * d[0] * d[2];
  link.inertia[5] -= reduced * d[1] * d[2];
  link.mass = total;
}

LinkPlan find_real_link(const RobotPlan& robot, std::size_t index, const std::vector<Hidden>& hidden) {
  LinkPlan link = robot.links[index];
  for (const Hidden& h : hidden) {
    if (h.where_kind != "link" || h.where != link.name) continue;
    if (h.effect == "payload") add_point_mass(link, h.get("mass"), h.get3("com"));
    if (h.effect == "mass_error") {
      link.mass *= h.get("scale");
      for (double& value : link.inertia) value *= h.get("scale");
    }
    if (h.effect == "com_error") {
      for (std::size_t i = 0; i < 3; ++i) link.com[i] += h.get3("offset")[i];
    }
  }
  return link;
}

std::string make_inertial(double mass, const Vec3& com, const std::array<double, 6>& inertia) {
  return "<inertial pos=\"" + text(com) + "\" mass=\"" + text(mass) + "\" fullinertia=\"" + text(inertia) + "\"/>";
}

std::string make_sole_geom(const FootPlan& foot, const Vec3& at) {
  const Vec3 half{foot.size[0] / 2, foot.size[1] / 2, foot.size[2] / 2};
  return "<geom name=\"" + foot.wrench + "_sole\" type=\"box\" size=\"" + text(half) + "\" pos=\"" + text(at) + "\"/>";
}

// A bush: the sole is a body of its own below the sensor, on a slide and two hinges at the bush's centre. A sixth of
// the foot's mass goes with it; a small armature keeps the integration calm while an edge is in the air.
std::string make_soft_sole(const FootPlan& foot, const Hidden& bush, double mass) {
  const Vec3 center = bush.get3("center"), s = foot.size;
  const Vec3 box{foot.center[0] - center[0], foot.center[1] - center[1], foot.center[2] - center[2]};
  const std::array<double, 6> inertia{mass * (s[1] * s[1] + s[2] * s[2]) / 12,
                                      mass * (s[0] * s[0] + s[2] * s[2]) / 12,
                                      mass * (s[0] * s[0] + s[1] * s[1]) / 12,
                                      0,
                                      0,
                                      0};
  const std::string n = foot.wrench;
  return "<body name=\"" + n + "_sole_body\" pos=\"" + text(center) + "\">" + make_inertial(mass, box, inertia) +
         "<joint name=\"" + n + "_z\" type=\"slide\" axis=\"0 0 1\"/>" + "<joint name=\"" + n +
         "_roll\" type=\"hinge\" axis=\"1 0 0\" armature=\"0.0005\"/>" + "<joint name=\"" + n +
         "_pitch\" type=\"hinge\" axis=\"0 1 0\" armature=\"0.0005\"/>" + make_sole_geom(foot, box) + "</body>";
}

const Hidden* find_bush(const std::vector<Hidden>& hidden, const std::string& link) {
  for (const Hidden& h : hidden) {
    if (h.where_kind == "foot" && h.where == link && h.effect != "sticky_sole") return &h;
  }
  return nullptr;
}

std::string make_foot(const RobotPlan& robot, std::size_t index, const std::vector<Hidden>& hidden, LinkPlan& link) {
  std::string out;
  for (const FootPlan& foot : robot.feet) {
    if (foot.link != static_cast<int>(index)) continue;
    out += "<site name=\"" + foot.wrench + "\"/>";
    if (const Hidden* bush = find_bush(hidden, link.name)) {
      const double mass = link.mass / 6;
      link.mass -= mass;
      out += make_soft_sole(foot, *bush, mass);
    } else {
      out += make_sole_geom(foot, foot.center);
    }
  }
  return out;
}

// Part of the link's mass hangs on a spring at the link's centre of mass: it swings, and sags a little.
std::string make_sprung_mass(const std::vector<Hidden>& hidden, LinkPlan& link) {
  for (const Hidden& h : hidden) {
    if (h.effect != "sprung_mass" || h.where != link.name) continue;
    const double mass = h.get("mass"), w = 6.28318530717958647692 * h.get("frequency");
    link.mass -= mass;
    return "<body name=\"sprung\" pos=\"" + text(link.com) + "\">" +
           make_inertial(mass, {0, 0, 0}, {1e-7, 1e-7, 1e-7, 0, 0, 0}) +
           "<joint name=\"sprung\" type=\"slide\" axis=\"" + text(h.get3("axis")) + "\" stiffness=\"" +
           text(mass * w * w) + "\" damping=\"" + text(2 * h.get("damping_ratio") * mass * w) + "\"/></body>";
  }
  return "";
}

// The structure that carries a joint bends sideways: a hinge before it that no encoder sees.
std::string make_bend(const std::vector<Hidden>& hidden, const std::string& joint) {
  for (const Hidden& h : hidden) {
    if (h.effect != "hip_bend" || h.where != joint) continue;
    return "<joint name=\"bend\" type=\"hinge\" axis=\"1 0 0\" stiffness=\"" + text(h.get("stiffness")) +
           "\" damping=\"" + text(h.get("damping")) + "\"/>";
  }
  return "";
}

std::string make_body(const RobotPlan& robot, std::size_t index, const std::vector<Hidden>& hidden,
                      const std::vector<JointReality>& joints) {
  LinkPlan link = find_real_link(robot, index, hidden);
  std::string out = "<body name=\"" + link.name + "\"", rotor;
  if (index == 0) {
    out += " pos=\"" + text(robot.base_position) + "\">" + (robot.floating ? "<freejoint name=\"floating\"/>" : "");
  } else {
    const JointReality& real = joints[index - 1];
    const std::string place = " pos=\"" + text(link.joint.xyz) + "\" euler=\"" + text(link.joint.rpy) + "\"";
    const std::string axis = " type=\"hinge\" axis=\"" + text(link.joint.axis) + "\"";
    out += place + ">" + make_bend(hidden, link.joint.name) + "<joint name=\"" + link.joint.name + "\"" + axis +
           " armature=\"" + text(real.elastic ? 0 : real.rotor) + "\"/>";
    if (real.elastic) {
      // The rotor turns beside the link about the same axis; its own mass is nil, its reflected inertia is armature.
      rotor = "<body name=\"" + link.joint.name + "_rotor\"" + place + ">" +
              make_inertial(1e-7, {0, 0, 0}, {1e-9, 1e-9, 1e-9, 0, 0, 0}) + "<joint name=\"" + link.joint.name +
              "_motor\"" + axis + " armature=\"" + text(real.rotor) + "\"/></body>";
    }
  }
  const std::string foot = make_foot(robot, index, hidden, link) + make_sprung_mass(hidden, link);
  if (link.mass > 0) out += make_inertial(link.mass, link.com, link.inertia);
  if (!robot.imu.empty() && robot.imu_link == static_cast<int>(index))
    out += "<site name=\"imu\" pos=\"" + text(robot.imu_xyz) + "\"/>";
  if (index > 0 && robot.joint_torques) out += "<site name=\"" + link.joint.name + "_torque\"/>";
  if (!robot.wrist.empty() && robot.wrist_link == static_cast<int>(index))
    out += "<site name=\"" + robot.wrist + "\"/>";
  out += foot;
  for (std::size_t i = 1; i < robot.links.size(); ++i) {
    if (robot.links[i].parent == static_cast<int>(index)) out += make_body(robot, i, hidden, joints);
  }
  return out + "</body>" + rotor;
}

std::string make_ground(const RobotPlan& robot, const std::vector<Hidden>& hidden) {
  double roll = 0, pitch = 0, friction = robot.ground_friction;
  for (const Hidden& h : hidden) {
    if (h.effect == "ground_slope") {
      roll = h.get("roll");
      pitch = h.get("pitch");
    }
    if (h.effect == "ground_friction") friction = h.get("coefficient");
  }
  // eulerseq XYZ in capitals: about fixed axes, roll first.
  return "<geom name=\"ground\" type=\"plane\" size=\"5 5 0.1\" euler=\"" + text(Vec3{roll, pitch, 0}) +
         "\" friction=\"" + text(friction) + "\" priority=\"1\"/>";
}

}  // namespace

std::string make_mjcf(const RobotPlan& robot, const std::vector<Hidden>& hidden) {
  const std::vector<JointReality> joints = make_joint_realities(robot, hidden);
  std::string out = "<mujoco><compiler angle=\"radian\" eulerseq=\"XYZ\" boundmass=\"0\"/>";
  out +=
      "<option gravity=\"0 0 -9.81\" timestep=\"0.0002\" cone=\"elliptic\" impratio=\"50\" solver=\"Newton\" "
      "iterations=\"50\" tolerance=\"1e-12\"/>";
  // Contact as stiff as the step allows (tilt stiffness of a sole far above 5e4 N m/rad); dry friction that sticks:
  // creep below 1e-7 rad/s per N m.
  out +=
      "<default><geom condim=\"3\" solref=\"0.001 1\" solimp=\"0.99 0.99 0.001\" contype=\"0\" conaffinity=\"1\"/>"
      "<joint limited=\"false\" solreffriction=\"0.0006 1\" solimpfriction=\"0.9999 0.9999 0.001\" frictionloss=\"0\"/>"
      "</default><worldbody>";
  if (!robot.feet.empty()) {
    std::string ground = make_ground(robot, hidden);
    ground.insert(ground.size() - 2, " contype=\"1\" conaffinity=\"0\"");
    out += ground;
  }
  out += make_body(robot, 0, hidden, joints) + "</worldbody>";
  out += "<sensor>";
  if (!robot.imu.empty()) {
    out += "<gyro name=\"gyro\" site=\"imu\"/><accelerometer name=\"acceleration\" site=\"imu\"/>";
    out += "<framequat name=\"orientation\" objtype=\"site\" objname=\"imu\"/>";
  }
  for (int j = 0; robot.joint_torques && j < joint_count(robot); ++j) {
    const std::string& name = joint(robot, j).name;
    out += "<torque name=\"" + name + "_torque\" site=\"" + name + "_torque\"/>";
  }
  if (!robot.wrist.empty())
    out += "<force name=\"" + robot.wrist + "_force\" site=\"" + robot.wrist + "\"/><torque name=\"" + robot.wrist +
           "_torque\" site=\"" + robot.wrist + "\"/>";
  for (const FootPlan& foot : robot.feet) {
    out += "<force name=\"" + foot.wrench + "_force\" site=\"" + foot.wrench + "\"/><torque name=\"" + foot.wrench +
           "_torque\" site=\"" + foot.wrench + "\"/>";
  }
  return out + "</sensor></mujoco>";
}

}  // namespace hrp::cases
