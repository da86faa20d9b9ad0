// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/soft_gears.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/low_pass.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/gram.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/estimate/slopes.h"
#include "diagnosis/measurement/kept_rows.h"
#include "diagnosis/measurement/load_or_unit.h"
#include "diagnosis/measurement/torque/load.h"
#include "diagnosis/simulation/bodies.h"

namespace hrp::diagnosis {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr long kOfMotor = 4;             // first columns of make_drive_columns: on the motor's side of the gear
constexpr long kUnknown = 1 + kOfMotor;  // the give, then the motor's coefficients

// One recording at the kept samples.
struct Piece {
  const TorqueRecording* recording = nullptr;
  Plant plant;                 // nominal, with what hangs on it in this recording
  JointsMotion motion;         // as now believed, full grid
  Matrix rigid;                // tau of the motion with this gear rigid, kept x joint
  std::vector<Matrix> drives;  // by joint: columns beside the bodies, kept samples
  Matrix left;                 // effort - tau - stated friction, kept x joint
};

Matrix calc_tau(const Piece& p, const JointsMotion& m) {
  return calc_efforts(p.plant, keep_rows(*p.recording, m.q), keep_rows(*p.recording, m.v),
                      keep_rows(*p.recording, m.a));
}

// Torque on the gear of a joint by the effort of its drive [N m], full grid.
Vector calc_gear_torque(const TorqueData& data, const TorqueRecording& r, const SoftGear& gear) {
  return r.effort.col(gear.joint) - make_drive_columns(data, r, gear.joint).leftCols(kOfMotor) * gear.motor;
}

// Moves the link of a joint back by `angle` [rad], full grid.
void twist(const TorqueRecording& r, int j, const Vector& angle, JointsMotion* links) {
  const Vector rate = differentiate(angle, r.step);
  links->q.col(j) -= angle;
  links->v.col(j) -= rate;
  links->a.col(j) -= differentiate(rate, r.step);
}

class Search {
 public:
  explicit Search(const TorqueData& data) : data_(data), n_(static_cast<int>(data.source.size())) {
    const Plant plant = make_plant(*data.experiment, {});
    for (const TorqueRecording& r : data.recordings) {
      if (!r.train || r.kept() == 0) continue;
      Piece p{&r,
              add_by_hand(plant, data.experiment->recordings[r.index].spec),
              {r.get_link_q(), r.get_link_v(), r.get_link_a()},
              {},
              {},
              r.missing};
      p.rigid = calc_tau(p, p.motion);
      for (int j = 0; j < n_; ++j) p.drives.push_back(keep_rows(r, make_drive_columns(data, r, j)));
      rigid_.push_back(std::move(p));
    }
  }

  std::optional<SoftGear> run() {
    std::vector<SoftGear> starts;
    for (int j = 0; j < n_; ++j) {
      if (!may_give(j)) continue;
      weigh(j);
      const std::optional<SoftGear> gear = start(j);
      if (gear && gear->left < 1.0 - kMinor) starts.push_back(*gear);
    }
    std::stable_sort(starts.begin(), starts.end(),
                     [](const SoftGear& a, const SoftGear& b) { return a.left < b.left; });
    std::optional<SoftGear> best;
    for (size_t i = 0; i < std::min(starts.size(), kLookedAt); ++i) {
      weigh(starts[i].joint);
      const std::optional<SoftGear> gear = refine(starts[i]);
      if (gear && gear->left < 1.0 - kMinor && (!best || gear->left < best->left)) best = gear;
    }
    return best;
  }

 private:
  // While the drive of the gear sticks, its friction and so the twist are unknown, and with it the links' motion.
  bool is_used(const Piece& p, long k, int joint, int soft) const {
    return data_.is_judged(joint) && p.recording->use(k, joint) && p.recording->use(k, soft);
  }

  bool may_give(int j) const {
    const auto is_here = [&](const SoftGear& g) { return g.joint == j; };
    return data_.is_judged(j) && data_.experiment->robot.tree.joint(j).actuated && !rigid_.empty() &&
           std::none_of(data_.soft.begin(), data_.soft.end(), is_here);
  }

  // What is left by rigid gears, where that of joint `soft` may give.
  void weigh(int soft) {
    squares_.clear();
    for (int j = 0; j < n_; ++j) squares_.push_back(data_.is_judged(j) ? sum_left(j, soft) : 0.0);
  }

  // All rows of one joint that are used, stacked: the drive's columns, other columns and what is left.
  struct Stack {
    Matrix drive, columns;
    Vector left;
    std::vector<int> stretch;
  };

  Stack stack(const std::vector<Piece>& pieces, const std::vector<std::vector<Matrix>>& columns, int joint,
              int soft) const {
    long rows = 0;
    for (const Piece& p : pieces) {
      for (long k = 0; k < p.recording->kept(); ++k) rows += is_used(p, k, joint, soft) ? 1 : 0;
    }
    const long width = columns.empty() ? 0 : columns[0][static_cast<size_t>(joint)].cols();
    Stack s{Matrix(rows, pieces[0].drives[static_cast<size_t>(joint)].cols()), Matrix(rows, width), Vector(rows), {}};
    long at = 0;
    for (size_t i = 0; i < pieces.size(); ++i) {
      const Piece& p = pieces[i];
      for (long k = 0; k < p.recording->kept(); ++k) {
        if (!is_used(p, k, joint, soft)) continue;
        s.drive.row(at) = p.drives[static_cast<size_t>(joint)].row(k);
        s.left[at] = p.left(k, joint);
        if (width > 0) s.columns.row(at) = columns[i][static_cast<size_t>(joint)].row(k);
        s.stretch.push_back(static_cast<int>(static_cast<long>(i) * kStretches + kStretches * k / p.recording->kept()));
        ++at;
      }
    }
    return s;
  }

  double sum_left(int joint, int soft) const {
    const Stack s = stack(rigid_, {}, joint, soft);
    return s.left.size() > 0 ? take_out(s.drive, s.left).squaredNorm() : 0.0;
  }

  // d tau / d twist x series: by joint, kept samples, for a twist of joint j that follows `series` [full grid].
  Matrix calc_slope(const Piece& p, int j, const Vector& series) const {
    const double size = std::max(1e-300, series.cwiseAbs().maxCoeff()), scale = kRelativeStep / size;
    JointsMotion ahead = p.motion, behind = p.motion;
    twist(*p.recording, j, -scale * series, &ahead);
    twist(*p.recording, j, scale * series, &behind);
    return (calc_tau(p, ahead) - calc_tau(p, behind)) / (2.0 * scale);
  }

  // Sums over all joints' rows, each joint weighted by what is left there, after its drive's columns were taken out.
  std::vector<Gram> gather(const std::vector<Piece>& pieces, const std::vector<std::vector<Matrix>>& columns, int j,
                           bool with_motor) const {
    const long width = columns[0][0].cols();
    std::vector<Gram> parts(pieces.size() * static_cast<size_t>(kStretches), Gram(width));
    for (int i = 0; i < n_; ++i) {
      if (!(squares_[static_cast<size_t>(i)] > 0.0)) continue;
      const Stack s = stack(pieces, columns, i, j);
      const Matrix own = i == j && with_motor ? Matrix(s.drive.rightCols(s.drive.cols() - kOfMotor)) : s.drive;
      const Matrix x = take_out(own, s.columns);
      const Vector y = take_out(own, s.left);
      const double weight =
          std::sqrt(static_cast<double>(y.size()) / std::max(1e-300, squares_[static_cast<size_t>(i)]));
      for (long k = 0; k < y.size(); ++k)
        parts[static_cast<size_t>(s.stretch[static_cast<size_t>(k)])].add_row(weight * x.row(k).transpose(),
                                                                              weight * y[k]);
    }
    return parts;
  }

  // Linear in 1/k and J/k: a gear that twists as the effort, less a rotor's share.
  std::optional<SoftGear> start(int j) const {
    if (!(squares_[static_cast<size_t>(j)] > 0.0)) return std::nullopt;
    std::vector<std::vector<Matrix>> columns;
    for (const Piece& p : rigid_) {
      const Matrix of_effort = calc_slope(p, j, p.recording->effort.col(j)),
                   of_rotor = calc_slope(p, j, p.recording->a.col(j));
      columns.emplace_back();
      for (int i = 0; i < n_; ++i) {
        Matrix c(p.recording->kept(), 2);
        c << -of_effort.col(i), of_rotor.col(i);
        columns.back().push_back(c);
      }
    }
    const Gram total = sum(gather(rigid_, columns, j, false), 2);
    const Vector x = solve(total, {0, 1});
    if (!(x[0] > 0.0)) return std::nullopt;
    SoftGear gear;
    gear.left = calc_rest(total, {0, 1}, x) / total.c;
    gear.joint = j;
    gear.give = x[0];
    gear.motor = fit_motor(j);
    gear.motor[0] = std::max(0.0, x[1] / x[0]);
    return gear;
  }

  Eigen::Vector4d fit_motor(int j) const {
    const Stack s = stack(rigid_, {}, j, j);
    return Vector(s.drive.completeOrthogonalDecomposition().solve(s.left)).head<kOfMotor>();
  }

  // The pieces with the links moved by this gear.
  std::vector<Piece> move(const SoftGear& gear) const {
    std::vector<Piece> pieces = rigid_;
    for (Piece& p : pieces) {
      twist(*p.recording, gear.joint, gear.give * calc_gear_torque(data_, *p.recording, gear), &p.motion);
      p.left += p.rigid - calc_tau(p, p.motion);
    }
    return pieces;
  }

  double calc_left(const std::vector<Piece>& pieces, int soft) const {
    double left = 0.0, all = 0.0;
    for (int i = 0; i < n_; ++i) {
      if (!(squares_[static_cast<size_t>(i)] > 0.0)) continue;
      const Stack s = stack(pieces, {}, i, soft);
      const double n = static_cast<double>(s.left.size());
      left += n * std::log(take_out(s.drive, s.left).squaredNorm() / squares_[static_cast<size_t>(i)]);
      all += n;
    }
    return std::exp(left / std::max(1.0, all));
  }

  // Gauss-Newton steps in the give and the motor's coefficients. A step that makes it worse is halved up to twice.
  std::optional<SoftGear> refine(SoftGear gear) const {
    std::vector<Piece> pieces = move(gear);
    gear.left = calc_left(pieces, gear.joint);
    for (int step = 0; step < kRounds; ++step) {
      const std::vector<Gram> parts = linearise(pieces, gear);
      Columns all(static_cast<size_t>(kUnknown));
      for (long c = 0; c < kUnknown; ++c) all[static_cast<size_t>(c)] = c;
      const Gram total = sum(parts, kUnknown);
      const Vector x = solve(total, all);
      gear.std = std::sqrt(std::abs(calc_covariance(parts, total, all, x)(0, 0)));
      bool better = false;
      for (double part : {1.0, 0.5, 0.25}) {
        SoftGear next = gear;
        next.give += part * x[0];
        next.motor += part * x.tail<kOfMotor>();
        if (!(next.give > 0.0)) continue;
        std::vector<Piece> at = move(next);
        next.left = calc_left(at, gear.joint);
        if (!(next.left < gear.left)) continue;
        better = true;
        gear = next;
        pieces = std::move(at);
        break;
      }
      if (!better || std::abs(x[0]) < kTrace * gear.give) break;
    }
    if (!(gear.motor[0] >= 0.0)) return std::nullopt;
    // Errors of the effort are in the regressor, too. The regression the other way gives 1 / (1 - left) times the give;
    // the interval holds half of the difference (errors in variables, Frisch's bounds).
    gear.std =
        std::hypot(gear.std, 0.5 * gear.give * gear.left / (1.0 - std::min(gear.left, kNearlyAll)) / kNinetyFive);
    return gear;
  }

  std::vector<Gram> linearise(const std::vector<Piece>& pieces, const SoftGear& gear) const {
    std::vector<std::vector<Matrix>> columns;
    for (const Piece& p : pieces) {
      const Matrix motor = make_drive_columns(data_, *p.recording, gear.joint).leftCols(kOfMotor);
      std::vector<Matrix> slopes{-calc_slope(p, gear.joint, calc_gear_torque(data_, *p.recording, gear))};
      for (long c = 0; c < kOfMotor; ++c) slopes.push_back(calc_slope(p, gear.joint, motor.col(c)) * gear.give);
      columns.emplace_back();
      for (int i = 0; i < n_; ++i) {
        Matrix out(p.recording->kept(), kUnknown);
        for (long c = 0; c < kUnknown; ++c) out.col(c) = slopes[static_cast<size_t>(c)].col(i);
        if (i == gear.joint) out.rightCols(kOfMotor) += p.drives[static_cast<size_t>(i)].leftCols(kOfMotor);
        columns.back().push_back(out);
      }
    }
    std::vector<Piece> beside = pieces;  // less what the motor takes already
    for (size_t i = 0; i < beside.size(); ++i)
      beside[i].left.col(gear.joint) -=
          beside[i].drives[static_cast<size_t>(gear.joint)].leftCols(kOfMotor) * gear.motor;
    return gather(beside, columns, gear.joint, true);
  }

  const TorqueData& data_;
  const int n_;
  std::vector<Piece> rigid_;
  std::vector<double> squares_;  // by joint: [(N m)^2] that the drive's columns leave with rigid gears
};

}  // namespace

TorqueData soften(TorqueData data, const SoftGear& gear) {
  const Plant nominal = make_plant(*data.experiment, {});
  for (TorqueRecording& r : data.recordings) {
    const Plant plant = add_by_hand(nominal, data.experiment->recordings[r.index].spec);
    JointsMotion links{r.get_link_q(), r.get_link_v(), r.get_link_a()};
    const Matrix rigid = calc_efforts(plant, links.q, links.v, links.a);
    twist(r, gear.joint, gear.give * calc_gear_torque(data, r, gear), &links);
    const Matrix more = calc_efforts(plant, links.q, links.v, links.a) - rigid;
    r.link_q = links.q;
    r.link_v = links.v;
    r.link_a = links.a;
    r.tau += more;
    r.load += more;
    r.missing -= keep_rows(r, more);
    for (long j = 0; j < r.use.cols(); ++j) r.use.col(j) = r.use.col(j) && r.use.col(gear.joint);
  }
  data.soft.push_back(gear);
  data.soft.back().applied = true;
  return data;
}

std::optional<SoftGear> find_soft_gear(const TorqueData& data) {
  if (data.experiment->scenario.floating_base || data.behind_gears || !data.feet.empty()) return std::nullopt;
  return Search(data).run();
}

}  // namespace hrp::diagnosis
