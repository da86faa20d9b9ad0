// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/joint_zeros.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/measurement/motion_rows.h"
#include "diagnosis/model/made.h"
#include "diagnosis/simulation/bodies.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {
namespace {

constexpr double kLeast = 0.1;  // [rad] smaller offsets are linear to half a percent

// Zeros and senses of all joints, and their squared residual.
class Fitter {
 public:
  Fitter(const Plant& plant, const SampledMotion& rows) : plant_(plant), rows_(rows) {
    const long n = rows.q.cols();
    zero.setZero(n);
    sense.setOnes(n);
    least = calc_left();
  }

  // Sum over the joints of the squared residual after friction and rotor, relative to the effort's variance.
  double calc_left() const {
    const auto turn = [&](const Eigen::MatrixXd& m) -> Eigen::MatrixXd { return m * sense.asDiagonal(); };
    const Eigen::MatrixXd q = turn(rows_.q).rowwise() + zero.transpose();
    const Eigen::MatrixXd missing = rows_.effort - turn(calc_efforts(plant_, q, turn(rows_.v), turn(rows_.a)));
    return rows_.calc_left(missing);
  }

  // Accepts the values if they reduce the residual.
  bool try_joint(long joint, double new_zero, double new_sense) {
    const double old_zero = zero[joint], old_sense = sense[joint];
    zero[joint] = std::remainder(new_zero, 2.0 * M_PI);
    sense[joint] = new_sense;
    const double left = calc_left();
    if (left < least) {
      least = left;
      return true;
    }
    zero[joint] = old_zero;
    sense[joint] = old_sense;
    return false;
  }

  void take(const Fitter& other) {
    zero = other.zero;
    sense = other.sense;
    least = other.least;
  }

  void refine(long joint) {
    double step = 0.25;
    for (int i = 0; i < kHalvings; ++i, step *= 0.5) {
      while (try_joint(joint, zero[joint] + step, sense[joint]) || try_joint(joint, zero[joint] - step, sense[joint])) {
      }
    }
  }

  bool try_quarters(long joint, bool may_turn) {
    bool better = false;
    for (double s : {1.0, -1.0}) {
      for (int quarter = -1; quarter <= 2; ++quarter) {
        if (s == sense[joint] || may_turn) better |= try_joint(joint, 0.5 * M_PI * quarter, s);
      }
    }
    return better;
  }

  void sweep(long joint, bool may_turn) {
    try_quarters(joint, may_turn);
    refine(joint);
  }

  // Returns to the model's values if the residual hardly increases.
  void simplify(long joint, double zero_then, double sense_then) {
    const double old_zero = zero[joint], old_sense = sense[joint], before = least;
    zero[joint] = zero_then;
    sense[joint] = sense_then;
    const double left = calc_left();
    if (left * kNearlyAll < before) {
      least = left;
    } else {
      zero[joint] = old_zero;
      sense[joint] = old_sense;
    }
  }

  Eigen::VectorXd zero, sense;
  double least = 0.0;

 private:
  const Plant& plant_;
  const SampledMotion& rows_;
};

Eigen::MatrixXd calc_efforts_under(const TorqueData& data, const Vector3d& g_W, const Eigen::MatrixXd& q,
                                   const Eigen::MatrixXd& v, const Eigen::MatrixXd& a) {
  Experiment e = *data.experiment;
  e.recordings.clear();
  e.scenario.gravity_W = g_W;
  return calc_efforts(make_plant(e, {}), q, v, a);
}

bool may_be_off(const TorqueData& data, long joint) {
  return data.experiment->robot.tree.joint(static_cast<int>(joint)).kind == JointKind::kRevolute;
}

Fitter fit_from(const TorqueData& data, Fitter fitter, const SampledMotion& rows) {
  for (int i = 0; i < kFewRounds; ++i) {  // over all joints, as each zero depends on the others
    for (long j = 0; j < rows.q.cols(); ++j) {
      if (may_be_off(data, j)) fitter.sweep(j, i == 0);
    }
  }
  for (long j = 0; j < rows.q.cols(); ++j) {
    if (fitter.sense[j] < 0.0) fitter.simplify(j, fitter.zero[j], 1.0);
    if (fitter.zero[j] != 0.0) fitter.simplify(j, 0.0, fitter.sense[j]);
  }
  for (long j = 0; j < rows.q.cols(); ++j) {
    if (fitter.zero[j] != 0.0) fitter.refine(j);
  }
  return fitter;
}

// The nominal model with the one joint whose quarter turns and sense alone explain most.
Fitter turn_best_joint(const TorqueData& data, const Fitter& nominal) {
  Fitter best = nominal;
  for (long j = 0; j < nominal.zero.size(); ++j) {
    Fitter one = nominal;
    if (may_be_off(data, j) && one.try_quarters(j, true) && one.least < best.least) best.take(one);
  }
  return best;
}

long count_changed(const Fitter& f) { return (f.zero.array() != 0.0 || f.sense.array() < 0.0).count(); }

// A search joint by joint ends where an earlier joint has done a part of what a later one does alone. The order of the
// joints means nothing, so it also begins with the joint that does most. The fewest changes win among fits that are
// nearly as good.
Fitter fit(const TorqueData& data, const Plant& plant, const SampledMotion& rows) {
  const Fitter nominal(plant, rows);
  Fitter in_order = fit_from(data, nominal, rows);
  if (count_changed(in_order) < 2) return in_order;
  const Fitter from_best = fit_from(data, turn_best_joint(data, nominal), rows);
  const bool fewer = count_changed(from_best) < count_changed(in_order);
  return from_best.least * (fewer ? kNearlyAll : 1.0) < in_order.least * (fewer ? 1.0 : kNearlyAll) ? from_best
                                                                                                    : in_order;
}

// Standard error of the zero from its spread between recordings.
double calc_std(const TorqueData& data, const Plant& plant, const Fitter& found, long joint) {
  double sum = 0.0, squares = 0.0, n = 0.0;
  for (size_t r : list_unloaded_training(data)) {
    const SampledMotion rows = take_rows(data, {r});
    if (rows.tell_nothing()) continue;
    Fitter own(plant, rows);
    own.zero = found.zero;
    own.sense = found.sense;
    own.least = own.calc_left();
    own.refine(joint);
    // On the same turn: half a turn may read as plus or minus pi.
    const double apart = std::remainder(own.zero[joint] - found.zero[joint], 2.0 * M_PI);
    sum += apart;
    squares += apart * apart;
    n += 1.0;
  }
  const double variance = n > 1.0 ? std::max(0.0, squares / n - sum * sum / (n * n)) / (n - 1.0) : 0.0;
  return std::max(kMountingError / kNinetyFive, std::sqrt(variance));
}

}  // namespace

JointZeros find_joint_zeros(const TorqueData& data) {
  JointZeros out;
  if (data.experiment->scenario.floating_base || data.experiment->scenario.gravity_W.norm() == 0.0) return out;
  const std::vector<size_t> train = list_unloaded_training(data);
  const Plant plant = make_plant(*data.experiment, {});
  const SampledMotion rows = take_rows(data, train);
  if (rows.tell_nothing()) return out;
  const double nominal = Fitter(plant, rows).least;
  const Fitter found = fit(data, plant, rows);
  out.left = nominal > 0.0 ? found.least / nominal : 1.0;
  const double samples = rows.count_judged();
  out.of_effort = samples > 0.0 ? found.least / samples : 1.0;
  for (long j = 0; j < rows.q.cols(); ++j) {
    const bool turned = found.sense[j] < 0.0;
    if (!turned && std::abs(found.zero[j]) < kLeast) continue;
    // q_model = s reading + zero, so that the reading is s (true - zero).
    out.joints.push_back(
        {static_cast<int>(j), -found.sense[j] * found.zero[j], calc_std(data, plant, found, j), turned});
  }
  return out;
}

FoundGravity find_gravity(const TorqueData& data) {
  FoundGravity out;
  const SampledMotion rows = take_rows(data, list_unloaded_training(data));
  const long count = rows.q.rows();
  if (rows.tell_nothing()) return out;
  const Eigen::MatrixXd rest = Eigen::MatrixXd::Zero(count, rows.q.cols()),
                        none = rows.effort - calc_efforts_under(data, Vector3d::Zero(), rows.q, rows.v, rows.a);
  Eigen::MatrixXd pull[3];
  for (int axis = 0; axis < 3; ++axis) pull[axis] = calc_efforts_under(data, Vector3d::Unit(axis), rows.q, rest, rest);
  Matrix3d A = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  double squares = 0.0;
  for (long j = 0; j < rows.q.cols(); ++j) {
    const Eigen::MatrixXd& B = rows.basis[static_cast<size_t>(j)];
    Eigen::MatrixXd all(count, 4);
    for (int axis = 0; axis < 3; ++axis) all.col(axis) = pull[axis].col(j).cwiseProduct(rows.use.col(j));
    all.col(3) = none.col(j).cwiseProduct(rows.use.col(j));
    all -= B * (B.transpose() * all);
    A += rows.weight[j] * all.leftCols(3).transpose() * all.leftCols(3);
    b += rows.weight[j] * all.leftCols(3).transpose() * all.col(3);
    squares += rows.weight[j] * all.col(3).squaredNorm();
  }
  const auto left = [&](const Vector3d& g) { return squares - 2.0 * g.dot(b) + g.dot(A * g); };
  out.g_W = A.completeOrthogonalDecomposition().solve(b);
  const double nominal = left(data.experiment->scenario.gravity_W);
  out.left = nominal > 0.0 ? left(out.g_W) / nominal : 1.0;
  return out;
}

Experiment turn_effort(Experiment e, int joint) {
  for (Recording& r : e.recordings) {
    for (double& y : r.joints[static_cast<size_t>(joint)].signal[static_cast<int>(Quantity::kEffort)]) y = -y;
  }
  return e;
}

Experiment convert_zeros(Experiment e, const std::vector<JointZero>& joints) {
  for (const JointZero& zero : joints) {
    const double sign = zero.turned ? -1.0 : 1.0;
    for (Recording& r : e.recordings) {
      JointColumns& joint = r.joints[static_cast<size_t>(zero.joint)];
      for (std::vector<double>* angle : {&joint.signal[0], &joint.command}) {
        for (double& q : *angle) q = sign * (q - zero.offset);
      }
      for (std::vector<double>* other : {&joint.signal[1], &joint.signal[2], &joint.command_rate}) {
        for (double& x : *other) x *= sign;
      }
    }
  }
  return e;
}

}  // namespace hrp::diagnosis
