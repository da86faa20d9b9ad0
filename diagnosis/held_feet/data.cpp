// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/held_feet/data.h"

#include <algorithm>
#include <cmath>

#include "common/multibody/kinematics.h"
#include "diagnosis/data/smooth.h"

namespace hrp::diagnosis::held_feet {
namespace {

constexpr double kWindow =
    0.03;  // [s] half of it: keeps 5 Hz; a shorter one leaves encoder steps as speeds of 0.5 rad/s
constexpr double kSudden = 8.0;  // robust standard deviations of what smoothing takes away: noise does not reach that

bool contains(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

struct Smoother {
  const std::vector<double>& time;
  int half;
  std::vector<size_t> kept;

  void take(const std::vector<double>& values, long column, Eigen::MatrixXd* value, Eigen::MatrixXd* rate,
            Eigen::MatrixXd* second) const {
    std::vector<double> v, d, dd;
    smooth_series(time, values, half, &v, &d, &dd);
    for (size_t i = 0; i < kept.size(); ++i) {
      const auto row = static_cast<long>(i);
      (*value)(row, column) = v[kept[i]];
      if (rate) (*rate)(row, column) = d[kept[i]];
      if (second) (*second)(row, column) = dd[kept[i]];
    }
  }
};

// Position of a joint that was not recorded, from an attached foot: the coordinate moves the foot along one direction
// (a rail), and the foot stays where it is.
bool close_chain(const Experiment& e, const RecordingSpec& spec, int joint,
                 const std::vector<std::vector<double>>& known, std::vector<double>* position, std::string* why) {
  const std::string name = e.robot.tree.joint(joint).name;
  const int frame = spec.feet_attached.empty() ? -1 : e.robot.tree.find_frame(spec.feet_attached[0]);
  if (frame < 0 || e.robot.tree.joint(joint).kind != JointKind::kPrismatic) {
    return *why = spec.name + ": joint " + name + " has no position, and no attached foot gives it", false;
  }
  Model model(e.robot.tree, e.scenario.gravity_W);
  Data data(model);
  State state = make_state(model);
  Eigen::MatrixXd J(6, model.nv());
  Vector3d anchor = Vector3d::Zero();
  for (size_t k = 0; k < position->size(); ++k) {
    for (int j = 0; j < model.num_joints(); ++j) {
      const std::vector<double>& q = known[static_cast<size_t>(j)];
      state.q(j) = q.empty() ? 0.0 : q[k];
    }
    update_kinematics(model, state, &data);
    calc_frame_jacobian(model, data, frame, J);
    const Vector3d along = J.block<3, 1>(3, joint), foot = calc_frame_pose(model, data, frame).p;
    if (k == 0) anchor = foot;
    (*position)[k] = along.dot(anchor - foot) / std::max(1e-9, along.squaredNorm());
  }
  return true;
}

// Marks samples within two windows of where the reading departs from its smoothed self as no noise does: impacts.
void mark_sudden(const std::vector<double>& values, const Smoother& smoother, std::vector<char>* sudden) {
  std::vector<double> smooth, apart;
  smooth_series(smoother.time, values, smoother.half, &smooth, nullptr, nullptr);
  for (size_t k = 0; k < values.size(); ++k) apart.push_back(std::abs(values[k] - smooth[k]));
  std::vector<double> sorted = apart;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<long>(sorted.size() / 2), sorted.end());
  const double limit = kSudden * 1.4826 * sorted[sorted.size() / 2];
  const auto reach = static_cast<size_t>(2 * smoother.half);
  for (size_t i = 0; i < smoother.kept.size(); ++i) {
    const size_t k = smoother.kept[i], from = k - std::min(k, reach), to = std::min(values.size() - 1, k + reach);
    for (size_t m = from; limit > 0.0 && m <= to; ++m) (*sudden)[i] = (*sudden)[i] || apart[m] > limit;
  }
}

bool read_wrench(const Recording& recording, const RowSensor& sensor, const Smoother& smoother, RowRecording* out,
                 std::string* why) {
  const auto rows = static_cast<long>(smoother.kept.size());
  Eigen::MatrixXd value = Eigen::MatrixXd::Zero(rows, 6), rate = value;
  for (int part = 0; part < 6; ++part) {
    const std::string column = "/wrench/" + sensor.name + (part < 3 ? "/force/" : "/torque/") +
                               std::string(1, static_cast<char>('x' + part % 3));
    const auto at = recording.other.find(column);
    if (at == recording.other.end() && part < 3) return *why = recording.spec.name + " has no " + column, false;
    if (at == recording.other.end()) continue;
    smoother.take(fill_gaps(at->second), part, &value, &rate, nullptr);
    mark_sudden(fill_gaps(at->second), smoother, &out->sudden);
  }
  out->wrench.push_back(value), out->wrench_rate.push_back(rate);
  return true;
}

// Efforts that stand at a limit: a plateau within 1 % of the greatest one that lasts for more than a fiftieth of the
// recording, which no motion leaves by chance.
void mark_clipped(long joint, RowRecording* out) {
  const double greatest = out->effort.col(joint).cwiseAbs().maxCoeff();
  const Eigen::ArrayXd high = (out->effort.col(joint).array().abs() > 0.99 * greatest).cast<double>();
  if (greatest > 0.0 && high.sum() > 0.02 * static_cast<double>(high.size())) out->clipped.col(joint) = high;
}

}  // namespace

bool read_row_recording(const RowProblem& problem, const Recording& recording, RowRecording* out, std::string* why) {
  const Experiment& e = *problem.experiment;
  const auto n = static_cast<size_t>(e.num_joints());
  out->file = recording.spec.name, out->train = recording.spec.train;
  const double dt = recording.duration() / static_cast<double>(recording.size() - 1);
  Smoother smoother{recording.time, std::max(3, static_cast<int>(std::lround(kWindow / dt))), {}};
  const auto half = static_cast<size_t>(smoother.half);
  for (size_t k = 2 * half; k + 2 * half < recording.size(); k += half)
    smoother.kept.push_back(k), out->time.push_back(recording.time[k]);
  if (out->time.size() < 40) return *why = recording.spec.name + " is too short", false;
  out->sudden.assign(out->time.size(), 0);
  std::vector<std::vector<double>> known(n);
  for (size_t j = 0; j < n; ++j) {
    if (recording.joints[j].has(Quantity::kPosition)) known[j] = fill_gaps(recording.joints[j].signal[0]);
  }
  const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(static_cast<long>(out->time.size()), static_cast<long>(n));
  out->q = out->qd = out->qdd = out->effort = out->clipped = zero;
  for (size_t j = 0; j < n; ++j) {
    const JointSpec& spec = e.robot.tree.joint(static_cast<int>(j));
    std::vector<double> position = known[j];
    if (position.empty()) {
      position.resize(recording.size());
      if (!close_chain(e, recording.spec, static_cast<int>(j), known, &position, why)) return false;
    }
    smoother.take(position, static_cast<long>(j), &out->q, &out->qd, &out->qdd);
    const bool effort = recording.joints[j].has(Quantity::kEffort);
    if (spec.actuated && effort) {
      smoother.take(fill_gaps(recording.joints[j].signal[2]), static_cast<long>(j), &out->effort, nullptr, nullptr);
      mark_clipped(static_cast<long>(j), out);
    }
    out->rows.push_back((effort || !spec.actuated) && !contains(recording.spec.unknown_force, spec.name));
    if (!spec.actuated && known[j].empty()) out->rows.back() = 0;  // its motion was not measured
  }
  for (const RowSensor& sensor : problem.sensors) {
    if (!read_wrench(recording, sensor, smoother, out, why)) return false;
  }
  return true;
}

void find_row_noise(RowProblem* problem) {
  const auto n = static_cast<size_t>(problem->experiment->num_joints());
  problem->sigma.assign(n, 0.0);
  for (size_t j = 0; j < n; ++j) {
    std::vector<double> third;
    for (size_t r = 0; r < problem->recordings.size(); ++r) {
      const std::vector<double> rows = calc_rows(*problem, {}, r);
      for (size_t k = 3 * n + j; k < rows.size(); k += n) {
        const double d = rows[k] - 3 * rows[k - n] + 3 * rows[k - 2 * n] - rows[k - 3 * n];
        if (std::isfinite(d)) third.push_back(std::abs(d));
      }
    }
    if (third.size() < 8) continue;
    std::nth_element(third.begin(), third.begin() + static_cast<long>(third.size() / 2), third.end());
    problem->sigma[j] = std::max(1e-9, third[third.size() / 2] / (0.6745 * std::sqrt(20.0)));  // as estimate_noise()
  }
  const RowRecording& first = problem->recordings[0];
  problem->step = (first.time.back() - first.time.front()) / static_cast<double>(first.time.size() - 1);
}

}  // namespace hrp::diagnosis::held_feet
