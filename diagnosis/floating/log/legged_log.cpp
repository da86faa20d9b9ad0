// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/log/legged_log.h"

#include <algorithm>

#include "common/base/join_words.h"
#include "common/multibody/tree_mass.h"
#include "diagnosis/data/servo_gains.h"
#include "diagnosis/floating/log/clip_maker.h"
#include "diagnosis/model/tree.h"
#include "diagnosis/standing/sole.h"

namespace hrp::diagnosis::floating {
namespace {

bool has_in_all(const Experiment& e, const std::string& column) {
  return std::all_of(e.recordings.begin(), e.recordings.end(), [&](const Recording& r) { return r.has(column); });
}

bool has_vector(const Experiment& e, const std::string& base, const char* parts) {
  for (; *parts; ++parts) {
    if (!has_in_all(e, base + "/" + *parts)) return false;
  }
  return true;
}

// Takes the inertia `part` (frame F of the link) out of a link; what is left has at least a speck of mass.
void take_out(const LinkInertia& part, const Transform& X_LF, LinkInertia* total) {
  const double mass = total->mass - part.mass;
  if (mass < 1e-6 * std::max(1e-3, total->mass)) {
    *total = LinkInertia{1e-9, Vector3d::Zero(), 1e-12 * Matrix3d::Identity()};
    return;
  }
  const Vector3d c_part = X_LF * part.p_LLcm_L;
  const Vector3d c = (total->mass * total->p_LLcm_L - part.mass * c_part) / mass;
  const auto about = [](double m, const Vector3d& d) {
    return Matrix3d(m * (d.squaredNorm() * Matrix3d::Identity() - d * d.transpose()));
  };
  total->I_LLcm_L += about(total->mass, total->p_LLcm_L) - X_LF.R * part.I_LLcm_L * X_LF.R.transpose() -
                     about(part.mass, c_part) - about(mass, c);
  total->mass = mass;
  total->p_LLcm_L = c;
}

// True if the limb goes on beyond the sensor, and ends in a foot with a sensor of its own, or in no foot: what the
// sensor passes on is counted at the foot, or is no force of the surroundings.
bool is_within_limb(const Experiment& e, const WrenchSpec& spec, int link) {
  const TreeSpec& tree = e.robot.tree;
  const auto find_link = [&](const std::string& name) {
    const int frame = tree.find_frame(name);
    return frame < 0 ? -1 : tree.frames[static_cast<size_t>(frame)].link;
  };
  if (e.scenario.feet.empty() || is_last(tree, link)) return false;
  bool any = false;
  for (const std::string& name : e.scenario.feet) {
    const int foot = find_link(name);
    if (foot == link) return false;
    if (foot < 0 || !is_above(tree, link, foot)) continue;
    any = true;
    for (const WrenchSpec& other : e.scenario.sensors.wrenches) {
      if (other.name != spec.name && find_link(other.link) == foot && has_in_all(e, get_force_column(other.name, 2)))
        return true;
    }
  }
  return !any;
}

void find_sensors(const Experiment& e, LeggedLog* log) {
  for (const WrenchSpec& spec : e.scenario.sensors.wrenches) {
    const int frame = e.robot.tree.find_frame(spec.link);
    if (frame < 0) continue;
    const FrameSpec& f = e.robot.tree.frames[static_cast<size_t>(frame)];
    if (is_within_limb(e, spec, f.link)) {
      log->missing.push_back("use of the force sensor " + spec.name + ": joints beyond it move what it carries");
      continue;
    }
    ForceSensor s;
    s.name = spec.name;
    s.link = f.link;
    s.X_LS = f.X_LF;
    const auto world = e.keys.wrench_frame.find(spec.name);
    s.world = world != e.keys.wrench_frame.end() && world->second == "world";
    std::vector<std::string> lacking;
    for (int i = 0; i < 6; ++i) {
      const std::string column = get_force_column(s.name, i);
      s.axis[i] = has_in_all(e, column);
      if (!s.axis[i])
        lacking.push_back(lacking.empty() ? column : column.substr(std::string("/wrench/" + s.name + "/").size()));
    }
    if (!lacking.empty()) log->missing.push_back("no column " + join_words(lacking));
    if (lacking.size() == 6) continue;
    if (!s.world && f.below.mass > 0) s.below = f.below;
    log->sensors.push_back(s);
  }
}

// What is below a sensor that tells the whole wrench is no part of the mechanism above it. Without the wrench it is: a
// foot in the air is moved by its leg.
void cut_below_sensors(LeggedLog* log) {
  for (ForceSensor& s : log->sensors) {
    if (s.below.mass <= 0) continue;
    log->mass_below += s.below.mass;
    const bool ball = s.foot >= 0 && !log->feet[static_cast<size_t>(s.foot)].flat;
    if (s.has_wrench() || (s.has_force() && ball)) {
      take_out(s.below, s.X_LS, &log->tree.links[static_cast<size_t>(s.link)].inertia);
      s.hangs = s.below.mass;
      s.below.mass = 0;
    }
    s.below.p_LLcm_L = s.X_LS * s.below.p_LLcm_L;
  }
}

// Links at which a robot may touch the ground if nobody says which ones do.
std::vector<std::string> list_limb_ends(const TreeSpec& tree) {
  std::vector<std::string> names;
  for (size_t l = 1; l < tree.links.size(); ++l) {
    if (is_last(tree, static_cast<int>(l))) names.push_back(tree.links[l].name);
  }
  return names;
}

void find_feet(const Experiment& e, LeggedLog* log) {
  const bool told = !e.scenario.feet.empty() || !e.scenario.floating_base;
  const std::vector<std::string> names = told ? e.scenario.feet : list_limb_ends(e.robot.tree);
  if (!told && !names.empty())
    log->missing.push_back(
        "the key 'feet': any limb may stand on the ground, and its joints' torques then contain the ground's force");
  for (const std::string& name : names) {
    const int frame = e.robot.tree.find_frame(name);
    if (frame < 0) continue;
    const FrameSpec& f = e.robot.tree.frames[static_cast<size_t>(frame)];
    standing::StandFoot sole;
    sole.link = f.link;
    sole.size.setZero();
    standing::read_sole(e.robot, &sole);
    Foot foot;
    foot.name = name;
    foot.link = f.link;
    foot.flat = sole.kind == standing::SoleKind::kFlat && sole.size.x() > 0;
    const bool known = foot.flat || sole.kind == standing::SoleKind::kBall;
    foot.p_LC = foot.flat ? sole.sole : known ? sole.bush : f.X_LF.p;
    foot.radius = foot.flat ? 0 : sole.radius;
    foot.size = foot.flat ? sole.size : Vector3d::Zero();
    for (size_t s = 0; s < log->sensors.size(); ++s) {
      if (log->sensors[s].link != f.link) continue;
      foot.sensor = static_cast<int>(s);
      log->sensors[s].foot = static_cast<int>(log->feet.size());
    }
    if (foot.sensor < 0) log->missing.push_back("no force sensor at foot " + name);
    log->feet.push_back(foot);
  }
}

void find_imus(const Experiment& e, LeggedLog* log) {
  for (const ImuSpec& spec : e.scenario.sensors.imus) {
    const int frame = e.robot.tree.find_frame(spec.link);
    if (frame < 0) continue;
    const FrameSpec& f = e.robot.tree.frames[static_cast<size_t>(frame)];
    ImuSensor imu;
    const std::string base = "/imu/" + spec.name;
    imu.name = spec.name;
    imu.link = f.link;
    imu.R_LI = f.X_LF.R;
    imu.p_LI = f.X_LF * spec.p_LS;
    imu.attitude = has_vector(e, base + "/orientation", "xyzw");
    imu.gyro = has_vector(e, base + "/angular_velocity", "xyz");
    imu.accelerometer = has_vector(e, base + "/linear_acceleration", "xyz");
    if (!imu.attitude) log->missing.push_back("no column " + base + "/orientation/x");
    if (!imu.gyro) log->missing.push_back("no column " + base + "/angular_velocity/x");
    if (!imu.accelerometer) log->missing.push_back("no column " + base + "/linear_acceleration/x");
    if (imu.attitude || imu.gyro || imu.accelerometer) log->imus.push_back(imu);
  }
}

void find_joints(const Experiment& e, LeggedLog* log) {
  bool any = false;
  for (size_t j = 0; j < static_cast<size_t>(e.num_joints()); ++j) {
    bool position = true, effort = true, command = e.scenario.drive == "servo";
    for (const Recording& r : e.recordings) {
      position = position && r.joints[j].has(Quantity::kPosition);
      effort = effort && r.joints[j].has(Quantity::kEffort);
      command = command && !r.joints[j].command.empty();
    }
    const std::string& name = e.robot.tree.joint(static_cast<int>(j)).name;
    log->has_position.push_back(position);
    log->has_effort.push_back(effort);
    log->has_law.push_back(command && position && get_servo_gains(e.scenario, name).kp > 0);
    any = any || effort || log->has_law.back();
    if (!position) log->missing.push_back("no column /joint_states/" + name + "/position: taken as not moving");
  }
  if (!any && e.num_joints() > 0) {
    log->missing.push_back(
        "no effort, and no command with gains: friction, rotors and other effects of drives are not compared");
  }
}

}  // namespace

LeggedLog make_legged_log(const Experiment& e, Half half) {
  LeggedLog log;
  log.experiment = &e;
  log.tree = e.robot.tree;
  log.sample_time = e.sample_time;
  log.mass = calc_mass(log.tree);
  find_sensors(e, &log);
  find_feet(e, &log);
  cut_below_sensors(&log);
  find_imus(e, &log);
  find_joints(e, &log);
  log.base_pose = has_vector(e, "/base/pose/position", "xyz") && has_vector(e, "/base/pose/orientation", "xyzw");
  if (!log.base_pose && e.scenario.floating_base) log.missing.push_back("no column /base/pose/position/x");
  for (size_t r = 0; r < e.recordings.size(); ++r) add_clips(e, r, half, &log);
  scale_roughness(&log);
  return log;
}

}  // namespace hrp::diagnosis::floating
