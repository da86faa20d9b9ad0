// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/torque_terms.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/multibody/kinematics.h"
#include "common/multibody/regressor.h"

#include "diagnosis/data/quantile.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/measurement/term_rows.h"
#include "diagnosis/simulation/bodies.h"

namespace hrp::diagnosis {
namespace {

// Stribeck velocities as shares of the joint's fast speed (its 90th percentile).
constexpr double kStribeckShares[] = {0.03, 0.06, 0.12, 0.25};
constexpr double kFast = 0.9;
// [s] A delay's torque is linear in the delay near one of these: with r'' of 10 rad/s^2 and 200 N m/rad, the square of
// 12 ms is 0.14 N m.
constexpr double kDelays[] = {0.003, 0.006, 0.012, 0.024, 0.048};
constexpr double kAngleStep = 1e-4;  // [rad] central differences of inverse dynamics over a position
constexpr double kCoggingPeriods[] = {1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 28, 32, 40};

double find_fast_speed(const TorqueData& data, int joint) {
  std::vector<double> speeds;
  for (const TorqueRecording& r : data.recordings) {
    for (long k = 0; k < r.kept(); ++k) {
      if (r.use(k, joint)) speeds.push_back(std::abs(r.v(r.full_row(k), joint)));
    }
  }
  return find_quantile(std::move(speeds), kFast);
}

double find_travel(const TorqueData& data, int joint) {
  double low = 1e300, high = -1e300;
  for (const TorqueRecording& r : data.recordings)
    low = std::min(low, r.q.col(joint).minCoeff()), high = std::max(high, r.q.col(joint).maxCoeff());
  return high - low;
}

// Fills the rows of all joints for one moment.
class WholeRows {
 public:
  WholeRows(const TorqueData& data, const TorqueRecording& recording, const std::vector<Term>& terms)
      : data_(data),
        terms_(terms),
        tree_(data.experiment->robot.tree),
        loaded_(load(tree_, data.experiment->recordings[recording.index].spec)),
        pulls_(list_pulls(data.experiment->recordings[recording.index].spec, tree_)),
        model_(loaded_, data.experiment->scenario.gravity_W),
        kinematics_(model_),
        state_(make_state(model_)),
        regressor_(model_),
        turned_{turn(0, 1.0), turn(0, -1.0), turn(1, 1.0), turn(1, -1.0)},
        weightless_(loaded_, Vector3d::Zero()),
        mine_(make_inertial_parameters(Model(tree_))),
        tau_(model_.num_joints()) {}

  // `rows`: joint x all columns.
  void fill(const TorqueRecording& r, long full_row, Eigen::MatrixXd* rows) {
    if (tree_.floating_base) {
      for (size_t t = 0; t < terms_.size(); ++t) fill_late(r, full_row, terms_[t].shape, static_cast<long>(t), rows);
      return;
    }
    state_.q = r.q.row(full_row), state_.qd = r.v.row(full_row);
    const Eigen::VectorXd a = r.a.row(full_row);
    update_kinematics(model_, state_, &kinematics_);
    calc_regressor(model_, a, &kinematics_, &regressor_);
    long column = 0;
    for (const Term& term : terms_) {
      if (term.kind == TermKind::kBusDelay) fill_late(r, full_row, term.shape, column, rows);
      else if (get_term_row(term.kind).place == PlaceKind::kLink) fill_link(term, column, rows);
      column += term.columns;
    }
    column = 0;
    for (const Term& term : terms_) {  // these move the model: last
      if (term.kind == TermKind::kOffset) fill_offset(term, r, full_row, column, rows);
      if (term.kind == TermKind::kTilt) fill_tilt(a, column, rows);
      if (term.kind == TermKind::kCarried) rows->col(column) = calc_under(weightless_, a) - calc_under(model_, a);
      column += term.columns;
    }
  }

 private:
  static TreeSpec load(TreeSpec tree, const RecordingSpec& recording) {
    add_loads(recording, &tree);
    return tree;
  }

  static void fill_late(const TorqueRecording& r, long full_row, double delay, long column, Eigen::MatrixXd* rows) {
    for (long j = 0; j < rows->rows(); ++j) (*rows)(j, column) = calc_late(r, j, full_row, delay);
  }

  void fill_link(const Term& term, long column, Eigen::MatrixXd* rows) {
    const long first = static_cast<long>(term.place) * kInertialParameters;
    const auto Y = regressor_.Y_JI.middleCols(first, kInertialParameters);
    const LinkInertia& inertia = tree_.links[static_cast<size_t>(term.place)].inertia;
    if (term.kind == TermKind::kMassError) {
      rows->col(column) = Y * mine_.segment(first, kInertialParameters);
    } else if (term.kind == TermKind::kPayload) {  // m, with the inertia that it has at its place; m c
      rows->middleCols(column, 4) = Y.leftCols(4);
      rows->col(column) += Y * make_point_inertia(data_.load_p_L[static_cast<size_t>(term.place)]);
    } else if (term.kind == TermKind::kComError) {  // the link's mass moved: its moments of mass, and inertia to first order
      for (int axis = 0; axis < 3; ++axis) rows->col(column + axis) = Y * move_com(inertia, axis);
    } else if (term.kind == TermKind::kForce) {
      const Vector3d p_W = get_pose(kinematics_, term.place) * inertia.p_LLcm_L;
      Eigen::MatrixXd J(6, model_.num_joints());
      calc_point_jacobian(model_, kinematics_, term.place, p_W, J);
      rows->middleCols(column, 3) = -J.bottomRows(3).transpose();
    }
  }

  // Inertial parameters [m^2] of one kilogram at a place, about the link's frame: its moments of inertia alone.
  static Eigen::Matrix<double, kInertialParameters, 1> make_point_inertia(const Vector3d& p_L) {
    Eigen::Matrix<double, kInertialParameters, 1> one = Eigen::Matrix<double, kInertialParameters, 1>::Zero();
    const Matrix3d I = p_L.squaredNorm() * Matrix3d::Identity() - p_L * p_L.transpose();
    one.tail<6>() << I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2);
    return one;
  }

  // d(inertial parameters) / d(centre of mass along an axis).
  static Eigen::Matrix<double, kInertialParameters, 1> move_com(const LinkInertia& inertia, int axis) {
    Eigen::Matrix<double, kInertialParameters, 1> d = Eigen::Matrix<double, kInertialParameters, 1>::Zero();
    const double m = inertia.mass;
    const Vector3d c = inertia.p_LLcm_L, e = Vector3d::Unit(axis);
    d[1 + axis] = m;
    const Matrix3d dI = m * (2.0 * c.dot(e) * Matrix3d::Identity() - c * e.transpose() - e * c.transpose());
    d.tail<6>() << dI(0, 0), dI(0, 1), dI(0, 2), dI(1, 1), dI(1, 2), dI(2, 2);
    return d;
  }

  // True position = reading - offset: missing = tau(q - offset) - tau(q).
  void fill_offset(const Term& term, const TorqueRecording& r, long row, long column, Eigen::MatrixXd* rows) {
    const double q = state_.q[term.place];
    const auto calc_at = [&](double angle) -> Eigen::VectorXd {
      state_.q[term.place] = angle;
      update_kinematics(model_, state_, &kinematics_);
      const LinkWrenches wrenches = calc_wrenches(pulls_, model_, kinematics_);
      calc_inverse_dynamics(model_, r.a.row(row), &wrenches, &kinematics_, &tau_);
      if (data_.feet.empty()) return tau_;
      return tau_ - calc_load_torques(model_, kinematics_, data_.feet, r.foot_wrench.row(row));
    };
    rows->col(column) = (calc_at(q - kAngleStep) - calc_at(q + kAngleStep)) / (2.0 * kAngleStep);
    state_.q[term.place] = q;
  }

  // A base that is turned by kAngleStep about x (roll) or y (pitch), or by as much the other way.
  Model turn(int axis, double sign) const {
    const Vector3d gravity_B = Eigen::AngleAxisd(-sign * kAngleStep, Vector3d::Unit(axis)) * data_.experiment->scenario.gravity_W;
    return Model(loaded_, gravity_B);
  }

  void fill_tilt(const Eigen::VectorXd& a, long column, Eigen::MatrixXd* rows) {
    for (size_t axis = 0; axis < 2; ++axis)  // central: what is left of gravity's size would be a weight of any size
      rows->col(column + static_cast<long>(axis)) =
          (calc_under(turned_[2 * axis], a) - calc_under(turned_[2 * axis + 1], a)) / (2.0 * kAngleStep);
  }

  // Torques of this moment's motion under another gravity.
  Eigen::VectorXd calc_under(const Model& model, const Eigen::VectorXd& a) {
    update_kinematics(model, state_, &kinematics_);
    calc_inverse_dynamics(model, a, nullptr, &kinematics_, &tau_);
    return tau_;
  }

  const TorqueData& data_;
  const std::vector<Term>& terms_;
  const TreeSpec& tree_;
  const TreeSpec loaded_;                  // with what hung on it in this recording
  const std::vector<SteadyForce> pulls_;
  const Model model_;
  Data kinematics_;
  State state_;
  Regressor regressor_;
  const std::array<Model, 4> turned_;
  const Model weightless_;
  const Eigen::VectorXd mine_;
  Eigen::VectorXd tau_;
};

}  // namespace

Term make_term(TermKind kind, int place, double shape) {
  const TermRow& row = get_term_row(kind);
  return {kind, place, shape, row.columns, row.whole};
}

double calc_late(const TorqueRecording& r, long joint, long k, double delay) {
  const double samples = std::min(delay / r.step, static_cast<double>(k));
  const long whole = static_cast<long>(samples);
  if (samples <= 0.0) return r.command_rate(k, joint);
  const auto at = [&](double i) {  // between samples
    const long low = static_cast<long>(i), high = std::min(low + 1, k);
    return r.command_rate(low, joint) + (i - static_cast<double>(low)) * (r.command_rate(high, joint) - r.command_rate(low, joint));
  };
  double sum = 0.0;  // trapezia, the last one a part
  for (long i = 0; i < whole; ++i) sum += 0.5 * (r.command_rate(k - i, joint) + r.command_rate(k - i - 1, joint));
  const double rest = samples - static_cast<double>(whole), end = static_cast<double>(k) - samples;
  sum += 0.5 * rest * (at(end) + at(static_cast<double>(k - whole)));
  return sum / samples;
}

std::vector<Term> list_joint_terms(const TorqueData& data, int joint) {
  std::vector<Term> terms;
  if (!data.is_judged(joint)) return terms;
  const double fast = find_fast_speed(data, joint);
  if (fast <= 0.0) return terms;
  const bool driven = data.experiment->robot.tree.joint(joint).actuated;
  for (TermKind kind : {TermKind::kViscous, TermKind::kDry, TermKind::kLoadDry, TermKind::kBackdriven, TermKind::kRotor, TermKind::kGain,
                        TermKind::kGainOfModel, TermKind::kConstant, TermKind::kLag}) {
    if (driven || !get_term_row(kind).needs_drive) terms.push_back(make_term(kind, joint));
  }
  if (!data.behind_gears) terms.push_back(make_term(TermKind::kSpring, joint));
  if (data.source[static_cast<size_t>(joint)] == EffortSource::kServoLaw)
    for (double delay : kDelays) terms.push_back(make_term(TermKind::kCommandDelay, joint, delay));
  for (double share : kStribeckShares) {
    if (share * fast > data.slow[static_cast<size_t>(joint)])
      terms.push_back(make_term(TermKind::kStribeck, joint, share * fast));
  }
  // A ripple is told from a spring or gravity by several periods.
  for (double periods : kCoggingPeriods) {
    if (driven && periods * find_travel(data, joint) > 3.0 * 2.0 * M_PI)
      terms.push_back(make_term(TermKind::kCogging, joint, periods));
  }
  return terms;
}

std::vector<Term> list_whole_terms(const TorqueData& data) {
  std::vector<Term> terms;
  const TreeSpec& tree = data.experiment->robot.tree;
  // On a base that moves, the balance of the whole body tells links and zeros far better than drives with friction do.
  const bool fixed = !data.experiment->scenario.floating_base && !data.behind_gears;
  for (size_t link = 1; fixed && link < tree.links.size(); ++link) {
    const int place = static_cast<int>(link);
    terms.push_back(make_term(TermKind::kPayload, place));
    if (tree.links[link].inertia.mass > 0.0) {
      terms.push_back(make_term(TermKind::kMassError, place));
      terms.push_back(make_term(TermKind::kComError, place));
    }
    terms.push_back(make_term(TermKind::kForce, place));
  }
  for (int j = 0; fixed && j < tree.num_joints(); ++j) terms.push_back(make_term(TermKind::kOffset, j));
  if (fixed && data.experiment->scenario.gravity_W.norm() > 0.0) {
    terms.push_back(make_term(TermKind::kTilt, 0));
    // A servo's law is all that its drive gives; only a log may leave out what a controller adds for gravity.
    const bool logged = std::count(data.source.begin(), data.source.end(), EffortSource::kServoLaw) == 0;
    if (logged && data.feet.empty()) terms.push_back(make_term(TermKind::kCarried, 0));
  }
  if (std::count(data.source.begin(), data.source.end(), EffortSource::kServoLaw) > 1)
    for (double delay : kDelays) terms.push_back(make_term(TermKind::kBusDelay, 0, delay));
  return terms;
}

Eigen::MatrixXd calc_joint_columns(const TorqueData& data, const TorqueRecording& r, const Term& term) {
  return get_term_row(term.kind).calc_columns(data, r, term);
}

std::vector<Eigen::MatrixXd> calc_whole_columns(const TorqueData& data, const TorqueRecording& r,
                                                const std::vector<Term>& terms) {
  long width = 0;
  for (const Term& term : terms) width += term.columns;
  const long n = r.q.cols();
  std::vector<Eigen::MatrixXd> out(static_cast<size_t>(n), Eigen::MatrixXd(r.kept(), width));
  WholeRows maker(data, r, terms);
  Eigen::MatrixXd rows(n, width);
  for (long k = 0; k < r.kept(); ++k) {
    maker.fill(r, r.full_row(k), &rows);
    for (long j = 0; j < n; ++j) out[static_cast<size_t>(j)].row(k) = rows.row(j);
  }
  return out;
}

EffectId get_effect_id(TermKind kind) { return get_term_row(kind).effect; }

std::string get_effect_name(TermKind kind) { return get_effect(get_effect_id(kind)).name; }

EffectFamily get_family(TermKind kind) { return get_effect(get_effect_id(kind)).family; }

}  // namespace hrp::diagnosis
