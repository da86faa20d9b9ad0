// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/data.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/standing/attitude.h"
#include "diagnosis/standing/sole.h"

namespace hrp::diagnosis::standing {
namespace {

constexpr double kWindow = 0.03;  // [s] half width; a standing robot moves below 3 Hz, which a local cubic follows

// Reads and smooths the columns base/x, base/y, ...; returns false if the recording lacks one.
bool read_vector(const Recording& recording, const Smoother& smoother, const std::string& base, const char* parts,
                 SmoothSeries* out) {
  for (int i = 0; parts[i]; ++i) {
    const auto at = recording.other.find(base + "/" + parts[i]);
    if (at == recording.other.end()) return false;
    out[i] = smoother.run(fill_gaps(at->second));
  }
  return true;
}

bool read_quaternion(const Recording& recording, const Smoother& smoother, const std::string& base,
                     SmoothSeries* wxyz) {
  SmoothSeries xyzw[4];
  if (!read_vector(recording, smoother, base, "xyzw", xyzw)) return false;
  for (int i = 0; i < 4; ++i) wxyz[(i + 1) % 4] = std::move(xyzw[i]);
  return true;
}

void read_joints(const Experiment& e, const Recording& recording, const Smoother& smoother, const Smoother& wide,
                 StandRecording* out) {
  for (int j = 0; j < e.num_joints(); ++j) {
    const JointColumns& columns = recording.joints[static_cast<size_t>(j)];
    const auto read = [&](Quantity q) {
      return columns.has(q) ? smoother.run(fill_gaps(columns.signal[static_cast<int>(q)])) : SmoothSeries{};
    };
    out->position.push_back(read(Quantity::kPosition));
    out->velocity.push_back(read(Quantity::kVelocity));
    out->effort.push_back(read(Quantity::kEffort));
    if (columns.has(Quantity::kEffort)) {
      out->effort.back().second = wide.run(fill_gaps(columns.signal[static_cast<int>(Quantity::kEffort)])).second;
    }
    out->command.push_back(columns.command.empty() ? SmoothSeries{} : smoother.run(columns.command));
  }
}

bool read_feet(const Recording& recording, const Smoother& smoother, const StandProblem& problem, StandRecording* out,
               std::string* why) {
  for (const StandFoot& foot : problem.feet) {
    SmoothSeries axes[6];
    if (!read_vector(recording, smoother, "/wrench/" + foot.sensor + "/force", "xyz", axes) ||
        !read_vector(recording, smoother, "/wrench/" + foot.sensor + "/torque", "xyz", axes + 3)) {
      *why = out->file + ": /wrench/" + foot.sensor + " lacks columns";
      return false;
    }
    for (SmoothSeries& s : axes) out->wrench.push_back(std::move(s));
  }
  return true;
}

// Finds samples where a local cubic cannot follow the raw signals of IMU and force sensors, such as impacts or a foot
// that rolls onto its edge. By sample: rms of the residual relative to the quietest quarter, for the worst column.
std::vector<double> find_roughness(const Recording& recording, const StandRecording& out,
                                   const std::vector<std::pair<std::string, const SmoothSeries*>>& columns) {
  const auto n = out.time.size();
  const auto half = static_cast<size_t>(out.window);
  std::vector<double> worst(n, 0.0);
  for (const auto& [name, series] : columns) {
    const std::vector<double> raw = fill_gaps(recording.other.at(name));
    std::vector<double> sum(n + 1, 0.0), rms(n, 0.0);
    for (size_t k = 0; k < n; ++k) sum[k + 1] = sum[k] + std::pow(raw[k] - series->value[k], 2);
    for (size_t k = 0; k < n; ++k) {
      const size_t a = k >= half ? k - half : 0, b = std::min(n, k + half + 1);
      rms[k] = std::sqrt((sum[b] - sum[a]) / static_cast<double>(b - a));
    }
    std::vector<double> sorted = rms;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<long>(n / 4), sorted.end());
    const double quiet = sorted[n / 4];
    for (size_t k = 0; k < n && quiet > 0; ++k) worst[k] = std::max(worst[k], rms[k] / quiet);
  }
  return worst;
}

// Selects one sample per window. Leaves out the ends of the recording, where cubics are one-sided, and rough samples:
// several times as rough as the quietest quarter, while for white noise in 10 samples the rms scatters by a quarter.
// kMinority of the samples is always kept, so a robot that always shakes is judged by its quieter part.
void choose_samples(const Recording& recording, const StandProblem& problem, StandRecording* out) {
  std::vector<std::pair<std::string, const SmoothSeries*>> columns;
  const std::string imu = "/imu/" + problem.imu, axes = "xyz";
  for (size_t i = 0; i < 3; ++i) {
    columns.emplace_back(imu + "/angular_velocity/" + axes[i], &out->gyro[i]);
    columns.emplace_back(imu + "/linear_acceleration/" + axes[i], &out->accelerometer[i]);
    for (size_t f = 0; f < problem.feet.size(); ++f) {
      const std::string wrench = "/wrench/" + problem.feet[f].sensor;
      columns.emplace_back(wrench + "/force/" + axes[i], &out->wrench[6 * f + i]);
      columns.emplace_back(wrench + "/torque/" + axes[i], &out->wrench[6 * f + 3 + i]);
    }
  }
  const std::vector<double> rough = find_roughness(recording, *out, columns);
  const int half = out->window, n = static_cast<int>(recording.size());
  std::vector<double> sorted = rough;
  const auto most = static_cast<long>(kMinority * n);
  std::nth_element(sorted.begin(), sorted.begin() + most, sorted.end());
  const double limit = std::max(kSeveralTimes, sorted[static_cast<size_t>(most)]);
  for (int k = 2 * half; k + 2 * half < n; k += half) {
    out->grid.push_back(k);
    if (rough[static_cast<size_t>(k)] <= limit) out->samples.push_back(k);
  }
}

bool read_recording(const Experiment& e, const Recording& recording, Smoothing smoothing, const StandProblem& problem,
                    StandRecording* out, std::string* why) {
  out->file = recording.spec.name;
  out->train = recording.spec.train;
  out->time = recording.time;
  if (recording.size() < 40) {
    *why = out->file + " is too short";
    return false;
  }
  const double step = recording.duration() / static_cast<double>(recording.size() - 1);
  const int half = std::max(3, static_cast<int>(std::lround(kWindow / step)));
  const Smoother smoother(recording.time, static_cast<int>(std::ceil(smoothing.wider * half)), smoothing.parity);
  const Smoother wide(recording.time, std::min(3 * smoother.half(), static_cast<int>(recording.size() / 4)),
                      smoothing.parity);
  read_joints(e, recording, smoother, wide, out);
  const std::string imu = "/imu/" + problem.imu;
  if (!read_vector(recording, smoother, imu + "/angular_velocity", "xyz", out->gyro) ||
      !read_vector(recording, smoother, imu + "/linear_acceleration", "xyz", out->accelerometer)) {
    *why = out->file + ": " + imu + " lacks columns";
    return false;
  }
  if (!read_quaternion(recording, smoother, imu + "/orientation", out->attitude)) out->attitude[0] = {};
  if (!read_vector(recording, smoother, "/base/pose/position", "xyz", out->base_position) ||
      !read_quaternion(recording, smoother, "/base/pose/orientation", out->base_attitude)) {
    out->base_attitude[0] = {};
  }
  if (!read_feet(recording, smoother, problem, out, why)) return false;
  out->window = out->step = smoother.half();
  choose_samples(recording, problem, out);
  // Half-sampled and wide smoothings may have few samples: they are only used where the usual smoothing has samples.
  const bool usual = smoothing.parity == Parity::kAll && smoothing.wider == 1;
  if (usual && out->samples.size() <= 20) {
    *why = out->file + " is too short";
    return false;
  }
  return true;
}

// True if many samples of a sensor equal the previous one in all of its columns, so values are held between updates.
bool are_held(const std::vector<const std::vector<double>*>& columns) {
  size_t same = 0;
  const size_t size = columns.empty() ? 0 : columns[0]->size();
  for (size_t k = 1; k < size; ++k) {
    same += std::all_of(columns.begin(), columns.end(), [k](const auto* c) { return (*c)[k] == (*c)[k - 1]; });
  }
  return static_cast<double>(same) > kMinority * static_cast<double>(size);
}

bool has_held_samples(const Recording& recording) {
  for (const JointColumns& joint : recording.joints) {
    std::vector<const std::vector<double>*> columns;
    for (Quantity q : {Quantity::kPosition, Quantity::kVelocity, Quantity::kEffort}) {
      if (joint.has(q)) columns.push_back(&joint.signal[static_cast<int>(q)]);
    }
    if (are_held(columns)) return true;
  }
  // by sensor name, the prefix of the column names
  std::map<std::string, std::vector<const std::vector<double>*>> sensors;
  for (const auto& [name, column] : recording.other) sensors[name.substr(0, name.rfind('/'))].push_back(&column);
  return std::any_of(sensors.begin(), sensors.end(), [](const auto& sensor) { return are_held(sensor.second); });
}

// Feet must be separate links with a force sensor. Moves the mass of each foot from the tree to its StandFoot.
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
    if (e.robot.tree.frames[static_cast<size_t>(e.robot.tree.find_frame(name))].below.mass <= 0) {
      // The foot is part of what its reading carries (floating::convert_whole_readings()).
      problem->feet.push_back(foot);
      continue;
    }
    LinkInertia& inertia = problem->tree.links[static_cast<size_t>(foot.link)].inertia;
    foot.mass = inertia.mass;
    foot.com = inertia.p_LLcm_L;
    problem->feet.push_back(foot);
    inertia = LinkInertia{};
    inertia.mass = 1e-9;
    inertia.I_LLcm_L = 1e-12 * Matrix3d::Identity();
  }
  return !problem->feet.empty();
}

// Finds which columns all recordings have. Returns false if a joint has no position.
bool find_columns(const Experiment& e, StandProblem* problem, std::string* why) {
  for (int j = 0; j < e.num_joints(); ++j) {
    const auto i = static_cast<size_t>(j);
    // With drive "motion" the joints follow the recording, so there is no servo law to compare with.
    bool effort = true, command = e.scenario.drive != "motion", velocity = true;
    for (const StandRecording& r : problem->recordings) {
      if (r.position[i].value.empty()) {
        *why = "joint " + e.robot.tree.joint(j).name + " has no position";
        return false;
      }
      effort = effort && !r.effort[i].value.empty();
      command = command && !r.command[i].value.empty();
      velocity = velocity && !r.velocity[i].value.empty();
    }
    problem->effort.push_back(effort);
    problem->command.push_back(command);
    problem->velocity.push_back(velocity);
  }
  problem->base_pose = true;
  for (const StandRecording& r : problem->recordings) {
    problem->base_pose = problem->base_pose && !r.base_attitude[0].value.empty();
    problem->attitude = problem->attitude && !r.attitude[0].value.empty();
  }
  return true;
}

}  // namespace

bool make_stand_problem(const Experiment& e, Smoothing smoothing, StandProblem* problem, std::string* why) {
  problem->experiment = &e;
  NominalRobot nominal = make_nominal(e);
  problem->tree = std::move(nominal.tree);
  problem->laws = std::move(nominal.laws);
  problem->force_W = std::move(nominal.force_W);
  if (!e.scenario.floating_base) {
    *why = "the base is fixed";
    return false;
  }
  if (e.scenario.sensors.imus.empty()) {
    *why = "no IMU";
    return false;
  }
  const ImuSpec& imu = e.scenario.sensors.imus[0];
  problem->imu = imu.name;
  const int frame = e.robot.tree.find_frame(imu.link);
  if (frame < 0) {
    *why = "the IMU's link is not of the robot";
    return false;
  }
  const FrameSpec& f = e.robot.tree.frames[static_cast<size_t>(frame)];
  problem->imu_link = f.link;
  problem->R_LI = f.X_LF.R;
  problem->p_LI = f.X_LF * imu.p_LS;
  if (!find_feet(e, problem)) {
    *why = "not every foot has a force sensor at its own link";
    return false;
  }
  for (const Recording& recording : e.recordings) {
    StandRecording out;
    if (!read_recording(e, recording, smoothing, *problem, &out, why)) return false;
    problem->recordings.push_back(std::move(out));
    problem->held = problem->held || has_held_samples(recording);
  }
  if (!find_columns(e, problem, why)) return false;
  if (!problem->attitude) {
    for (StandRecording& r : problem->recordings) {
      problem->attitude_error = std::max(problem->attitude_error, find_attitude(*problem, &r));
    }
  }
  return true;
}

}  // namespace hrp::diagnosis::standing
