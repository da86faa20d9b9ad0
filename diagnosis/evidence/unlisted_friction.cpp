// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/unlisted_friction.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/evidence/torque/samples.h"
#include "diagnosis/measurement/kept_rows.h"
#include "diagnosis/model/tree.h"

namespace hrp::diagnosis {
namespace {

class UnlistedFriction {
 public:
  UnlistedFriction(const TorqueData& data, const FoundLaws& laws)
      : data_(data), j_(laws.joint), rows_(data, laws.joint) {
    y_ = rows_.stack([&](size_t r) -> Eigen::VectorXd { return recording(r).missing.col(j_); });
    laws_ = Eigen::MatrixXd(y_.size(), 0);
    for (long c = 0; c < laws.columns[0].cols(); ++c)
      laws_ = append(laws_, rows_.stack([&](size_t r) -> Eigen::VectorXd { return laws.columns[r].col(c); }));
  }

  std::string run(const std::vector<Eigen::VectorXd>& gear) {
    if (rows_.is_few()) return "";
    const auto of_gear = [&](size_t r) { return gear[r]; };
    // These laws have a parameter or two more, and some contain the gear where its load has one sign. So they must do
    // better.
    least_ = (1.0 - kBlur) * rows_.judge(y_, append(laws_, rows_.stack(of_gear)));
    try_postures();
    try_directions();
    try_signs();
    return best_;
  }

 private:
  const TorqueRecording& recording(size_t r) const { return data_.recordings[r]; }

  // Filtered like all signals. `calc`: from a recording to a vector on its full grid.
  template <class Calc>
  Eigen::VectorXd fill(Calc calc) const {
    return rows_.stack([&](size_t r) { return data_.condition(recording(r), calc(recording(r))); });
  }

  Eigen::VectorXd sign(const TorqueRecording& r) const { return data_.calc_sign(r, j_); }
  Eigen::VectorXd load(const TorqueRecording& r) const { return r.load.col(j_).cwiseAbs(); }
  // Friction of the load.
  Eigen::VectorXd hold(const TorqueRecording& r) const { return sign(r).cwiseProduct(load(r)); }

  void consider(double left, const std::string& words) {
    if (left <= least_) {
      least_ = left;
      best_ = words;
    }
  }

  void try_postures() {
    const TreeSpec& tree = data_.experiment->robot.tree;
    const Eigen::VectorXd dry = fill([&](const TorqueRecording& r) { return sign(r); });
    const Eigen::VectorXd loaded = fill([&](const TorqueRecording& r) { return hold(r); });
    for (int k = 0; k < static_cast<int>(data_.source.size()); ++k) {
      if (!is_above(tree, j_ + 1, k + 1) && !is_above(tree, k + 1, j_ + 1)) continue;
      const Eigen::VectorXd turned =
          fill([&](const TorqueRecording& r) { return Eigen::VectorXd(sign(r).cwiseProduct(r.q.col(k))); });
      const Eigen::VectorXd both =
          fill([&](const TorqueRecording& r) { return Eigen::VectorXd(hold(r).cwiseProduct(r.q.col(k))); });
      const std::string of = " that follows the position of " + tree.joint(k).name;
      consider(rows_.judge(y_, append(append(laws_, dry), turned)), "dry friction" + of);
      consider(rows_.judge(y_, append(append(laws_, loaded), both)), "friction of the load" + of);
    }
  }

  // Beside a constant torque: with dry friction, that is a level by direction.
  void try_directions() {
    const Eigen::MatrixXd beside = append(laws_, Eigen::VectorXd::Ones(y_.size()));
    const Eigen::VectorXd loaded = fill([&](const TorqueRecording& r) { return hold(r); });
    const std::string of = " that differs by the direction of motion";
    // A load of one sign drives the joint in one direction only: there the gear is this law.
    const Eigen::ArrayXd torque =
        rows_.stack([&](size_t r) -> Eigen::VectorXd { return keep_rows(recording(r), recording(r).tau.col(j_)); })
            .array();
    const double positive = (torque > 0.0).cast<double>().mean();
    if (positive > kMinority && positive < kMostly)
      consider(rows_.judge(y_, append(append(beside, loaded), fill([&](const TorqueRecording& r) { return load(r); }))),
               "friction of the load" + of);
    consider(rows_.judge(y_, append(beside, fill([&](const TorqueRecording& r) {
                                      return Eigen::VectorXd(r.v.col(j_).cwiseAbs());
                                    }))),
             "viscous friction" + of);
  }

  // With the effort as regressor, what is left is in other units: the larger ones count.
  void try_signs() {
    const auto effort = [&](const TorqueRecording& r) -> Eigen::VectorXd { return r.effort.col(j_); };
    const Eigen::MatrixXd X =
        append(append(laws_, fill(effort)),
               fill([&](const TorqueRecording& r) { return Eigen::VectorXd(effort(r).cwiseAbs()); }));
    const Eigen::VectorXd p = rows_.solve(y_, X).tail(2);
    const double unit = 1.0 - p[0] - std::abs(p[1]);  // the smaller factor of the two signs
    if (!(unit > 0.0)) return;
    consider(rows_.judge(y_, X) / std::min(1.0, unit * unit), "an effort that reads differently with each sign");
  }

  const TorqueData& data_;
  const int j_;
  const JointRows rows_;
  Eigen::VectorXd y_;
  Eigen::MatrixXd laws_;
  double least_ = 0.0;  // squares
  std::string best_;
};

}  // namespace

std::string find_unlisted_friction(const TorqueData& data, const FoundLaws& laws,
                                   const std::vector<Eigen::VectorXd>& gear) {
  return UnlistedFriction(data, laws).run(gear);
}

void doubt_gears(const TorqueDesign& design, const Choice& choice, std::vector<GradedTerm>* graded) {
  for (GradedTerm& g : *graded) {
    if (!g.term.row->backwards || !g.named || g.grade != Grade::kSupported) continue;
    const auto i = static_cast<size_t>(g.place.joint);
    TorqueModel rest = choice.model;
    rest.own[i].erase(rest.own[i].begin() + static_cast<long>(g.place.at));
    std::vector<Eigen::VectorXd> gear;
    for (const TorqueRecording& r : design.data->recordings)
      gear.push_back(calc_joint_columns(*design.data, r, g.term));
    g.instead = find_unlisted_friction(*design.data, list_laws(design, rest, i), gear);
    if (!g.instead.empty()) g.grade = Grade::kAmbiguous;
  }
}

}  // namespace hrp::diagnosis
