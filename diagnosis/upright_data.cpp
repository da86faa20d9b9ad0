// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/upright_data.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/smooth.h"

namespace hrp::diagnosis::upright {
namespace {

constexpr double kWindow = 0.03;  // [s] half of it: a standing robot moves below 3 Hz, a local cubic keeps that

struct Smoother {
  const std::vector<double>& time;
  int half;
  Series run(const std::vector<double>& values) const {
    Series out;
    smooth_series(time, values, half, &out.value, &out.rate, &out.second);
    return out;
  }
};

// A column by name, gaps filled with the value before them; empty when the recording lacks it.
std::vector<double> find_column(const Recording& recording, const std::string& name) {
  const auto at = recording.other.find(name);
  if (at == recording.other.end()) return {};
  std::vector<double> values = at->second;
  double last = 0;
  for (double v : values) {
    if (std::isfinite(v)) {
      last = v;
      break;
    }
  }
  for (double& v : values) last = v = std::isfinite(v) ? v : last;
  return values;
}

bool read_vector(const Recording& recording, const Smoother& smoother, const std::string& base, const char* parts, Series* out) {
  for (int i = 0; parts[i]; ++i) {
    const std::vector<double> column = find_column(recording, base + "/" + parts[i]);
    if (column.empty()) return false;
    out[i] = smoother.run(column);
  }
  return true;
}

std::vector<double> fill(const std::vector<double>& values) {
  std::vector<double> out = values;
  double last = 0;
  for (double& v : out) last = v = std::isfinite(v) ? v : last;
  return out;
}

void read_joints(const Experiment& e, const Recording& recording, const Smoother& smoother, StandRecording* out) {
  for (int j = 0; j < e.num_joints(); ++j) {
    const JointColumns& columns = recording.joints[static_cast<size_t>(j)];
    out->position.push_back(columns.has(Quantity::kPosition) ? smoother.run(fill(columns.signal[0])) : Series{});
    out->effort.push_back(columns.has(Quantity::kEffort) ? smoother.run(fill(columns.signal[2])) : Series{});
    out->command.push_back(columns.command.empty() ? Series{} : smoother.run(columns.command));
  }
}

bool read_recording(const Experiment& e, const Recording& recording, const StandProblem& problem, StandRecording* out, std::string* why) {
  out->file = recording.spec.name;
  out->train = recording.spec.train;
  out->time = recording.time;
  const double step = recording.duration() / static_cast<double>(recording.size() - 1);
  const Smoother smoother{recording.time, std::max(3, static_cast<int>(std::lround(kWindow / step)))};
  read_joints(e, recording, smoother, out);
  const std::string imu = "/imu/" + problem.imu;
  Series xyzw[4];
  if (!read_vector(recording, smoother, imu + "/orientation", "xyzw", xyzw) || !read_vector(recording, smoother, imu + "/angular_velocity", "xyz", out->gyro) ||
      !read_vector(recording, smoother, imu + "/linear_acceleration", "xyz", out->accelerometer)) {
    *why = out->file + ": " + imu + " lacks columns";
    return false;
  }
  for (int i = 0; i < 4; ++i) out->attitude[(i + 1) % 4] = xyzw[i];
  for (const StandFoot& foot : problem.feet) {
    Series axes[6];
    if (!read_vector(recording, smoother, "/wrench/" + foot.sensor + "/force", "xyz", axes) ||
        !read_vector(recording, smoother, "/wrench/" + foot.sensor + "/torque", "xyz", axes + 3)) {
      *why = out->file + ": /wrench/" + foot.sensor + " lacks columns";
      return false;
    }
    for (Series& s : axes) out->wrench.push_back(std::move(s));
  }
  // The ends of a recording are left out: there the local cubics stand on one side only.
  for (int k = 2 * smoother.half; k + 2 * smoother.half < static_cast<int>(recording.size()); k += smoother.half) out->samples.push_back(k);
  return out->samples.size() > 20;
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
    for (const CollisionShape& shape : e.robot.shapes) {
      if (shape.link != foot.link) continue;
      foot.bush.z() = shape.X_LG.p.z();
      if (shape.kind == ShapeKind::kBox) foot.sole = shape.X_LG.p - Vector3d(0, 0, shape.size.z() / 2), foot.size = shape.size;
    }
    problem->feet.push_back(foot);
    LinkInertia& inertia = problem->tree.links[static_cast<size_t>(foot.link)].inertia;
    inertia = LinkInertia{};
    inertia.mass = 1e-9, inertia.I_LLcm_L = 1e-12 * Matrix3d::Identity();
  }
  return problem->feet.size() >= 1;
}

}  // namespace

bool make_stand_problem(const Experiment& e, StandProblem* problem, std::string* why) {
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
    if (!read_recording(e, recording, *problem, &out, why)) return false;
    problem->recordings.push_back(std::move(out));
  }
  for (int j = 0; j < e.num_joints(); ++j) {
    const auto i = static_cast<size_t>(j);
    bool effort = true, command = true;
    for (const StandRecording& r : problem->recordings) {
      if (r.position[i].value.empty()) return *why = "joint " + e.robot.tree.joint(j).name + " has no position", false;
      effort = effort && !r.effort[i].value.empty(), command = command && !r.command[i].value.empty();
    }
    problem->has_effort = problem->has_effort || effort;
    problem->has_command = problem->has_command || command;
    problem->driven.push_back(effort);
  }
  return true;
}

}  // namespace hrp::diagnosis::upright
