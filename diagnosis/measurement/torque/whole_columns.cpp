// SPDX-License-Identifier: BSD-3-Clause
// Terms of the whole robot, in the rows of every joint.
#include <algorithm>
#include <array>

#include "common/multibody/kinematics.h"
#include "common/multibody/regressor.h"
#include "diagnosis/measurement/torque/term_rows.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/simulation/bodies.h"

namespace hrp::diagnosis {
namespace {

constexpr double kMostAngle = 0.3;                         // [rad] range of a linear term of a zero or a tilt
constexpr double kLeastMass = 0.3, kMostMass = 3.0;        // share of a link's nominal mass
constexpr double kLeastCarried = 0.3, kMostCarried = 1.1;  // share of gravity; less is a wrong mass

const char* const kLook =
    "look whether the log's effort is the whole of the drive's torque, and whether a spring or a counterweight carries "
    "the arm";

using Inertial = Eigen::Matrix<double, kInertialParameters, 1>;
using Block = Eigen::Ref<Eigen::MatrixXd>;  // joint x columns of one term

TreeSpec load(TreeSpec tree, const RecordingSpec& recording) {
  add_loads(recording, &tree);
  return tree;
}

Inertial make_inertial(double mass, const Vector3d& moment, const Matrix3d& I) {
  Inertial all;
  all << mass, moment, I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2);
  return all;
}

// Inertial parameters [m^2] of a unit mass at a point, about the link's frame: moments of inertia only.
Inertial make_point_inertia(const Vector3d& p_L) {
  return make_inertial(0.0, Vector3d::Zero(), p_L.squaredNorm() * Matrix3d::Identity() - p_L * p_L.transpose());
}

// Derivative of the inertial parameters with respect to the centre of mass along an axis.
Inertial move_com(const LinkInertia& inertia, int axis) {
  const double m = inertia.mass;
  const Vector3d c = inertia.p_LLcm_L, e = Vector3d::Unit(axis);
  return make_inertial(0.0, m * e, m * (2.0 * c.dot(e) * Matrix3d::Identity() - c * e.transpose() - e * c.transpose()));
}

TermValues make_scale(const Term&, const Eigen::VectorXd& x, const Eigen::VectorXd& s) {
  return {{1.0 + x[0]}, {s[0]}};
}
Eigen::VectorXd take_scale(const std::vector<double>& p) { return Eigen::VectorXd::Constant(1, p[0] - 1.0); }

TermValues make_share(const Term&, const Eigen::VectorXd& x, const Eigen::VectorXd& s) {
  return {{std::clamp(x[0], 0.0, 1.0)}, {s[0]}};
}

// Parameters m and m p_LP.
TermValues make_payload(const Term&, const Eigen::VectorXd& x, const Eigen::VectorXd& s) {
  const double size = std::max(1e-12, std::abs(x[0]));
  return {{x[0], x[1] / x[0], x[2] / x[0], x[3] / x[0]}, {s[0], s[1] / size, s[2] / size, s[3] / size}};
}
Eigen::VectorXd take_payload(const std::vector<double>& p) {
  return Eigen::Vector4d(p[0], p[0] * p[1], p[0] * p[2], p[0] * p[3]);
}

const std::vector<double> kOne{0.0}, kNone;  // shapes: one term without a shape; no term

std::vector<double> list_own_mass(const TorqueData& data, int link) {
  return data.experiment->robot.tree.links[static_cast<size_t>(link)].inertia.mass > 0.0 ? kOne : kNone;
}

std::vector<double> list_tilt(const TorqueData& data, int) {
  return data.experiment->scenario.gravity_W.norm() > 0.0 ? kOne : kNone;
}

long count_laws(const TorqueData& data) {
  return std::count(data.source.begin(), data.source.end(), EffortSource::kServoLaw);
}

// The servo law gives all of a drive's effort. Only a log may lack the gravity compensation of a controller.
std::vector<double> list_carried(const TorqueData& data, int) {
  return count_laws(data) == 0 && data.feet.empty() ? list_tilt(data, 0) : kNone;
}

std::vector<double> list_bus_delays(const TorqueData& data, int) {
  return count_laws(data) > 1 ? list_delays() : kNone;
}

}  // namespace

// Columns of the whole robot for one sample of a recording.
class WholeColumns {
 public:
  WholeColumns(const TorqueData& data, const TorqueRecording& recording, const std::vector<Term>& terms)
      : data_(data),
        recording_(recording),
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

  void fill(long full_row, Eigen::MatrixXd* rows) {
    row_ = full_row;
    if (!tree_.floating_base) {
      const bool sharp = recording_.is_sharp();
      state_.q = (sharp ? recording_.sharp_q : recording_.get_link_q()).row(row_);
      state_.qd = (sharp ? recording_.sharp_v : recording_.get_link_v()).row(row_);
      a_ = (sharp ? recording_.sharp_a : recording_.get_link_a()).row(row_);
      update_kinematics(model_, state_, &kinematics_);
      calc_regressor(model_, a_, &kinematics_, &regressor_);
    }
    for (bool moving : {false, true}) {  // terms that move the model come last
      long column = 0;
      for (const Term& term : terms_) {
        const auto own = rows->middleCols(column, term.columns());
        const bool known = term.row->late || !tree_.floating_base;
        if (known && term.row->moves_model == moving)
          (this->*term.row->fill_columns)(term, own);
        else if (!known)
          rows->middleCols(column, term.columns()).setZero();
        column += term.columns();
      }
    }
  }

  Eigen::Ref<const Eigen::MatrixXd> get_regressor(int link) const {
    return regressor_.Y_JI.middleCols(static_cast<long>(link) * kInertialParameters, kInertialParameters);
  }

  void fill_late(const Term& t, Block columns) {
    for (long j = 0; j < columns.rows(); ++j) columns(j, 0) = calc_late(recording_, j, row_, t.shape);
  }

  void fill_mass(const Term& t, Block columns) {
    columns.col(0) =
        get_regressor(t.place) * mine_.segment(static_cast<long>(t.place) * kInertialParameters, kInertialParameters);
  }

  void fill_payload(const Term& t, Block columns) {  // column of m contains the inertia at its position; m c
    columns = get_regressor(t.place).leftCols(4);
    columns.col(0) += get_regressor(t.place) * make_point_inertia(data_.load_p_L[static_cast<size_t>(t.place)]);
  }

  void fill_com(const Term& t, Block columns) {  // moment of the link's mass, and inertia to first order
    const LinkInertia& inertia = tree_.links[static_cast<size_t>(t.place)].inertia;
    for (int axis = 0; axis < 3; ++axis) columns.col(axis) = get_regressor(t.place) * move_com(inertia, axis);
  }

  void fill_force(const Term& t, Block columns) {
    const Vector3d p_W = get_pose(kinematics_, t.place) * tree_.links[static_cast<size_t>(t.place)].inertia.p_LLcm_L;
    Eigen::MatrixXd J(6, model_.num_joints());
    calc_point_jacobian(model_, kinematics_, t.place, p_W, J);
    columns = -J.bottomRows(3).transpose();
  }

  // True position = reading - offset: missing = tau(q - offset) - tau(q).
  void fill_offset(const Term& t, Block columns) {
    const double q = state_.q[t.place];
    const auto calc_at = [&](double angle) -> Eigen::VectorXd {
      state_.q[t.place] = angle;
      update_kinematics(model_, state_, &kinematics_);
      const LinkWrenches wrenches = calc_wrenches(pulls_, model_, kinematics_);
      calc_inverse_dynamics(model_, a_, &wrenches, &kinematics_, &tau_);
      if (data_.feet.empty()) return tau_;
      return tau_ - calc_load_torques(model_, kinematics_, data_.feet, recording_.foot_wrench.row(row_));
    };
    columns.col(0) = (calc_at(q - kAngleStep) - calc_at(q + kAngleStep)) / (2.0 * kAngleStep);
    state_.q[t.place] = q;
  }

  // Model on a base that is rotated by +- kAngleStep about x (roll) or y (pitch).
  Model turn(int axis, double sign) const {
    const Vector3d gravity_B =
        Eigen::AngleAxisd(-sign * kAngleStep, Vector3d::Unit(axis)) * data_.experiment->scenario.gravity_W;
    return Model(loaded_, gravity_B);
  }

  void fill_tilt(const Term&, Block columns) {
    for (size_t axis = 0; axis < 2; ++axis)  // central: a one-sided step changes gravity's size, like a weight
      columns.col(static_cast<long>(axis)) =
          (calc_under(turned_[2 * axis]) - calc_under(turned_[2 * axis + 1])) / (2.0 * kAngleStep);
  }

  void fill_carried(const Term&, Block columns) { columns.col(0) = calc_under(weightless_) - calc_under(model_); }

  // Inverse dynamics of this sample's motion with another gravity.
  Eigen::VectorXd calc_under(const Model& model) {
    update_kinematics(model, state_, &kinematics_);
    calc_inverse_dynamics(model, a_, nullptr, &kinematics_, &tau_);
    return tau_;
  }

 private:
  const TorqueData& data_;
  const TorqueRecording& recording_;
  const std::vector<Term>& terms_;
  const TreeSpec& tree_;
  const TreeSpec loaded_;  // with the loads of this recording
  const std::vector<SteadyForce> pulls_;
  const Model model_;
  Data kinematics_;
  State state_;
  Regressor regressor_;
  const std::array<Model, 4> turned_;
  const Model weightless_;
  const Eigen::VectorXd mine_;
  Eigen::VectorXd tau_, a_;
  long row_ = 0;
};

// The prior cost of a term includes its number of parameters.
// The equation of a joint without a drive is homogeneous: a link without mass and weight would explain any motion.
// Terms that take mass or weight away need the torque of a drive beside which they are measured.
std::vector<TermRow> make_whole_rows() {
  using T = TermRow;
  using At = WholeColumns;
  return {Row("payload", 9.0, kPostures)
              .in_all_rows(PlaceKind::kLink, 4, &At::fill_payload)
              .parameters(&make_payload, &take_payload)
              .is(&T::load),
          Row("mass_error", 4.0, kPostures)
              .in_all_rows(PlaceKind::kLink, 1, &At::fill_mass)
              .parameters(&make_scale, &take_scale)
              .within(kLeastMass - 1.0, kMostMass - 1.0)
              .shapes(&list_own_mass)
              .worth_saying_from(kMaterialFactor)
              .is(&T::factor)
              .is(&T::needs_drive),
          Row("com_error", 7.0, kPostures)
              .in_all_rows(PlaceKind::kLink, 3, &At::fill_com)
              .shapes(&list_own_mass)
              .is(&T::within_reach)
              .is(&T::needs_drive),
          Row("external_force", 7.0, kPostures)
              .in_all_rows(PlaceKind::kLink, 3, &At::fill_force)
              .is(&T::needs_drive)
              .is(&T::pulls),
          Row("joint_offset", 4.0, kSweeps)
              .in_all_rows(PlaceKind::kJoint, 1, &At::fill_offset)
              .small_angle(kMostAngle)
              .is(&T::moves_model),
          Row("base_tilt", 5.0, kPostures)
              .in_all_rows(PlaceKind::kNone, 2, &At::fill_tilt)
              .shapes(&list_tilt)
              .small_angle(kMostAngle)
              .is(&T::moves_model),
          Row("gravity_compensation", 5.0, kLook)
              .in_all_rows(PlaceKind::kNone, 1, &At::fill_carried)
              .parameters(&make_share, nullptr)
              .within(kLeastCarried, kMostCarried)
              .shapes(&list_carried)
              .is(&T::moves_model)
              .is(&T::needs_drive),
          Row("command_delay", 4.0, kReversals)
              .in_all_rows(PlaceKind::kJoint, 1, &At::fill_late)
              .shapes(&list_bus_delays)
              .within(0.0, kLongest)
              .is(&T::late)};
}

// Kept samples of columns along the sharp motion, filtered like the efforts. Late commands are filtered already.
Eigen::MatrixXd condition_columns(const TorqueData& data, const TorqueRecording& r, const std::vector<Term>& terms,
                                  const Eigen::MatrixXd& full) {
  Eigen::MatrixXd kept(r.kept(), full.cols());
  long column = 0;
  for (const Term& term : terms) {
    for (int c = 0; c < term.columns(); ++c, ++column) {
      for (long k = 0; term.row->late && k < r.kept(); ++k) kept(k, column) = full(r.full_row(k), column);
      if (!term.row->late) kept.col(column) = data.condition(r, full.col(column));
    }
  }
  return kept;
}

std::vector<Eigen::MatrixXd> calc_whole_columns(const TorqueData& data, const TorqueRecording& r,
                                                const std::vector<Term>& terms) {
  long width = 0;
  for (const Term& term : terms) width += term.columns();
  const long n = r.q.cols(), count = r.is_sharp() ? r.q.rows() : r.kept();
  if (width == 0) return std::vector<Eigen::MatrixXd>(static_cast<size_t>(n), Eigen::MatrixXd(r.kept(), 0));
  std::vector<Eigen::MatrixXd> out(static_cast<size_t>(n), Eigen::MatrixXd(count, width));
  WholeColumns maker(data, r, terms);
  Eigen::MatrixXd rows(n, width);
  for (long k = 0; k < count; ++k) {
    maker.fill(r.is_sharp() ? k : r.full_row(k), &rows);
    for (long j = 0; j < n; ++j) out[static_cast<size_t>(j)].row(k) = rows.row(j);
  }
  for (Eigen::MatrixXd& columns : out) {
    if (r.is_sharp()) columns = condition_columns(data, r, terms, columns);
  }
  return out;
}

}  // namespace hrp::diagnosis
