// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/landings.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>

#include "common/multibody/kinematics.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/estimate/slopes.h"
#include "diagnosis/floating/equations/foot_rows.h"
#include "diagnosis/floating/fit/candidates.h"
#include "diagnosis/floating/fit/least_squares.h"
#include "diagnosis/floating/log/correct_log.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr size_t kFewestFlat = 6;                    // samples of a landing that tells anything
constexpr double kLeastLag = 2e-4, kMostLag = 0.05;  // [s] that a fit may reach

// [m] How far a sole sinks whose `mass` rides on its rubber.
std::vector<double> sink(const std::vector<double>& force, double step, double give, double lag, double mass) {
  std::vector<double> z = calc_sinking(force, step, lag, mass * std::max(0.0, give));
  for (double& v : z) v *= give;
  return z;
}

// Columns by give and lag of each foot, at a hypothesis [give, lag] by foot and a share of the feet that rides on the
// rubber; the mean over flat samples is taken out, since how high the ground is under each foot is not known.
struct Rows {
  Eigen::MatrixXd x;
  Eigen::VectorXd left;  // [m] of the height
};

Rows make_rows(const Landing& l, const Eigen::VectorXd& law, double share) {
  std::vector<size_t> at;
  for (size_t k = 0; k < l.flat.size(); ++k) {
    if (l.flat[k]) at.push_back(k);
  }
  const auto n = static_cast<long>(at.size());
  Rows rows{Eigen::MatrixXd::Zero(n, law.size()), Eigen::VectorXd(n)};
  for (long i = 0; i < n; ++i) rows.left(i) = l.height[at[static_cast<size_t>(i)]];
  for (const auto& [foot, force, mass, sign] :
       {std::tuple(l.foot, &l.force, l.mass, -1.0), std::tuple(l.other, &l.others, l.others_mass, 1.0)}) {
    const auto g = static_cast<long>(2 * foot);
    const double give = law(g), lag = law(g + 1), rides = share * mass;
    const double more_give = kRelativeStep * kRigidHeight, more_lag = kRelativeStep * lag;
    const std::vector<double> z = sink(*force, l.step, give, lag, rides);
    const std::vector<double> softer = sink(*force, l.step, give + more_give, lag, rides),
                              later = sink(*force, l.step, give, lag + more_lag, rides);
    for (long i = 0; i < n; ++i) {
      const size_t k = at[static_cast<size_t>(i)];
      rows.x(i, g) = sign * (softer[k] - z[k]) / more_give;
      rows.x(i, g + 1) = sign * (later[k] - z[k]) / more_lag;
      rows.left(i) -= sign * z[k];
    }
  }
  rows.left.array() -= rows.left.mean();
  rows.x.rowwise() -= rows.x.colwise().mean();
  return rows;
}

// Sums of one landing.
struct Sums {
  Eigen::MatrixXd a;
  Eigen::VectorXd b;
  double mean_square = 0;
};

class LandingFitter {
 public:
  // `share`: of the feet below their sensors, that rides on the rubber.
  LandingFitter(const std::vector<Landing>& landings, const std::vector<char>& soft, double share)
      : soft_(soft), share_(share) {
    for (const Landing& l : landings) {
      const auto flat = static_cast<size_t>(std::count(l.flat.begin(), l.flat.end(), 1));
      if (flat >= kFewestFlat && (soft[l.foot] || soft[l.other])) landings_.push_back(l);
    }
    law_ = Eigen::VectorXd::Zero(static_cast<long>(2 * soft.size()));
    for (long f = 0; f < static_cast<long>(soft.size()); ++f) {
      if (soft[static_cast<size_t>(f)]) {
        free_.push_back(2 * f);
        free_.push_back(2 * f + 1);
      }
    }
  }

  std::vector<SoleLaw> run() {
    std::vector<SoleLaw> out(soft_.size());
    if (landings_.size() < kFewestBlocks) return out;
    start();
    for (int round = 0; round < kMostRounds; ++round) step(true);
    const Eigen::MatrixXd covariance = calc_covariance();
    for (size_t i = 0; 2 * i < free_.size(); ++i) {
      const auto at = static_cast<long>(2 * i), foot = free_[2 * i] / 2;
      out[static_cast<size_t>(foot)] = make_law(static_cast<size_t>(foot), covariance.block<2, 2>(at, at));
    }
    return out;
  }

 private:
  Sums sum_up(const Landing& l) const {
    const Rows rows = make_rows(l, law_, share_);
    Eigen::MatrixXd x(rows.x.rows(), static_cast<long>(free_.size()));
    for (size_t c = 0; c < free_.size(); ++c) x.col(static_cast<long>(c)) = rows.x.col(free_[c]);
    return {x.transpose() * x, x.transpose() * rows.left,
            rows.left.squaredNorm() / static_cast<double>(rows.left.size())};
  }

  // Landings that the law explains worse than others, such as those on an edge, weigh less.
  std::vector<Sums> sum_up_weighed() const {
    std::vector<Sums> sums;
    std::vector<double> squares;
    for (const Landing& l : landings_) {
      sums.push_back(sum_up(l));
      squares.push_back(sums.back().mean_square);
    }
    const double usual = std::max(1e-300, find_median(squares));
    for (Sums& s : sums) {
      const double weight = 1 / (usual + s.mean_square);
      s.a *= weight;
      s.b *= weight;
    }
    return sums;
  }

  // One lag for all soles; gives follow linearly.
  void start() {
    double least = 1e300;
    Eigen::VectorXd best = law_;
    for (double lag = kTimeStep; lag < kMostLag; lag *= 2) {
      for (long f = 0; f < law_.size() / 2; ++f) {
        law_(2 * f) = 0;
        law_(2 * f + 1) = lag;
      }
      for (int round = 0; round < kFewRounds; ++round) step(false);
      std::vector<double> squares;
      for (const Landing& l : landings_) squares.push_back(sum_up(l).mean_square);
      if (find_median(squares) < least) {
        least = find_median(squares);
        best = law_;
      }
    }
    law_ = best;
  }

  // Gauss-Newton. Far off, columns are no tangents: in a round, a lag changes by no more than a factor.
  void step(bool lags) {
    const auto n = static_cast<long>(free_.size());
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
    for (const Sums& s : sum_up_weighed()) {
      a += s.a;
      b += s.b;
    }
    for (long c = 1; c < n && !lags; c += 2) {
      a.row(c).setZero();
      a.col(c).setZero();
      b(c) = 0;
    }
    const Eigen::VectorXd scale = (a.diagonal().array() > 0).select(a.diagonal().cwiseSqrt(), 1.0);
    Eigen::MatrixXd even = scale.asDiagonal().inverse() * a * scale.asDiagonal().inverse();
    for (long c = 0; c < n; ++c) even(c, c) = 1;
    const Eigen::VectorXd dx = even.ldlt().solve((b.array() / scale.array()).matrix());
    for (long c = 0; c < n; ++c) {
      double& value = law_(free_[static_cast<size_t>(c)]);
      const double next = value + dx(c) / scale(c);
      value = c % 2 == 0
                  ? next
                  : std::clamp(std::clamp(next, value / kClearlyMore, value * kClearlyMore), kLeastLag, kMostLag);
    }
  }

  // Sandwich over landings.
  Eigen::MatrixXd calc_covariance() const {
    const auto n = static_cast<long>(free_.size());
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n), meat = a;
    for (const Sums& s : sum_up_weighed()) {
      a += s.a;
      meat += s.b * s.b.transpose();
    }
    const auto count = static_cast<double>(landings_.size());
    const Eigen::MatrixXd inverse = a.inverse();
    return inverse * meat * inverse.transpose() * count / std::max(1.0, count - static_cast<double>(n));
  }

  SoleLaw make_law(size_t foot, const Eigen::Matrix2d& covariance) const {
    const double give = law_(static_cast<long>(2 * foot)), lag = law_(static_cast<long>(2 * foot + 1));
    if (!covariance.allFinite() || give < kNoChance * std::sqrt(covariance(0, 0))) return {};
    const Eigen::Vector2d slope(-lag / (give * give), 1 / give);  // of cz = lag / give
    SoleLaw law{1 / give, std::sqrt(covariance(0, 0)) / (give * give), lag / give,
                std::sqrt(slope.dot(covariance * slope)), 0};
    law.landings = static_cast<size_t>(std::count_if(
        landings_.begin(), landings_.end(), [&](const Landing& l) { return l.foot == foot || l.other == foot; }));
    return law;
  }

  std::vector<char> soft_;
  double share_;
  std::vector<Landing> landings_;
  Eigen::VectorXd law_;     // give [m/N] and lag [s] by foot
  std::vector<long> free_;  // of them, those of soft soles
};

std::vector<Landing> take_every_second(std::vector<Landing> landings, size_t first) {
  const auto thin = [first](auto* values) {
    size_t n = 0;
    for (size_t k = first; k < values->size(); k += 2) (*values)[n++] = (*values)[k];
    values->resize(n);
  };
  for (Landing& l : landings) {
    l.step *= 2;
    thin(&l.force);
    thin(&l.others);
    thin(&l.height);
    thin(&l.flat);
  }
  return landings;
}

// Reads the windows of a clip.
class WindowReader {
 public:
  WindowReader(const LeggedLog& log, const Contacts& contacts, size_t clip)
      : log_(log), contacts_(contacts), clip_(clip), c_(log.clips[clip]), motion_(log, log.clips[clip]) {}

  bool has_attitude() const { return motion_.has_attitude(); }

  // Of a spell of a foot on the ground, as long as the other foot stands, too.
  Landing read(const Contact& spell) {
    Landing l;
    l.step = c_.step;
    l.foot = spell.foot;
    l.other = 1 - spell.foot;
    const auto hangs = [&](size_t f) { return log_.sensors[static_cast<size_t>(log_.feet[f].sensor)].hangs; };
    l.mass = hangs(l.foot);
    l.others_mass = hangs(l.other);
    const auto before = static_cast<size_t>(kScrape / c_.step), after = static_cast<size_t>(kLanding / c_.step);
    const size_t end = std::min(spell.begin + after, spell.end);
    for (size_t k = spell.begin - std::min(before, spell.begin); k < end; ++k) add(k, k >= spell.begin, &l);
    return l;
  }

 private:
  // [N] along the foot's axis, and whether the foot is pressed in the middle of its sole, so that this lies flat.
  std::pair<double, bool> read_foot(size_t f, size_t k) const {
    const Foot& foot = log_.feet[f];
    const auto s = static_cast<size_t>(foot.sensor);
    const Vector3d force = get_values(&c_.force[6 * s], k), moment = get_values(&c_.force[6 * s + 3], k);
    const double pressing = (log_.sensors[s].X_LS.R * force).z(),
                 least = kMinor * log_.mass * log_.experiment->scenario.gravity_W.norm();
    const bool middle = presses_inside(foot, move_to_sole(log_.sensors[s], foot, force, moment), pressing);
    return {pressing, contacts_.loaded[clip_][f][k] && pressing > least && middle};
  }

  void add(size_t k, bool down, Landing* l) {
    const auto [force, flat] = read_foot(l->foot, k);
    const auto [others, other_flat] = read_foot(l->other, k);
    l->force.push_back(force);
    l->others.push_back(others);
    l->flat.push_back(down && flat && other_flat);
    l->height.push_back(0);
    if (!l->flat.back()) return;
    motion_.update(k);
    const auto place = [&](size_t f) -> Vector3d {
      return get_pose(motion_.data(), log_.feet[f].link) * log_.feet[f].p_LC;
    };
    l->height.back() = motion_.find_up(k).dot(place(l->foot) - place(l->other));
  }

  const LeggedLog& log_;
  const Contacts& contacts_;
  size_t clip_;
  const Clip& c_;
  BodyMotion motion_;
};

bool can_tell(const LeggedLog& log) {
  return log.tree.floating_base && log.feet.size() == 2 &&
         std::all_of(log.feet.begin(), log.feet.end(), [&](const Foot& f) {
           if (f.sensor < 0 || !f.flat) return false;
           const ForceSensor& s = log.sensors[static_cast<size_t>(f.sensor)];
           return s.has_wrench() && !s.world;
         });
}

}  // namespace

std::vector<double> calc_sinking(const std::vector<double>& force, double step, double lag, double inertia) {
  using Complex = std::complex<double>;
  // Roots of inertia s^2 + lag s + 1; without inertia the second one is at minus infinity.
  const Complex bend = std::sqrt(Complex(lag * lag - 4 * inertia)), slow = -2.0 / (lag + bend);
  const bool rides = inertia > kTrace * kTrace * lag * lag && std::abs(bend) > 0;
  const Complex fast = rides ? -(lag + bend) / (2 * inertia) : Complex(0);
  const Complex slow_keep = std::exp(slow * step), fast_keep = std::exp(fast * step);
  std::vector<double> z = force;
  double rate = 0;
  for (size_t k = 1; k < force.size(); ++k) {
    // Along a line, z = force - slope lag, and what is left of where it began dies away by both roots.
    const double slope = (force[k] - force[k - 1]) / step;
    const Complex begin = z[k - 1] - force[k - 1] + slope * lag, speed = rate - slope;
    const Complex by_fast = rides ? (speed - slow * begin) / (fast - slow) : Complex(0), by_slow = begin - by_fast;
    z[k] = force[k] - slope * lag + (by_slow * slow_keep + by_fast * fast_keep).real();
    rate = slope + (by_slow * slow * slow_keep + by_fast * fast * fast_keep).real();
  }
  return z;
}

// How a force went between two samples is not known. A fit of every second sample bounds the error that this makes: the
// error grows with the square of the step, so that it differs by three times the error of the whole fit. Nor is it
// known how much of a foot rides on its rubber, from none to all: a twelfth of the squared difference is the variance
// of an even draw.
std::vector<SoleLaw> fit_landings(const std::vector<Landing>& landings, const std::vector<char>& soft) {
  std::vector<SoleLaw> laws = LandingFitter(landings, soft, kHalf).run();
  const std::vector<SoleLaw> even = LandingFitter(take_every_second(landings, 0), soft, kHalf).run();
  const std::vector<SoleLaw> odd = LandingFitter(take_every_second(landings, 1), soft, kHalf).run();
  const std::vector<SoleLaw> bare = LandingFitter(landings, soft, 0).run(),
                             whole = LandingFitter(landings, soft, 1).run();
  // [s] between the instants at which sensors of a row are read
  const double stamps = landings.empty() ? 0 : kDetail * landings[0].step;
  for (size_t f = 0; f < laws.size(); ++f) {
    SoleLaw& law = laws[f];
    const auto is_empty = [f](const std::vector<SoleLaw>& l) { return l[f].landings == 0; };
    if (is_empty(even) || is_empty(odd) || is_empty(bare) || is_empty(whole)) law = {};
    if (law.landings == 0) continue;
    const auto widen = [&](double SoleLaw::*value, double least, double* std) {
      const double steps = 0.5 * (0.5 * (even[f].*value + odd[f].*value) - law.*value),
                   rides = (whole[f].*value - bare[f].*value) / std::sqrt(12.0);
      *std = std::hypot(std::hypot(*std, least), std::hypot(steps, rides));
    };
    widen(&SoleLaw::kz, kExactShare * law.kz, &law.kz_std);
    widen(&SoleLaw::cz, stamps * law.kz, &law.cz_std);
  }
  return laws;
}

bool put_law(const SoleLaw& law, std::vector<Estimate>* sole) {
  if (law.landings == 0) return false;
  const auto find = [&](const char* name) {
    return std::find_if(sole->begin(), sole->end(), [&](const Estimate& e) { return e.name == name; });
  };
  const auto kz = find("kz");
  if (kz != sole->end() && std::abs(kz->value[0] - law.kz) > kUnlikely * std::hypot(kz->std[0], law.kz_std))
    return false;
  const bool damped = law.cz > kAboveNoise * law.cz_std;
  sole->erase(std::remove_if(sole->begin(), sole->end(),
                             [&](const Estimate& e) { return e.name == "kz" || (damped && e.name == "cz"); }),
              sole->end());
  sole->push_back(make_one("kz", "N/m", law.kz, law.kz_std));
  if (damped) sole->push_back(make_one("cz", "N s/m", law.cz, law.cz_std));
  return true;
}

std::vector<Landing> list_landings(const LeggedLog& log) {
  std::vector<Landing> out;
  if (!can_tell(log) || log.clips.empty()) return out;
  const Contacts contacts = find_contacts(log);
  for (size_t c = 0; c < log.clips.size(); ++c) {
    WindowReader reader(log, contacts, c);
    if (!reader.has_attitude()) return out;
    for (const Contact& spell : contacts.spells) {
      if (spell.clip == c && spell.loaded && spell.begin > 0) out.push_back(reader.read(spell));
    }
  }
  return out;
}

}  // namespace hrp::diagnosis::floating
