// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/checks.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "common/multibody/kinematics.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/checks/imu_checks.h"
#include "diagnosis/floating/checks/landing_check.h"
#include "diagnosis/floating/checks/leg_zeros.h"
#include "diagnosis/floating/checks/sole_check.h"
#include "diagnosis/floating/checks/weight_check.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/log/body_motion.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kWay = 0.3;       // [m] that a foot must have gone from its middle to tell a slope
constexpr double kRaised = 0.002;  // [m] by which an edge may lift a foot that lies flat: soles are no flatter

class Checker {
 public:
  Checker(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels,
          const ColumnLayout& layout)
      : log_(log), contacts_(contacts), channels_(channels), at_(layout) {}

  CheckResult run() {
    check_weight(log_, contacts_, channels_, at_, &out_);
    check_landings(log_, contacts_, channels_, &out_);
    check_imus(log_, contacts_, channels_, at_, &out_);
    std::vector<std::string> recordings;
    for (const Recording& r : log_.experiment->recordings) recordings.push_back(r.spec.name);
    check_soles(channels_, recordings, &out_);
    check_leg_zeros(log_, channels_, at_, &out_);
    if (log_.base_pose) check_heights();
    check_slip();
    return std::move(out_);
  }

 private:
  // Where feet stand, by the base's pose: a level floor has one height.
  void check_heights() {
    std::vector<Stand> at;
    for (const Contact& spell : contacts_.spells) {
      const Clip& clip = log_.clips[spell.clip];
      if (!spell.loaded || static_cast<double>(spell.end - spell.begin) * clip.step < 0.3 ||
          spell.end > find_fall(clip))
        continue;
      BodyMotion motion(log_, clip);
      const size_t k = (spell.begin + spell.end) / 2;
      if (k < clip.edge || k + clip.edge >= clip.size()) continue;
      motion.update(k);
      const Foot& foot = log_.feet[spell.foot];
      Vector3d p;
      for (int i = 0; i < 3; ++i) p(i) = clip.base_position[i].value[k];
      const Eigen::Quaterniond q(clip.base_attitude[0].value[k], clip.base_attitude[1].value[k],
                                 clip.base_attitude[2].value[k], clip.base_attitude[3].value[k]);
      const Transform X = get_pose(motion.data(), foot.link);
      const Vector3d normal = (q.normalized() * X.R).row(2).transpose();
      at.push_back({p + q.normalized() * (X * foot.p_LC), normal.head<2>().cwiseProduct(0.5 * foot.size.head<2>()),
                    spell.foot, clip.recording});
    }
    drop_raised(&at);
    if (at.size() < 6) return;
    const Plane all = fit_plane(at);
    // Each recording that walks some way has it.
    for (size_t r = 0; r < log_.experiment->recordings.size(); ++r) {
      std::vector<Stand> own;
      for (const Stand& s : at) {
        if (s.recording == r) own.push_back(s);
      }
      if (own.size() < 4) continue;
      const Plane one = fit_plane(own);
      if (one.way > kWay && one.slope.dot(all.slope) < 0.5 * all.slope.squaredNorm()) return;
    }
    add_heights(all);
  }

  // The sample from which a robot falls: some time before its base leans by 26 degrees. At the end of the clip: it does
  // not.
  static size_t find_fall(const Clip& clip) {
    for (size_t k = 0; k < clip.size(); ++k) {
      const Eigen::Quaterniond q(clip.base_attitude[0].value[k], clip.base_attitude[1].value[k],
                                 clip.base_attitude[2].value[k], clip.base_attitude[3].value[k]);
      const double upright = (q.normalized() * Vector3d::UnitZ()).z();
      const auto before = static_cast<size_t>(std::lround(kStepTakes / clip.step));
      if (upright < kNearlyAll) return k > before ? k - before : 0;
    }
    return clip.size();
  }

  // A foot that stands: where its sole is [m], and how far its edges rise over its middle [m].
  struct Stand {
    Vector3d at;
    Eigen::Vector2d rise;
    size_t foot = 0, recording = 0;
  };

  // Leaves out feet that stand on their edge: those that lean otherwise than the same foot mostly does. A slope leans
  // them, too, but then their tilt tells it.
  static void drop_raised(std::vector<Stand>* stands) {
    std::map<size_t, Eigen::Vector2d> usual;
    for (int axis = 0; axis < 2; ++axis) {
      std::map<size_t, std::vector<double>> each;
      for (const Stand& s : *stands) each[s.foot].push_back(s.rise(axis));
      for (const auto& [foot, v] : each) usual[foot](axis) = find_median(v);
    }
    stands->erase(std::remove_if(stands->begin(), stands->end(),
                                 [&](const Stand& s) { return (s.rise - usual[s.foot]).cwiseAbs().sum() > kRaised; }),
                  stands->end());
  }

  // A plane through points, beside a height of each foot's own (encoders' zeros): its rise by x and y with errors, and
  // how far a foot went up or down the rise from where it was on average [m], and from its first to its last place [m].
  struct Plane {
    Vector3d slope, error;
    double way = 0, range = 0;
  };

  static Plane fit_plane(const std::vector<Stand>& at) {
    std::map<size_t, std::pair<Vector3d, double>> sums;  // by foot
    for (const Stand& s : at) {
      auto& [sum, count] = sums.try_emplace(s.foot, Vector3d::Zero(), 0.0).first->second;
      sum += s.at;
      count += 1;
    }
    std::vector<Vector3d> own;
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (const Stand& s : at) {
      own.push_back(s.at - sums[s.foot].first / sums[s.foot].second);
      scatter += own.back().head<2>() * own.back().head<2>().transpose();
    }
    // The ways that were walked, each for itself: across a way nothing is told.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> ways(scatter);
    Plane out{Vector3d::Zero(), Vector3d::Zero(), 0, 0};
    for (long i = 0; i < 2; ++i) {
      const Eigen::Vector2d way = ways.eigenvectors().col(i);
      double far = 0, rise = 0, left = 0;
      for (const Vector3d& d : own) {
        far = std::max(far, std::abs(way.dot(d.head<2>())));
        rise += way.dot(d.head<2>()) * d.z();
      }
      if (far < kWay) continue;
      rise /= ways.eigenvalues()(i);
      for (const Vector3d& d : own) left += std::pow(d.z() - rise * way.dot(d.head<2>()), 2);
      const double freedom = std::max(1.0, static_cast<double>(at.size()) - static_cast<double>(sums.size()) - 1);
      out.slope.head<2>() += rise * way, out.way = std::max(out.way, far);
      out.range = std::max(out.range, find_range(at, way));
      out.error.head<2>() += std::sqrt(left / freedom / ways.eigenvalues()(i)) * way.cwiseAbs();
    }
    return out;
  }

  // [m] How far one foot's places lie apart along a way.
  static double find_range(const std::vector<Stand>& at, const Eigen::Vector2d& way) {
    std::map<size_t, std::pair<double, double>> ends;  // by foot
    for (const Stand& s : at) {
      const double x = way.dot(s.at.head<2>());
      auto& [least, most] = ends.try_emplace(s.foot, x, x).first->second;
      least = std::min(least, x);
      most = std::max(most, x);
    }
    double out = 0;
    for (const auto& [foot, e] : ends) out = std::max(out, e.second - e.first);
    return out;
  }

  void add_heights(const Plane& plane) {
    const auto& [slope, error, way, range] = plane;
    const Vector3d& x = slope;
    const bool sure = std::abs(x(0)) > 3 * error.x() || std::abs(x(1)) > 3 * error.y();
    if (way < kWay || !sure || slope.norm() * way < 1e-3) return;
    Finding f = make_finding(
        get_laws().ground_slope.info(), {{"ground", "ground"}},
        {make_one("roll", "rad", std::atan(x(1)), error.y()), make_one("pitch", "rad", -std::atan(x(0)), error.x())});
    f.grade = Grade::kAmbiguous;
    f.probability = 0.8;
    f.share = 0.5;
    f.weight = 0.1;
    f.statement = format(
        "Feet that stand drift in height by %.1f mm over %.2f m in the base's recorded pose: the capture drifts or is "
        "tilted, or the ground is.",
        1e3 * slope.norm() * range, range);
    const Estimate tilt = make_one("tilt", "rad", slope.norm(), std::max(error.x(), error.y()));
    f.alternatives.push_back(make_alternative(get_laws().sensor_misalignment.info(), {{"sensor", "/base/pose"}}, {tilt},
                                              "a level, or an attitude by another sensor"));
    out_.findings.push_back(std::move(f));
  }

  // Loaded before and after: what lands or lifts scrapes, and turns about its edges.
  bool is_settled(size_t c, size_t f, size_t k) const {
    const std::vector<char>& loaded = contacts_.loaded[c][f];
    const auto reach = static_cast<size_t>(std::lround(kScrape / log_.clips[c].step));
    return loaded[k] && k >= reach && loaded[k - reach] && k + reach < loaded.size() && loaded[k + reach];
  }

  // Friction that feet ask for while they slide, by base pose and force sensors of three axes.
  void check_slip() {
    if (!log_.base_pose) return;
    const double weight = log_.mass * log_.experiment->scenario.gravity_W.norm();
    std::vector<Slide> steps;
    for (size_t c = 0; c < log_.clips.size(); ++c) {
      const Clip& clip = log_.clips[c];
      BodyMotion motion(log_, clip);
      const size_t end = std::min(clip.size() - clip.edge, find_fall(clip));
      for (size_t k = clip.edge; k < end; k += 2) {
        bool updated = false;
        for (size_t f = 0; f < log_.feet.size(); ++f) {
          const Foot& foot = log_.feet[f];
          if (foot.sensor < 0 || !log_.sensors[static_cast<size_t>(foot.sensor)].has_force()) continue;
          // Below, chatter is much of its force.
          if (!is_settled(c, f, k) ||
              calc_vertical_force(log_, clip, static_cast<size_t>(foot.sensor), k) < kHalf * weight)
            continue;
          if (!updated) {
            motion.update(k);
            updated = true;
          }
          const Eigen::Vector2d v = find_slide(clip, foot, k, &motion);
          const Vector3d force = find_ground_force(clip, foot, k, &motion);
          const double side = force.head<2>().norm();
          steps.push_back({clip.recording, v.norm(), side / std::max(1e-9, force.z()),
                           -v.dot(force.head<2>()) / std::max(1e-9, side * v.norm())});
        }
      }
    }
    // The speed by a recorded pose has errors of its own: fast slides tell more, where there are any.
    for (const double times : {kFarMore, kSeveralTimes, kClearlyMore}) {
      if (add_slip(steps, times * kMoving)) return;
    }
  }

  // Of the sole along the ground [m/s], world: the base's recorded motion and the encoders.
  Eigen::Vector2d find_slide(const Clip& clip, const Foot& foot, size_t k, BodyMotion* motion) const {
    Vector3d v;
    for (int i = 0; i < 3; ++i) v(i) = clip.base_position[i].rate[k];
    const Eigen::Quaterniond q(clip.base_attitude[0].value[k], clip.base_attitude[1].value[k],
                               clip.base_attitude[2].value[k], clip.base_attitude[3].value[k]);
    const Transform X = get_pose(motion->data(), foot.link);
    const Vector3d at = calc_point_velocity(motion->data(), foot.link, X * foot.p_LC).tail<3>();
    return (v + q.normalized() * at).head<2>();
  }

  // Of the ground on the foot [N], world with the heading of the base's recorded pose.
  Vector3d find_ground_force(const Clip& clip, const Foot& foot, size_t k, BodyMotion* motion) const {
    const auto s = static_cast<size_t>(foot.sensor);
    const ForceSensor& sensor = log_.sensors[s];
    Vector3d f;
    for (int i = 0; i < 3; ++i) f(i) = clip.force[6 * s + static_cast<size_t>(i)].value[k];
    const Matrix3d R_WB = turn_heading(clip, k, motion->find_attitude(k)) * motion->find_attitude(k);
    if (!sensor.world) f = R_WB * (get_pose(motion->data(), sensor.link).R * (sensor.X_LS.R * f));
    // The ground also bears what hangs below the sensor.
    const Vector3d p = get_pose(motion->data(), sensor.link) * sensor.X_LS.p;
    return f + sensor.hangs * (R_WB * calc_point_acceleration(motion->data(), sensor.link, p).tail<3>());
  }

  // From the heading of an attitude [1] to that of the base's recorded pose: IMUs count it from where they like.
  static Matrix3d turn_heading(const Clip& clip, size_t k, const Matrix3d& R) {
    const Eigen::Quaterniond q(clip.base_attitude[0].value[k], clip.base_attitude[1].value[k],
                               clip.base_attitude[2].value[k], clip.base_attitude[3].value[k]);
    const Matrix3d turn = q.normalized().toRotationMatrix() * R.transpose();
    return Eigen::AngleAxisd(std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1)), Vector3d::UnitZ())
        .toRotationMatrix();
  }

  // Feet slide at the same share in two recordings at least (of one: there); a push or a fall is in one alone.
  static bool is_same_ground(const std::vector<Slide>& steps, double slow, double value) {
    std::map<size_t, std::vector<Slide>> each;
    std::set<size_t> recordings;
    for (const Slide& s : steps) {
      recordings.insert(s.recording);
      if (s.speed >= slow) each[s.recording].push_back(s);
    }
    size_t same = 0, other = 0;
    for (const auto& [r, slides] : each) {
      const double here = find_sliding_friction(slides).first;
      if (here <= 0) continue;
      ++(std::abs(here - value) < kPart * value ? same : other);
    }
    return same >= std::min<size_t>(2, recordings.size()) && same > other;
  }

  // Friction that holds more than it slides at is no friction. False: nothing is told.
  bool add_slip(const std::vector<Slide>& steps, double slow) {
    std::vector<Slide> slides;
    std::copy_if(steps.begin(), steps.end(), std::back_inserter(slides),
                 [&](const Slide& s) { return s.speed >= slow; });
    const auto [value, spread] = find_sliding_friction(slides);
    const double nominal = log_.experiment->scenario.ground.friction;
    size_t held = 0, beyond = 0;
    for (const Slide& s : steps) {
      held += s.speed < kMoving;
      beyond += s.speed < kMoving && s.ratio > (1.0 + kMuch) * value;
    }
    if (spread > kPart * value || value > 0.95 * nominal || value < 0.02) return false;
    if (!is_same_ground(steps, slow, value)) return false;
    // Feet that hold bear no more side force than sliding friction; else feet slide for another reason than friction.
    if (static_cast<double>(beyond) > kKnown * static_cast<double>(held)) return false;
    const EffectInfo& friction = get_effect(EffectId::kGroundFriction);  // no equation has a column of it
    Finding f = make_finding(friction, {{"ground", "ground"}}, {make_value(friction, value, spread)});
    f.grade = Grade::kSupported;
    f.probability = 0.9;
    f.share = 1;
    f.weight = 0.8;
    f.statement = format(
        "Loaded feet slide at %.2f +- %.2f of their normal force: the ground is more slippery than the model's %.2f.",
        value, 2 * spread, nominal);
    out_.findings.push_back(std::move(f));
    return true;
  }

  const LeggedLog& log_;
  const Contacts& contacts_;
  const std::vector<ChannelRows>& channels_;
  const ColumnLayout& at_;
  CheckResult out_;
};

}  // namespace

std::pair<double, double> find_sliding_friction(const std::vector<Slide>& slides) {
  std::vector<double> against, ratios;
  for (const Slide& s : slides) {
    against.push_back(s.against);
    if (s.against > kNearlyAll) ratios.push_back(s.ratio);
  }
  // Within 45 degrees of the way back, in half of all samples.
  if (ratios.size() < kFewestToTell || find_median(std::move(against)) < kLargely) return {0, 0};
  return {find_quantile(ratios, 0.5), 0.5 * (find_quantile(ratios, 0.75) - find_quantile(ratios, 0.25))};
}

Consensus find_consensus(std::vector<double> values, double least) {
  Consensus out;
  if (values.empty()) return out;
  std::sort(values.begin(), values.end());
  const double middle =
      values.size() % 2 ? values[values.size() / 2] : 0.5 * (values[values.size() / 2] + values[values.size() / 2 - 1]);
  std::vector<double> away, kept;
  for (double v : values) away.push_back(std::abs(v - middle));
  const double limit = std::max(least, kOutlier * find_deviation(std::move(away)));
  for (double v : values) {
    if (std::abs(v - middle) <= limit) kept.push_back(v);
  }
  if (3 * kept.size() < 2 * values.size()) kept = values;  // they scatter: nobody is odd
  out.kept = kept.size();
  out.odd = values.size() - kept.size();
  if (kept.empty()) return out;
  for (double v : kept) out.mean += v / static_cast<double>(kept.size());
  double sum = 0;
  for (double v : kept) sum += std::pow(v - out.mean, 2);
  const auto n = static_cast<double>(kept.size());
  out.std = n > 1 ? std::sqrt(sum / (n - 1) / n) : 1e9;
  return out;
}

CheckResult run_checks(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels,
                       const ColumnLayout& layout) {
  return Checker(log, contacts, channels, layout).run();
}

}  // namespace hrp::diagnosis::floating
