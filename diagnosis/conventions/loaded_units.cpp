// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/loaded_units.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/gram.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/measurement/load_or_unit.h"
#include "diagnosis/measurement/torque/terms.h"

namespace hrp::diagnosis {
namespace {

constexpr double kJackknife = (kFolds - 1.0) / kFolds;
constexpr double kHand = 0.1;             // [m] a load nearer to the link's origin has no moment to speak of
constexpr long kSeen = kLoadColumns + 2;  // columns of y, tau, load
using Seen = Eigen::Matrix<double, kSeen, kSeen>;
using Load = Eigen::Matrix<double, kLoadColumns, 1>;

bool is_spring(const Term& term) { return term.row->constant > 0; }

// Friction, rotor, constant and spring: columns that need no unit. Of laws with a shape, the middle one.
std::vector<Term> list_beside(const TorqueData& data, int joint) {
  std::vector<Term> list, scanned;
  for (const Term& term : list_joint_terms(data, joint)) {
    const TermRow& row = *term.row;
    if (row.excess)
      scanned.push_back(term);
    else if (is_spring(term) || (row.of_motor_and_gear && !row.backwards))
      list.push_back(term);
  }
  if (!scanned.empty()) list.push_back(scanned[scanned.size() / 2]);
  std::stable_partition(list.begin(), list.end(), [](const Term& t) { return !is_spring(t); });
  return list;  // a spring, which has the constant, comes last
}

// Training samples of one joint: friction, rotor and constant, the spring's angle, y, tau, loads of all links.
struct Rows {
  Eigen::MatrixXd X;
  long beside = 0;  // columns of friction, rotor and constant
};

Rows collect(const TorqueData& data, int joint, const Eigen::MatrixXd& loads) {
  const std::vector<Term> terms = list_beside(data, joint);
  const UnitRows efforts = collect_efforts(data, joint);
  long width = 0;
  for (const Term& t : terms) width += t.columns();
  const bool spring = !terms.empty() && is_spring(terms.back());
  Rows rows{Eigen::MatrixXd(efforts.tau.size(), width + (spring ? 0 : 2) + 2 + loads.cols()),
            width + (spring ? -1 : 1)};
  long at = 0;
  for (const TorqueRecording& r : data.recordings) {
    if (!r.train) continue;
    Eigen::MatrixXd own(r.kept(), width);
    long column = 0;
    for (const Term& t : terms) {
      own.middleCols(column, t.columns()) = calc_joint_columns(data, r, t);
      column += t.columns();
    }
    for (long k = 0; k < r.kept(); ++k) {
      if (r.use(k, joint)) rows.X.row(at++).head(width) = own.row(k);
    }
  }
  if (!spring) {
    rows.X.col(width).setOnes();
    rows.X.col(width + 1).setZero();
  } else {
    rows.X.col(width - 2).swap(rows.X.col(width - 1));  // k q, constant: the constant is no sign of a spring
  }
  rows.X.rightCols(loads.cols() + 2) << efforts.effort, efforts.tau, loads;
  return rows;
}

// Sums of squares of one joint by stretches of its samples.
struct Sums {
  int joint = 0;
  long beside = 0;
  double samples = 0.0, independent = 0.0;
  std::vector<Eigen::MatrixXd> folds;

  // y, tau and the link's load beside friction and rotor, and spring; without the stretch `out`.
  Seen see(bool spring, long link, int out) const {
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(folds[0].rows(), folds[0].cols());
    for (size_t f = 0; f < folds.size(); ++f) {
      if (static_cast<int>(f) != out) all += folds[f];
    }
    const long n = beside + (spring ? 1 : 0), first = beside + 1;
    const auto pick = [&](long i) { return i < 2 ? first + i : first + 2 + kLoadColumns * link + i - 2; };
    Seen seen;
    Eigen::MatrixXd cross(n, kSeen);
    for (long i = 0; i < kSeen; ++i) {
      cross.col(i) = all.block(0, pick(i), n, 1);
      for (long j = 0; j < kSeen; ++j) seen(i, j) = all(pick(i), pick(j));
    }
    return seen - cross.transpose() * all.topLeftCorner(n, n).completeOrthogonalDecomposition().solve(cross);
  }
};

Sums sum_up(const TorqueData& data, int joint, const Eigen::MatrixXd& loads) {
  const Rows rows = collect(data, joint, loads);
  const long n = rows.X.rows(), width = rows.X.cols();
  Sums out{joint, rows.beside, static_cast<double>(n), 0.0,
           std::vector<Eigen::MatrixXd>(kFolds, Eigen::MatrixXd::Zero(width, width))};
  for (long f = 0; f < kFolds; ++f) {
    const auto part = rows.X.middleRows(f * n / kFolds, (f + 1) * n / kFolds - f * n / kFolds);
    out.folds[static_cast<size_t>(f)] = part.transpose() * part;
  }
  Eigen::MatrixXd known(n, rows.beside + 1 + loads.cols() + 1);
  known << rows.X.leftCols(rows.beside + 1), rows.X.rightCols(loads.cols() + 1);
  const Eigen::VectorXd left = take_out(known, rows.X.col(rows.beside + 1));
  out.independent = static_cast<double>(n) / std::max(kPerPeriod, calc_correlation_time(left));
  return out;
}

// What the joint's best scale of tau + L p leaves of y, and the scale.
struct Profile {
  double left = 0.0, scale = 0.0, share = 0.0;
  double moved = 0.0;  // sum of squares of tau + L p
};

Profile profile(const Seen& s, const Load& p) {
  Eigen::Matrix<double, kSeen - 1, 1> u;
  u << 1.0, p;
  const double xx = u.dot(s.bottomRightCorner<kSeen - 1, kSeen - 1>() * u), xy = s.row(0).tail<kSeen - 1>().dot(u);
  const double share = xx > 0.0 && s(0, 0) > 0.0 ? xy * xy / (xx * s(0, 0)) : 0.0;
  return {std::max(1e-300, s(0, 0) * (1.0 - share)), xx > 0.0 ? xy / xx : 0.0, share, std::max(0.0, xx)};
}

// Root mean square of the load's torque, relative to that of all bodies.
double calc_part(const Seen& s, const Load& p) {
  Eigen::Matrix<double, kSeen - 1, 1> u;
  u << 1.0, p;
  const double all = u.dot(s.bottomRightCorner<kSeen - 1, kSeen - 1>() * u),
               load = p.dot(s.bottomRightCorner<kLoadColumns, kLoadColumns>() * p);
  return all > 0.0 ? std::sqrt(std::max(0.0, load) / all) : 1.0;
}

class Fit {
 public:
  Fit(const std::vector<Sums>& sums, const std::vector<char>& springs, long link, int out = -1) : sums_(sums) {
    for (size_t i = 0; i < sums.size(); ++i) seen_.push_back(sums[i].see(springs[i], link, out));
  }

  // [nats] what is left, up to a constant.
  double calc(const Load& p) const {
    double nats = 0.0;
    for (size_t i = 0; i < seen_.size(); ++i) nats += 0.5 * sums_[i].independent * std::log(profile(seen_[i], p).left);
    return nats;
  }

  // The load that leaves least, from `p` on. Ten steps are enough but for loads that are hardly told.
  Load minimize(Load p) const {
    double best = calc(p);
    for (int step = 0; step < kMostRounds; ++step) {
      const Load move = find_step(p);
      double factor = 1.0;
      while (factor > 1e-3 && calc(p + factor * move) > best) factor *= 0.5;
      const double next = calc(p + factor * move);
      if (!(next < best)) break;
      p += factor * move;
      best = next;
    }
    return p;
  }

  const Seen& get(size_t i) const { return seen_[i]; }

 private:
  // Gauss-Newton: each joint's scale is taken out of its equations.
  Load find_step(const Load& p) const {
    Eigen::Matrix<double, kLoadColumns, kLoadColumns> A = Eigen::Matrix<double, kLoadColumns, kLoadColumns>::Zero();
    Load b = Load::Zero();
    for (size_t i = 0; i < seen_.size(); ++i) {
      const Seen& s = seen_[i];
      const Profile at = profile(s, p);
      Eigen::Matrix<double, kSeen - 1, 1> u;
      u << 1.0, p;
      const Eigen::Matrix<double, kSeen - 1, 1> xu = s.bottomRightCorner<kSeen - 1, kSeen - 1>() * u;
      const double xx = std::max(1e-300, u.dot(xu)), weight = sums_[i].independent / at.left;
      const Load lu = xu.tail<kLoadColumns>();
      const Load ly = s.col(0).tail<kLoadColumns>() - at.scale * lu;
      A +=
          weight * at.scale * at.scale * (s.bottomRightCorner<kLoadColumns, kLoadColumns>() - lu * lu.transpose() / xx);
      b += weight * at.scale * ly;
    }
    return A.completeOrthogonalDecomposition().solve(b);
  }

  const std::vector<Sums>& sums_;
  std::vector<Seen> seen_;
};

// The load of one link and the springs beside it.
struct Choice {
  long link = -1;  // in the list of loads; -1: none
  Load p = Load::Zero();
  double nats = 0.0;
  std::vector<char> springs;
};

class Search {
 public:
  Search(const TorqueData& data, const std::vector<int>& joints) : data_(data) {
    std::vector<Term> loads;
    for (size_t link = 1; link < data.experiment->robot.tree.links.size(); ++link)
      loads.push_back({&find_term_row(&TermRow::load), static_cast<int>(link)});
    const std::vector<Eigen::MatrixXd> columns = collect_loads(data, joints, loads);
    for (size_t i = 0; i < joints.size(); ++i) sums_.push_back(sum_up(data, joints[i], columns[i]));
    for (const Term& load : loads) links_.push_back(load.place);
  }

  LoadedUnits run() const {
    const Choice none = choose_springs(-1), best = choose_link(none);
    LoadedUnits out;
    out.by_load = none.nats - best.nats;
    const bool springs = std::any_of(best.springs.begin(), best.springs.end(), [](char s) { return s != 0; });
    if (best.link < 0 && !springs) return out;
    if (best.link >= 0) {
      out.link = links_[static_cast<size_t>(best.link)];
      out.mass = best.p[0];
    }
    fill(best, &out);
    return out;
  }

 private:
  Choice fit(long link, const std::vector<char>& springs) const {
    const Fit fit(sums_, springs, std::max(0L, link));
    Choice out{link, Load::Zero(), 0.0, springs};
    if (link >= 0) out.p = fit.minimize(out.p);
    out.nats = fit.calc(out.p) + spring_cost_ * static_cast<double>(std::count(springs.begin(), springs.end(), 1));
    return out;
  }

  // Springs where the efforts ask for them: all at first, as a missing one moves the load.
  Choice choose_springs(long link) const {
    Choice best = fit(link, std::vector<char>(sums_.size(), 1));
    for (bool changed = true; changed;) {
      changed = false;
      for (size_t i = 0; i < sums_.size(); ++i) {
        std::vector<char> springs = best.springs;
        if (!springs[i]) continue;
        springs[i] = 0;
        const Choice without = fit(link, springs);
        if (without.nats < best.nats + kOdds) {
          best = without;
          changed = true;
        }
      }
    }
    return best;
  }

  Choice choose_link(const Choice& none) const {
    Choice best = none;
    const double most = find_moving_mass(data_.experiment->robot.tree);
    for (size_t link = 0; link < links_.size(); ++link) {
      Choice with = choose_springs(static_cast<long>(link));
      with.nats += find_term_row(&TermRow::load).cost;
      const double own = data_.experiment->robot.tree.links[static_cast<size_t>(links_[link])].inertia.mass;
      if (with.p[0] < -own || with.p[0] > most || with.nats + kOdds > none.nats) continue;
      if (best.link < 0 || with.nats < best.nats) best = with;
    }
    return best;
  }

  // Values with deviations by the jackknife, one stretch left out at a time, and by what springs everywhere would
  // change: the jackknife does not see what is wrong in all stretches alike.
  void fill(const Choice& c, LoadedUnits* out) const {
    const long link = std::max(0L, c.link);
    const Fit all(sums_, c.springs, link);
    const Choice free = fit(c.link, std::vector<char>(sums_.size(), 1));
    const Fit freely(sums_, free.springs, link);
    std::vector<Fit> parts;
    std::vector<Load> loads;
    Load squares = (free.p - c.p).cwiseAbs2();
    for (int f = 0; f < kFolds; ++f) {
      parts.emplace_back(sums_, c.springs, link, f);
      loads.push_back(c.link >= 0 ? parts.back().minimize(c.p) : c.p);
      squares += kJackknife * (loads.back() - c.p).cwiseAbs2();
    }
    if (c.link >= 0) out->blur = calc_blur(c.p, squares);
    for (size_t i = 0; i < sums_.size(); ++i) {
      const Profile at = profile(all.get(i), c.p);
      double square = std::pow(1.0 / profile(freely.get(i), free.p).scale - 1.0 / at.scale, 2);
      for (size_t f = 0; f < parts.size(); ++f)
        square += kJackknife * std::pow(1.0 / profile(parts[f].get(i), loads[f]).scale - 1.0 / at.scale, 2);
      if (c.link >= 0) out->of_torque = std::max(out->of_torque, out->blur * calc_part(all.get(i), c.p));
      LoadedUnit unit{sums_[i].joint, 1.0 / at.scale, std::sqrt(square), at.share,
                      std::sqrt(at.moved / sums_[i].samples)};
      weigh_spring(c, i, &unit);
      out->joints.push_back(unit);
    }
  }

  static double calc_blur(const Load& p, const Load& squares) {
    const double moment = std::max(p.tail<3>().norm(), kHand * std::abs(p[0]));
    return std::max(std::sqrt(squares[0]) / std::abs(p[0]), std::sqrt(squares.tail<3>().sum()) / moment);
  }

  // The evidence of a spring at the joint. Where it leaves a doubt, the unit is that with a spring or that without: the
  // deviation of the two, weighed by their probabilities.
  void weigh_spring(Choice c, size_t i, LoadedUnit* unit) const {
    double nats[2], scale[2];
    for (int spring : {0, 1}) {
      c.springs[i] = static_cast<char>(spring);
      const Choice with = fit(c.link, c.springs);
      nats[spring] = with.nats;
      scale[spring] = 1.0 / profile(sums_[i].see(spring != 0, std::max(0L, c.link), -1), with.p).scale;
    }
    const double p = 1.0 / (1.0 + std::exp(std::clamp(nats[1] - nats[0], -300.0, 300.0)));
    unit->std = std::hypot(unit->std, std::sqrt(p * (1.0 - p)) * (scale[1] - scale[0]));
  }

  const TorqueData& data_;
  std::vector<Sums> sums_;
  std::vector<int> links_;
  const double spring_cost_ = std::find_if(list_term_rows().begin(), list_term_rows().end(), [](const TermRow& r) {
                                return r.constant > 0;
                              })->cost;
};

}  // namespace

LoadedUnits find_loaded_units(const TorqueData& data, const std::vector<int>& joints) {
  return joints.empty() ? LoadedUnits{} : Search(data, joints).run();
}

}  // namespace hrp::diagnosis
