// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/absent_torque.h"

#include <algorithm>
#include <optional>

#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/load_or_unit.h"
#include "diagnosis/measurement/torque/terms.h"
#include "diagnosis/simulation/bodies.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {
namespace {

constexpr long kEffort = 0, kTau = 1, kWeight = 2, kLoads = 3;  // columns: y, tau, its part at rest, loads of all links

long column_of(Absent part) { return part == Absent::kWeight ? kWeight : kTau; }

// The model's torque along a motion, or its part that is absent.
Eigen::MatrixXd calc_part(const Plant& plant, Absent part, const Eigen::MatrixXd& q, const Eigen::MatrixXd& v,
                          const Eigen::MatrixXd& a) {
  const Eigen::MatrixXd rest = Eigen::MatrixXd::Zero(q.rows(), q.cols());
  return part == Absent::kWeight ? calc_efforts(plant, q, rest, rest) : calc_efforts(plant, q, v, a);
}

// The weight's torque in the rows of collect_efforts().
Eigen::VectorXd collect_weight(const TorqueData& data, const std::vector<Eigen::MatrixXd>& weight, int joint) {
  std::vector<double> out;
  for (size_t i = 0; i < data.recordings.size(); ++i) {
    const TorqueRecording& r = data.recordings[i];
    for (long k = 0; r.train && k < r.kept(); ++k) {
      if (r.use(k, joint)) out.push_back(weight[i](r.full_row(k), joint));
    }
  }
  return Eigen::Map<Eigen::VectorXd>(out.data(), static_cast<long>(out.size()));
}

// Sums of squares of each joint beside friction, rotor and constant, over its effort's.
class Squares {
 public:
  explicit Squares(const TorqueData& data) {
    std::vector<int> joints;
    for (size_t j = 0; j < data.source.size(); ++j) {
      if (data.is_judged(static_cast<int>(j)) && collect_efforts(data, static_cast<int>(j)).tau.size() > kRowsOfFit)
        joints.push_back(static_cast<int>(j));
    }
    std::vector<Term> loads;
    for (size_t link = 1; link < data.experiment->robot.tree.links.size(); ++link)
      loads.push_back({&find_term_row(&TermRow::load), static_cast<int>(link)});
    links = static_cast<int>(loads.size());
    most_ = find_moving_mass(data.experiment->robot.tree);
    for (const Term& load : loads)
      own_.push_back(data.experiment->robot.tree.links[static_cast<size_t>(load.place)].inertia.mass);
    const std::vector<Eigen::MatrixXd> of_loads = collect_loads(data, joints, loads);
    const Plant plant = make_plant(*data.experiment, {});
    std::vector<Eigen::MatrixXd> weight;
    for (const TorqueRecording& r : data.recordings)
      weight.push_back(r.train ? calc_part(plant, Absent::kWeight, r.q, r.v, r.a) : Eigen::MatrixXd());
    for (size_t i = 0; i < joints.size(); ++i) {
      const UnitRows rows = collect_efforts(data, joints[i]);
      Eigen::MatrixXd X(rows.tau.size(), kLoads + of_loads[i].cols());
      X << rows.effort, rows.tau, collect_weight(data, weight, joints[i]), of_loads[i];
      const double spread = (rows.effort.array() - rows.effort.mean()).matrix().squaredNorm();
      if (spread <= 0.0) continue;
      X = take_out(rows.nuisance, X);
      sums_.push_back(X.transpose() * X / spread);
    }
  }

  // What remains of y - tau + absent with the load of one link, and with a share of the absent torque at each joint.
  double calc_left(Absent part, std::optional<int> link, bool shares) const {
    Eigen::Matrix4d xx = Eigen::Matrix4d::Zero();
    Eigen::Vector4d xy = Eigen::Vector4d::Zero();
    double yy = 0.0;
    for (const Eigen::MatrixXd& all : sums_) {
      const Eigen::MatrixXd s = shares ? take_out_share(all, column_of(part)) : all;
      Eigen::VectorXd y = Eigen::VectorXd::Zero(s.rows());
      y[kEffort] = 1.0;
      y[kTau] -= 1.0;
      if (part != Absent::kNothing) y[column_of(part)] += 1.0;
      const Eigen::VectorXd sy = s * y;
      yy += y.dot(sy);
      if (!link) continue;
      const long at = kLoads + kLoadColumns * *link;
      xx += s.block<4, 4>(at, at);
      xy += sy.segment<4>(at);
    }
    if (!link) return yy;
    const Eigen::Vector4d load = xx.completeOrthogonalDecomposition().solve(xy);
    return load[0] < -own_[static_cast<size_t>(*link)] || load[0] > most_ ? yy : std::max(0.0, yy - xy.dot(load));
  }

  bool empty() const { return sums_.empty(); }

  int links = 0;

 private:
  static constexpr long kRowsOfFit = 10 * (kNuisance + kLoadColumns);

  static Eigen::MatrixXd take_out_share(const Eigen::MatrixXd& s, long column) {
    if (s(column, column) <= 0.0) return s;
    return s - s.col(column) * s.row(column) / s(column, column);
  }

  std::vector<Eigen::MatrixXd> sums_;  // by joint
  std::vector<double> own_;            // [kg] by link: no load takes more than that away
  double most_ = 0.0;                  // [kg] arms carry less than they weigh
};

// The load that leaves least; none if it does not leave less than half.
std::optional<int> find_load(const Squares& squares, Absent part) {
  std::optional<int> best;
  double least = kHalf * squares.calc_left(part, {}, false);
  for (int link = 0; link < squares.links; ++link) {
    const double left = squares.calc_left(part, link, false);
    if (left < least) {
      least = left;
      best = link;
    }
  }
  return best;
}

// True if the torque is not in the log at any joint. A share of it may take what chance gives, no more than a minority.
// Nor may shares alone do what a load does: a log in another unit looks like a load of few joints.
bool is_absent(const Squares& squares, Absent part, std::optional<int> load) {
  const double left = squares.calc_left(part, load, false);
  return squares.calc_left(part, load, true) > kMostly * left &&
         (!load || squares.calc_left(part, {}, true) * kHalf > left);
}

}  // namespace

AbsentTorque find_absent_torque(const TorqueData& data) {
  AbsentTorque out;
  const Scenario& scenario = data.experiment->scenario;
  const bool recorded =
      std::none_of(data.source.begin(), data.source.end(), [](EffortSource s) { return s == EffortSource::kServoLaw; });
  if (data.recordings.empty() || scenario.floating_base || scenario.gravity_W.norm() == 0.0 || !recorded ||
      !data.feet.empty())
    return out;
  const Squares squares(data);
  if (squares.empty()) return out;
  const double nominal = squares.calc_left(Absent::kNothing, find_load(squares, Absent::kNothing), false);
  double least = kDetail * nominal;  // the whole mismatch but a detail, whatever the load
  for (const Absent part : {Absent::kWeight, Absent::kBodies}) {
    const std::optional<int> load = find_load(squares, part);
    const double left = squares.calc_left(part, load, false);
    if (left >= least || !is_absent(squares, part, load)) continue;
    out = {part, left / squares.calc_left(Absent::kNothing, {}, false)};
    least = kHalf * left;  // inertia is a detail beside weight: that it is absent, too, must explain much
  }
  return out;
}

Experiment return_torque(Experiment e, Absent part) {
  if (part == Absent::kNothing) return e;
  const TorqueData data = make_torque_data(e);
  const Plant plant = make_plant(e, {});
  std::vector<std::vector<std::vector<double>>> efforts(e.recordings.size());
  for (const TorqueRecording& own : data.recordings) {
    const Eigen::MatrixXd torque = calc_part(plant, part, own.q, own.v, own.a);
    const Recording& r = e.recordings[own.index];
    for (size_t j = 0; j < r.joints.size(); ++j) {
      std::vector<double> y = r.joints[j].signal[static_cast<int>(Quantity::kEffort)];
      const auto of_joint = torque.col(static_cast<long>(j));
      // The recording's own times lie on the grid or between its points.
      for (size_t k = 0; k < y.size(); ++k)
        y[k] += calc_between(of_joint.data(), static_cast<size_t>(of_joint.size()), (r.time[k] - own.begin) / own.step);
      efforts[own.index].push_back(std::move(y));
    }
  }
  for (size_t i = 0; i < efforts.size(); ++i) {
    for (size_t j = 0; j < efforts[i].size(); ++j)
      e.recordings[i].joints[j].signal[static_cast<int>(Quantity::kEffort)] = std::move(efforts[i][j]);
  }
  return e;
}

}  // namespace hrp::diagnosis
