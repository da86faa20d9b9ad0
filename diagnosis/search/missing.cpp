// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/missing.h"

#include <algorithm>
#include <cmath>

#include "common/multibody/kinematics.h"
#include "common/multibody/mass_matrix.h"

namespace hrp::diagnosis {
namespace {

class Builder {
 public:
  Builder(const Problem& problem, const Plant& plant, const Paths* paths)
      : problem_(problem), e_(*problem.experiment), plant_(plant), n_(e_.num_joints()), paths_(paths) {}

  MissingRows build(const std::vector<int>& recordings) {
    for (int r : recordings) out_.grids.push_back(make_grid(r));
    for (const Grid& g : out_.grids) out_.rows += g.q.rows();
    find_deviations();
    fill_residual();
    return std::move(out_);
  }

 private:
  Grid make_grid(int r) {
    const Recording& recording = e_.recordings[static_cast<size_t>(r)];
    const SmoothRecording& smooth = problem_.smooth[static_cast<size_t>(r)];
    Grid g;
    g.recording = r;
    int half = 3;
    for (const SmoothJoint& joint : smooth.joints) half = std::max(half, joint.half_window);
    for (size_t k = static_cast<size_t>(half) / 2; k + static_cast<size_t>(half) / 2 < recording.size();
         k += static_cast<size_t>(std::max(2, half / 2)))
      g.samples.push_back(k);
    const long rows = static_cast<long>(g.samples.size());
    for (Eigen::MatrixXd* m : {&g.q, &g.qd, &g.qdd, &g.u, &g.c, &g.cd, &g.u1, &g.u2, &g.servo}) m->setZero(rows, n_);
    for (int j = 0; j < n_; ++j) fill_joint(recording, smooth, j, &g);
    if (paths_) take_path((*paths_)[static_cast<size_t>(r)], &g);
    g.tau = g.bare = calc_efforts(add_by_hand(plant_, recording.spec), g.q, g.qd, g.qdd);
    for (long k = 0; k < rows; ++k) {
      for (int j = 0; j < n_; ++j) g.tau(k, j) += calc_law_effort(j, g, k);
    }
    return g;
  }

  void take_path(const RobotPath& path, Grid* g) const {
    for (size_t i = 0; i < g->samples.size(); ++i) {
      const size_t k = g->samples[i];
      const long row = static_cast<long>(i);
      for (int j = 0; j < n_; ++j) {
        const JointPath& p = path[static_cast<size_t>(j)];
        g->q(row, j) = p.q[k];
        g->qd(row, j) = p.qd[k];
        g->qdd(row, j) = p.qdd[k];
      }
    }
  }

  void fill_joint(const Recording& recording, const SmoothRecording& smooth, int j, Grid* g) {
    const SmoothJoint& joint = smooth.joints[static_cast<size_t>(j)];
    const JointColumns& columns = recording.joints[static_cast<size_t>(j)];
    const JointLaws& laws = plant_.laws[static_cast<size_t>(j)];
    std::vector<double> effort = smooth.effort[static_cast<size_t>(j)], servo(recording.size(), 0.0), u1, u2, c, cd;
    if (!columns.command.empty()) {
      for (size_t k = 0; k < recording.size(); ++k) {
        const double rate = columns.command_rate.empty() ? 0.0 : columns.command_rate[k];
        const double u = laws.kp * (columns.command[k] - joint.q[k]) + laws.kd * (rate - joint.qd[k]);
        servo[k] = std::max(-laws.effort_limit, std::min(laws.effort_limit, u));
      }
      smooth_series(recording.time, columns.command, std::max(2, joint.half_window / 2), nullptr, &c, &cd);
    }
    out_.has_effort.resize(static_cast<size_t>(n_), 1);
    if (effort.empty()) {
      effort = servo;
      out_.has_effort[static_cast<size_t>(j)] = 0;
    }
    smooth_series(recording.time, effort, std::max(4, joint.half_window), nullptr, &u1, &u2);
    for (size_t i = 0; i < g->samples.size(); ++i) {
      const size_t k = g->samples[i];
      const long row = static_cast<long>(i);
      g->q(row, j) = joint.q[k];
      g->qd(row, j) = joint.qd[k];
      g->qdd(row, j) = joint.qdd[k];
      g->u(row, j) = effort[k];
      g->u1(row, j) = u1[k];
      g->u2(row, j) = u2[k];
      g->servo(row, j) = servo[k];
      if (!c.empty()) {
        g->c(row, j) = c[k];
        g->cd(row, j) = cd[k];
      }
    }
  }

  // Effort of the base hypothesis' laws (friction, spring, rotor, drive) along the motion.
  double calc_law_effort(int j, const Grid& g, long k) const {
    const JointLaws& law = plant_.laws[static_cast<size_t>(j)];
    const double v = g.qd(k, j), q = g.q(k, j), s = calc_direction(v), u = g.u(k, j);
    const double given = calc_given_torque(law, u - law.lag * g.u1(k, j), v);
    const double level =
        calc_friction_level(law, std::abs(v), given, s) + calc_holding_level(law, given - law.viscous * v, s);
    const double dry = law.has_friction() ? level * s : 0.0;
    return u - given + calc_taken_torque(law, q, v, g.qdd(k, j)) + dry;
  }

  // Standard deviation of each kind of row: smoothed effort noise, and acceleration noise times the mass matrix.
  void find_deviations() {
    const Problem& p = problem_;
    out_.sigma.assign(2 * static_cast<size_t>(n_), 0.0);
    Data data(*plant_.model);
    State state = make_state(*plant_.model);
    Eigen::MatrixXd M2 = Eigen::MatrixXd::Zero(n_, n_);
    double n = 0.0;
    for (const Grid& g : out_.grids) {
      for (long k = 0; k < g.q.rows(); k += 20) {
        state.q = g.q.row(k);
        update_kinematics(*plant_.model, state, &data);
        M2 += update_mass_matrix(*plant_.model, &data).cwiseAbs2();
        n += 1.0;
      }
    }
    M2 /= std::max(1.0, n);
    for (int j = 0; j < n_; ++j) {
      const auto& noise = e_.joint_noise[static_cast<size_t>(j)];
      const JointLaws& laws = plant_.laws[static_cast<size_t>(j)];
      const int half = p.smooth[static_cast<size_t>(p.train[0])].joints[static_cast<size_t>(j)].half_window;
      const double average = 2.25 / (2.0 * std::max(3, half) + 1.0);
      double effort = out_.has_effort[static_cast<size_t>(j)] ? noise[2].sigma * noise[2].sigma : 0.0;
      const double servo =
          laws.kp * laws.kp * noise[0].sigma * noise[0].sigma + laws.kd * laws.kd * noise[1].sigma * noise[1].sigma;
      if (!out_.has_effort[static_cast<size_t>(j)]) effort = servo;
      double variance = effort * average;
      for (int k = 0; k < n_; ++k) {
        const double s = p.smooth[static_cast<size_t>(p.train[0])].joints[static_cast<size_t>(k)].sigma_qdd;
        variance += M2(j, k) * s * s;
      }
      out_.sigma[static_cast<size_t>(j)] = std::sqrt(variance) + 1e-12;
      out_.sigma[static_cast<size_t>(n_) + static_cast<size_t>(j)] = std::sqrt((effort + servo) * average) + 1e-12;
    }
  }

  void fill_residual() {
    out_.residual.setZero(out_.rows * 2 * n_);
    long row = 0;
    for (const Grid& g : out_.grids) {
      for (long k = 0; k < g.q.rows(); ++k, ++row) {
        for (int j = 0; j < n_; ++j) {
          if (!e_.robot.tree.joint(j).actuated) continue;
          out_.residual[row * 2 * n_ + j] = (g.u(k, j) - g.tau(k, j)) / out_.sigma[static_cast<size_t>(j)];
          if (out_.has_effort[static_cast<size_t>(j)] && !plant_.effort_driven) {
            const double sigma = out_.sigma[static_cast<size_t>(n_) + static_cast<size_t>(j)];
            out_.residual[row * 2 * n_ + n_ + j] = (g.u(k, j) - g.servo(k, j)) / sigma;
          }
        }
      }
    }
  }

  const Problem& problem_;
  const Experiment& e_;
  const Plant& plant_;
  int n_;
  const Paths* paths_;
  MissingRows out_;
};

}  // namespace

MissingRows calc_missing_rows(const Problem& problem, const Plant& plant, const std::vector<int>& recordings,
                              const Paths* paths) {
  return Builder(problem, plant, paths).build(recordings);
}

MissingEffort calc_missing_effort(const Problem& problem, const Hypothesis& base, int recording) {
  const Experiment& e = *problem.experiment;
  const MissingRows rows = calc_missing_rows(problem, make_plant(e, base), {recording});
  const Grid& g = rows.grids[0];
  MissingEffort m;
  for (size_t k : g.samples) m.time.push_back(e.recordings[static_cast<size_t>(recording)].time[k]);
  m.q = g.q;
  m.qd = g.qd;
  m.u = g.u;
  for (int j = 0; j < e.num_joints(); ++j) {
    if (!e.robot.tree.joint(j).actuated) m.u.col(j).setZero();
  }
  m.missing = m.u - g.tau;
  m.sigma.assign(rows.sigma.begin(), rows.sigma.begin() + e.num_joints());
  return m;
}

}  // namespace hrp::diagnosis
