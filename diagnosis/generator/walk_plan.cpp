// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/walk_plan.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "common/base/format.h"
#include "common/base/read_file.h"
#include "diagnosis/generator/robot_parts.h"

namespace hrp::cases {
namespace {

constexpr double kFastest = 5e3;  // [1/s] of a drive's damping over what it moves: the integration is explicit

std::string text(double value) { return format("%.10g", value); }

// A walk hardly moves arms and head: their drives are locked, so that no case hides something where nothing shows.
std::string lock_upper_body(std::string urdf) {
  for (std::size_t at = 0; (at = urdf.find("<joint name=\"", at)) != std::string::npos; ++at) {
    const std::size_t end = urdf.find('>', at);
    const std::string head = urdf.substr(at, end - at);
    const char* const locked[] = {"SHOULDER", "ELBOW", "WRIST", "HAND", "HEAD", "NECK", "WAIST", "CHEST"};
    const bool is_locked = std::any_of(std::begin(locked), std::end(locked),
                                       [&](const char* word) { return head.find(word) != std::string::npos; });
    const std::size_t type = urdf.find("revolute", at);
    if (is_locked && type < end) urdf.replace(type, 8, "fixed");
  }
  return urdf;
}

RobotPlan make_published(const std::string& models, const std::string& name, Prng& random) {
  const std::string file = models + "/" + name + "/" + name + ".urdf";
  std::ifstream in(file);
  if (!in) throw std::runtime_error("there is no " + file);
  const std::string urdf = read_rest(in, file);
  char folder[] = "/tmp/hrp-walker-XXXXXX";
  if (!mkdtemp(folder)) throw std::runtime_error("no temporary folder");
  const std::string locked = std::string(folder) + "/robot.urdf";
  std::ofstream(locked) << lock_upper_body(urdf);
  RobotPlan robot = make_standing_robot(locked, random);
  std::filesystem::remove_all(folder);
  return robot;
}

// Legs that carry a walk: hips and knees stiffer than those of robots that only stand. Light links are made heavy
// enough for a step of some 0.15 ms, in the model that is handed out, too.
void stiffen(RobotPlan& robot) {
  for (int j = 0; j < joint_count(robot); ++j) {
    JointPlan& p = joint(robot, j);
    const bool stiff = p.role.find("hip") != std::string::npos || p.role.find("knee") != std::string::npos;
    if (stiff) {
      p.kp = round_to(1.6 * p.kp, 3);
      p.kd = round_to(1.3 * p.kd, 3);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double& inertia = robot.links[static_cast<std::size_t>(j) + 1].inertia[axis];
      inertia = std::max(inertia, round_to(p.kd / kFastest, 3));
    }
  }
}

std::string make_sensor_text(const RobotPlan& robot) {
  std::string out = "sensors:\n  imu:\n    " + robot.imu +
                    ": {link: " + robot.links[static_cast<std::size_t>(robot.imu_link)].name + ", xyz: [" +
                    text(robot.imu_xyz[0]) + ", " + text(robot.imu_xyz[1]) + ", " + text(robot.imu_xyz[2]) +
                    "]}\n  wrench:\n";
  for (const FootPlan& foot : robot.feet) {
    out += "    " + foot.wrench + ": {link: " + robot.links[static_cast<std::size_t>(foot.link)].name + "}\n";
  }
  return out;
}

}  // namespace

double calc_mass(const RobotPlan& robot) {
  double mass = 0;
  for (const LinkPlan& link : robot.links) mass += link.mass;
  return mass;
}

RobotPlan make_walker(const std::string& models, Prng& random) {
  const int kind = random.below(5);
  Prng body = random.fork(1);
  RobotPlan robot = kind == 0   ? make_published(models, "hrp1s_like", body)
                    : kind == 1 ? make_published(models, "hrp2p_like", body)
                                : make_biped(body);
  stiffen(robot);
  return robot;
}

WalkPlan draw_walk(const RobotPlan& robot, Prng& r) {
  WalkPlan plan;
  const double leg = robot.leg;
  plan.single_support = round_to(r.uniform(0.6, 0.8) * std::sqrt(leg / 0.65), 2);
  plan.double_support = round_to(r.uniform(0.12, 0.3), 2);
  plan.swing_height = round_to(leg * r.uniform(0.05, 0.09), 2);
  plan.length = round_to(leg * r.uniform(0.1, 0.3), 2);
  const char* const names[] = {"ahead", "back", "aside", "turn", "place"};
  plan.name = names[r.below(5)];
  if (plan.name == "back") plan.length *= -0.6;
  if (plan.name == "aside") {
    plan.side = round_to(leg * r.sign() * r.uniform(0.05, 0.1), 2);
    plan.length *= 0.3;
  }
  if (plan.name == "turn") {
    plan.turn = round_to(r.sign() * r.uniform(0.08, 0.2), 2);
    plan.length *= 0.6;
  }
  if (plan.name == "place") plan.length = 0;
  plan.left_first = r.chance(0.5);
  return plan;
}

std::string make_walk_scenario(const RobotPlan& robot, const WalkPlan& plan) {
  const double leg = robot.leg;
  std::string out = "robot: robot.urdf\nbase: floating\nfeet: [";
  for (std::size_t f = 0; f < 2; ++f) {
    out += (f ? ", " : "") + robot.links[static_cast<std::size_t>(robot.feet[f].link)].name;
  }
  out += "]\nservo: {default: {kp: 1, kd: 1}}\ninitial:\n  joints:\n";
  for (int j = 0; j < joint_count(robot); ++j)
    out += "    " + joint(robot, j).name + ": " + text(joint(robot, j).start) + "\n";
  out += make_sensor_text(robot) +
         "steps: {time_step: 0.001, control_period: 0.005}\ncontroller:\n  type: walk\n  walk:\n";
  const auto key = [&](const std::string& name, const std::string& value) {
    out += "    " + name + ": " + value + "\n";
  };
  key("left_foot", robot.links[static_cast<std::size_t>(robot.feet[0].link)].name);
  key("right_foot", robot.links[static_cast<std::size_t>(robot.feet[1].link)].name);
  key("left_sensor", robot.feet[0].wrench);
  key("right_sensor", robot.feet[1].wrench);
  key("single_support", text(plan.single_support));
  key("double_support", text(plan.double_support));
  key("swing_height", text(plan.swing_height));
  key("zmp_y", text(0.015 * leg));
  key("measured_ground", "true");
  key("limits",
      "{max_length: " + text(0.6 * leg) + ", min_width: " + text(0.12 * leg) + ", max_width: " + text(0.8 * leg) + "}");
  key("plan", "{count: " + std::to_string(plan.count) + ", length: " + text(plan.length) +
                  ", side: " + text(plan.side) + ", turn: " + text(plan.turn) +
                  ", first: " + (plan.left_first ? "left" : "right") + "}");
  if (!plan.stabilized) return out;
  out +=
      "    stabilizer:\n      body_inclination: {gain: 1.0, rate: 0.12}\n      zmp_damping: {gain: 0.08, return: "
      "2.0}\n";
  // Stiff soles close the loop through the servos alone: a tenth to a sixth of an error goes in a period.
  const double ankle = joint(robot, find_role(robot, "left_ankle_pitch")).kp,
               knee = joint(robot, find_role(robot, "left_knee")).kp;
  const double lever = 0.2 * leg;  // [m] of a bent knee
  out += "      foot_adjusting: {damping: " + text(0.06 * ankle) +
         ", return: 0.15, height_damping: " + text(0.03 * knee / lever / lever) +
         ", height_return_double: 0.4, height_return_single: 0.08}\n";
  return out;
}

bool is_missing(const std::vector<std::string>& missing, const std::string& column) {
  return std::any_of(missing.begin(), missing.end(), [&](const std::string& part) {
    // "a*b": begins with a and ends with b.
    const std::size_t star = part.find('*');
    return column.rfind(part.substr(0, star), 0) == 0 &&
           (star == std::string::npos || column.find(part.substr(star + 1)) != std::string::npos);
  });
}

std::vector<std::string> draw_missing(const std::vector<Hidden>& hidden, Prng& r) {
  bool joint = false, law = false, effort = false, wrench = false, tilt = false, imu = false, pose = false, all = false;
  for (const Hidden& h : hidden) {
    const bool of_joint = h.where_kind == "joint", sensor = h.where_kind == "sensor";
    joint = joint || of_joint;
    law = law || h.effect == "command_delay" || h.effect == "backlash";
    effort = effort || h.effect == "actuator_lag" || h.effect == "torque_constant_error";
    wrench =
        wrench || of_joint || sensor || h.effect == "com_error" || h.where_kind == "foot" || h.effect == "hip_bend";
    tilt = tilt || h.where_kind == "foot" || h.effect == "ground_slope" || h.effect == "joint_offset" || sensor;
    imu = imu || of_joint || sensor || h.where_kind == "link";
    pose = pose || h.effect == "ground_friction";
    all = all || h.effect == "ground_friction" || h.effect == "joint_offset";
  }
  std::vector<std::string> out;
  const bool no_effort = !effort && r.chance(0.35), no_commands = !law && !(joint && no_effort) && r.chance(0.25);
  if (no_effort) out.push_back("/joint_states/*/effort");
  if (no_commands) out.push_back("/joint_commands/");
  if (r.chance(0.3)) out.push_back("/joint_states/*/velocity");
  const bool no_attitude = r.chance(0.45), no_pose = !pose && !(tilt && no_attitude) && r.chance(0.5);
  if (no_attitude) out.push_back("/imu/*/orientation");
  if (no_pose) out.push_back("/base/");
  const double feet = r.uniform(0, 1);
  if (!wrench && feet < 0.3) out.push_back("/wrench/*/torque");
  if (!wrench && !all && feet < 0.2) {
    out.push_back("/wrench/*/force/x");
    out.push_back("/wrench/*/force/y");
  }
  if (!imu && no_pose == false && r.chance(0.2)) out.push_back("/imu/*/linear_acceleration");
  return out;
}

}  // namespace hrp::cases
