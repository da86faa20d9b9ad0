// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/upright_data.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/smooth.h"
#include "diagnosis/upright_attitude.h"

namespace hrp::diagnosis::upright {
namespace {

constexpr double kWindow = 0.03;  // [s] half of it: a standing robot moves below 3 Hz, a local cubic keeps that

// Columns base/x, base/y, ... smoothed; false when the recording lacks one.
bool read_vector(const Recording& recording, const Smoother& smoother, const std::string& base, const char* parts,
                 Series* out) {
  for (int i = 0; parts[i]; ++i) {
    const auto at = recording.other.find(base + "/" + parts[i]);
    if (at == recording.other.end()) return false;
    out[i] = smoother.run(fill_gaps(at->second));
  }
  return true;
}

bool read_quaternion(const Recording& recording, const Smoother& smoother, const std::string& base, Series* wxyz) {
  Series xyzw[4];
  if (!read_vector(recording, smoother, base, "xyzw", xyzw)) return false;
  for (int i = 0; i < 4; ++i) wxyz[(i + 1) % 4] = std::move(xyzw[i]);
  return true;
}

void read_joints(const Experiment& e, const Recording& recording, const Smoother& smoother, StandRecording* out) {
  for (int j = 0; j < e.num_joints(); ++j) {
    const JointColumns& columns = recording.joints[static_cast<size_t>(j)];
    const auto read = [&](Quantity q) {
      return columns.has(q) ? smoother.run(fill_gaps(columns.signal[static_cast<int>(q)])) : Series{};
    };
    out->position.push_back(read(Quantity::kPosition));
    out->velocity.push_back(read(Quantity::kVelocity));
    out->effort.push_back(read(Quantity::kEffort));
    out->command.push_back(columns.command.empty() ? Series{} : smoother.run(columns.command));
  }
}

bool read_feet(const Recording& recording, const Smoother& smoother, const StandProblem& problem, StandRecording* out,
               std::string* why) {
  for (const StandFoot& foot : problem.feet) {
    Series axes[6];
    if (!read_vector(recording, smoother, "/wrench/" + foot.sensor + "/force", "xyz", axes) ||
        !read_vector(recording, smoother, "/wrench/" + foot.sensor + "/torque", "xyz", axes + 3)) {
      return *why = out->file + ": /wrench/" + foot.sensor + " lacks columns", false;
    }
    for (Series& s : axes) out->wrench.push_back(std::move(s));
  }
  return true;
}

bool read_recording(const Experiment& e, const Recording& recording, Parity parity, const StandProblem& problem,
                    StandRecording* out, std::string* why) {
  out->file = recording.spec.name;
  out->train = recording.spec.train;
  out->time = recording.time;
  if (recording.size() < 40) return *why = out->file + " is too short", false;
  const double step = recording.duration() / static_cast<double>(recording.size() - 1);
  const Smoother smoother(recording.time, std::max(3, static_cast<int>(std::lround(kWindow / step))), parity);
  read_joints(e, recording, smoother, out);
  const std::string imu = "/imu/" + problem.imu;
  if (!read_vector(recording, smoother, imu + "/angular_velocity", "xyz", out->gyro) ||
      !read_vector(recording, smoother, imu + "/linear_acceleration", "xyz", out->accelerometer)) {
    return *why = out->file + ": " + imu + " lacks columns", false;
  }
  if (!read_quaternion(recording, smoother, imu + "/orientation", out->attitude)) out->attitude[0] = {};
  if (!read_vector(recording, smoother, "/base/pose/position", "xyz", out->base_position) ||
      !read_quaternion(recording, smoother, "/base/pose/orientation", out->base_attitude)) {
    out->base_attitude[0] = {};
  }
  if (!read_feet(recording, smoother, problem, out, why)) return false;
  // The ends of a recording are left out: there the local cubics stand on one side only.
  const int half = out->window = smoother.half();
  for (int k = 2 * half; k + 2 * half < static_cast<int>(recording.size()); k += half) out->samples.push_back(k);
  if (out->samples.size() <= 20) return *why = out->file + " is too short", false;
  return true;
}

void read_sole(const RobotDescription& robot, StandFoot* foot) {
  for (const CollisionShape& shape : robot.shapes) {
    if (shape.link != foot->link) continue;
    if (shape.kind == ShapeKind::kSphere) {
      foot->kind = SoleKind::kBall, foot->radius = shape.size.x(), foot->bush = shape.X_LG.p;
      continue;
    }
    foot->bush.z() = shape.X_LG.p.z();
    if (shape.kind == ShapeKind::kBox) {
      foot->sole = shape.X_LG.p - Vector3d(0, 0, shape.size.z() / 2), foot->size = shape.size;
    }
  }
}

// Feet must be links of their own with a force sensor; their mass hangs below it.
bool find_feet(const Experiment& e, StandProblem* problem) {
  for (const std::string& name : e.scenario.feet) {
    StandFoot foot;
    foot.name = name;
    foot.link = e.robot.tree.find_link(name);
    for (const WrenchSpec& sensor : e.scenario.sensors.wrenches) {
      if (sensor.link == name) foot.sensor = sensor.name;
    }
    if (foot.link < 0 || foot.sensor.empty()) return false;
    read_sole(e.robot, &foot);
    LinkInertia& inertia = problem->tree.links[static_cast<size_t>(foot.link)].inertia;
    foot.mass = inertia.mass, foot.com = inertia.p_LLcm_L;
    problem->feet.push_back(foot);
    inertia = LinkInertia{};
    inertia.mass = 1e-9, inertia.I_LLcm_L = 1e-12 * Matrix3d::Identity();
  }
  return !problem->feet.empty();
}

// Which columns every recording has; false when a joint has no position.
bool find_columns(const Experiment& e, StandProblem* problem, std::string* why) {
  for (int j = 0; j < e.num_joints(); ++j) {
    const auto i = static_cast<size_t>(j);
    bool effort = true, command = true, velocity = true;
    for (const StandRecording& r : problem->recordings) {
      if (r.position[i].value.empty()) {
        return *why = "joint " + e.robot.tree.joint(j).name + " has no position", false;
      }
      effort = effort && !r.effort[i].value.empty(), command = command && !r.command[i].value.empty();
      velocity = velocity && !r.velocity[i].value.empty();
    }
    problem->effort.push_back(effort), problem->command.push_back(command), problem->velocity.push_back(velocity);
  }
  problem->base_pose = true;
  for (const StandRecording& r : problem->recordings) {
    problem->base_pose = problem->base_pose && !r.base_attitude[0].value.empty();
    problem->attitude = problem->attitude && !r.attitude[0].value.empty();
  }
  return true;
}

}  // namespace

bool make_stand_problem(const Experiment& e, Parity parity, StandProblem* problem, std::string* why) {
  problem->experiment = &e;
  problem->tree = e.robot.tree;
  if (!e.scenario.floating_base) return *why = "the base is fixed", false;
  if (e.scenario.sensors.imus.empty()) return *why = "no IMU", false;
  const ImuSpec& imu = e.scenario.sensors.imus[0];
  problem->imu = imu.name;
  const int frame = e.robot.tree.find_frame(imu.link);
  if (frame < 0) return *why = "the IMU's link is not of the robot", false;
  const FrameSpec& f = e.robot.tree.frames[static_cast<size_t>(frame)];
  problem->imu_link = f.link, problem->R_LI = f.X_LF.R, problem->p_LI = f.X_LF * imu.p_LS;
  if (!find_feet(e, problem)) return *why = "not every foot has a force sensor at its own link", false;
  for (const Recording& recording : e.recordings) {
    StandRecording out;
    if (!read_recording(e, recording, parity, *problem, &out, why)) return false;
    problem->recordings.push_back(std::move(out));
  }
  if (!find_columns(e, problem, why)) return false;
  if (!problem->attitude) {
    for (StandRecording& r : problem->recordings) {
      problem->attitude_error = std::max(problem->attitude_error, find_attitude(*problem, &r));
    }
  }
  return true;
}

}  // namespace hrp::diagnosis::upright
