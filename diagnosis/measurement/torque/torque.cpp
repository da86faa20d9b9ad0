// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/torque/torque.h"

#include <algorithm>

#include "diagnosis/data/low_pass.h"
#include "diagnosis/measurement/servo_rates.h"
#include "diagnosis/measurement/torque/effort.h"
#include "diagnosis/measurement/torque/load.h"
#include "diagnosis/measurement/torque/motion.h"
#include "diagnosis/measurement/torque/stops.h"
#include "diagnosis/measurement/torque/use.h"
#include "diagnosis/measurement/unseen_contact.h"

namespace hrp::diagnosis {
namespace {

TorqueWork begin_work(const Experiment& e, const BodyTorques& bodies) {
  const size_t count = e.recordings.size();
  TorqueWork w{e,
               bodies,
               make_plant(e, {}),
               {},
               {},
               std::vector<Flags>(count),
               std::vector<Flags>(count),
               std::vector<SharpMotion>(count),
               false,
               {}};
  w.closed.resize(count);
  w.data.experiment = &e;
  w.data.behind_gears = bodies != nullptr && !e.scenario.floating_base;
  if (!bodies) w.data.feet = list_loaded_feet(e);
  for (size_t r = 0; r < count; ++r) {
    for (int j = 0; j < e.num_joints(); ++j) {
      const bool known = e.recordings[r].joints[static_cast<size_t>(j)].has(Quantity::kPosition);
      w.closed[r].push_back(known ? std::vector<double>{} : close_chain(e, e.recordings[r], j));
    }
  }
  return w;
}

// What is known of the drives and links before any motion.
void read_drives(const std::vector<VelocityReading>& velocity, TorqueWork* w) {
  w->data.delays = find_servo_delays(w->e);
  w->data.servo = find_servo_readings(w->e, w->data.delays, velocity);
  for (int j = 0; j < w->e.num_joints(); ++j) {
    w->data.source.push_back(find_effort_source(w->e, static_cast<size_t>(j)));
    w->noise.push_back(find_position_noise(w->e, static_cast<size_t>(j)));
    const std::string unlogged = describe_unlogged(w->e, j, w->data.source.back());
    if (!unlogged.empty()) w->data.missing.push_back(unlogged);
  }
  for (const LinkSpec& link : w->e.robot.tree.links) w->data.load_p_L.push_back(link.inertia.p_LLcm_L);
}

// `velocity`: what is corrected in `e`.
TorqueData make_data(const Experiment& e, const std::vector<VelocityReading>& velocity, const BodyTorques& bodies) {
  TorqueWork w = begin_work(e, bodies);
  read_drives(velocity, &w);
  make_torque_motions(&w);
  make_sharp_speeds(&w);
  for (TorqueRecording& r : w.data.recordings) r.load = r.tau;
  choose_encoders(&w);
  w.data.loaded_by_drive.assign(w.data.source.size(), 0);
  for (int j = 0; j < e.num_joints(); ++j) {
    if (w.data.is_judged(j)) choose_speed_and_load(&w, j);
  }
  for (TorqueRecording& r : w.data.recordings) make_missing_torque(&w, &r);
  for (int j = 0; j < e.num_joints(); ++j) leave_out_limits(&w, j);
  leave_out_unseen_contact(&w);
  for (int j = 0; j < e.num_joints(); ++j) {
    if (w.data.is_judged(j)) leave_out_stops(&w, j);
  }
  for (int j = 0; j < e.num_joints(); ++j) {
    if (w.data.is_judged(j)) take_out_log_ripple(&w, j);
  }
  return std::move(w.data);
}

}  // namespace

Eigen::VectorXd TorqueData::condition(const TorqueRecording& r, const Eigen::VectorXd& full) const {
  const Eigen::VectorXd filtered = low_pass(full, r.step, cutoff);
  const long kept = std::max(0L, (full.size() - 2 * r.trim + r.stride - 1) / r.stride);
  Eigen::VectorXd out(kept);
  for (long k = 0; k < kept; ++k) out[k] = filtered[r.full_row(k)];
  return out;
}

Eigen::VectorXd TorqueData::calc_sign(const TorqueRecording& r, int joint) const {
  return (r.speed.col(joint).array() / slow[static_cast<size_t>(joint)]).tanh().matrix();
}

Eigen::VectorXd TorqueData::calc_direction(const TorqueRecording& r, int joint) const {
  return condition(r, calc_sign(r, joint));
}

Eigen::VectorXd read_link_angle(const Experiment& experiment, int joint, const TorqueRecording& r, double cutoff) {
  const Recording& in = experiment.recordings[r.index];
  const std::vector<double>& angle = in.other.at(kLinkSide + experiment.robot.tree.joint(joint).name + "/position");
  return low_pass(resample(in.time, angle, r.begin, r.step, r.q.rows()), r.step, cutoff);
}

TorqueData make_torque_data(const Experiment& experiment) { return make_torque_data(experiment, nullptr); }

TorqueData make_torque_data(const Experiment& experiment, const BodyTorques& bodies) {
  const std::vector<VelocityReading> velocity = find_velocity_readings(experiment);
  const bool faulty =
      std::any_of(velocity.begin(), velocity.end(), [](const VelocityReading& log) { return log.is_faulty(); });
  TorqueData data = faulty ? make_data(correct_joint_logs(experiment, velocity), velocity, bodies)
                           : make_data(experiment, velocity, bodies);
  data.experiment = &experiment;
  data.velocity = velocity;
  return data;
}

}  // namespace hrp::diagnosis
