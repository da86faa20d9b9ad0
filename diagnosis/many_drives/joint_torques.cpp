// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/many_drives/joint_torques.h"

#include <algorithm>

#include "diagnosis/data/low_pass.h"
#include "diagnosis/many_drives/grid_series.h"
#include "diagnosis/standing/motion.h"

namespace hrp::diagnosis::standing {
namespace {

// Converts one recording to a uniform time grid, with the same filter for all signals. Joints are on the grid already;
// IMU and feet are resampled. The local cubics of the input preserve everything below the cutoff.
class Gridder {
 public:
  Gridder(const StandRecording& in, const TorqueRecording& grid, double cutoff)
      : in_(in), grid_(grid), cutoff_(cutoff) {}

  StandRecording run() const {
    StandRecording out;
    out.file = in_.file, out.train = in_.train;
    for (long k = 0; k < grid_.q.rows(); ++k) {
      out.time.push_back(grid_.begin + grid_.step * static_cast<double>(k));
      out.samples.push_back(static_cast<int>(k));
    }
    out.grid = out.samples;
    for (long j = 0; j < grid_.q.cols(); ++j) {
      out.position.push_back(differentiate_twice<SmoothSeries>(grid_.q.col(j), grid_.step));
      out.velocity.emplace_back(), out.effort.emplace_back(), out.command.emplace_back();
    }
    for (const SmoothSeries& s : in_.wrench) out.wrench.push_back(filter(s));
    for (size_t i = 0; i < 3; ++i)
      out.gyro[i] = filter(in_.gyro[i]), out.accelerometer[i] = filter(in_.accelerometer[i]);
    for (size_t i = 0; i < 4; ++i) out.attitude[i] = filter(in_.attitude[i]);
    return out;
  }

 private:
  SmoothSeries filter(const SmoothSeries& s) const {
    const Eigen::VectorXd even = resample(in_.time, s.value, grid_.begin, grid_.step, grid_.q.rows());
    return differentiate_twice<SmoothSeries>(low_pass(even, grid_.step, cutoff_), grid_.step);
  }

  const StandRecording& in_;
  const TorqueRecording& grid_;
  const double cutoff_;
};

class JointTorques : StandMotion {
 public:
  JointTorques(const StandProblem& problem, const Hypothesis& hypothesis)
      : StandMotion(problem, hypothesis, 0, TeethOffsets(static_cast<size_t>(problem.tree.num_joints()))) {}

  // Inverse dynamics [N m], sample x joint.
  Eigen::MatrixXd run() {
    Eigen::VectorXd tau(model_.nv());
    Eigen::MatrixXd out(static_cast<long>(r_.samples.size()), model_.num_joints());
    for (size_t s = 0; s < r_.samples.size(); ++s) {
      read_motion(s);
      calc_inverse_dynamics(model_, vdot_, &wrenches_, &data_, &tau);
      out.row(static_cast<long>(s)) = tau.tail(model_.num_joints());
    }
    return out;
  }
};

bool is_of_drive(const Effect& e) { return is_joint(e) && !get_effect(e.id).felt_elsewhere; }

}  // namespace

TorqueData make_joint_torques(const StandProblem& problem, const Hypothesis& hypothesis) {
  Hypothesis h = hypothesis;
  h.erase(std::remove_if(h.begin(), h.end(), is_of_drive), h.end());
  StandProblem one = problem;
  one.recordings.resize(1);
  one.effort.assign(one.effort.size(), false), one.command = one.velocity = one.effort;
  return make_torque_data(*problem.experiment, [&](const TorqueRecording& grid, double cutoff) {
    one.recordings[0] = Gridder(problem.recordings[grid.index], grid, cutoff).run();
    return JointTorques(one, h).run();
  });
}

}  // namespace hrp::diagnosis::standing
