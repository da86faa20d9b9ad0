// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/gear_deflection.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/data/low_pass.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/gram.h"
#include "diagnosis/estimate/odds.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

enum Column : long { kZero, kTorque, kRate, kPlay, kWidth };

struct Series {
  bool train = true;
  Eigen::VectorXd deflection, rate, torque;  // kept samples
  Eigen::VectorXd effort, v, a;              // of the motor; effort empty where none was recorded
};

// One joint.
class Gear {
 public:
  Gear(const Experiment& e, const TorqueData& motion, const LinkSensors& sensors, const LinkData& links,
       const LinkReadings& predict, int joint)
      : e_(e), motion_(motion), joint_(joint) {
    out_.joint = joint;
    column_ = "/joint_states_link/" + e.robot.tree.joint(joint).name + "/position";
    for (const LinkRecording& r : links.recordings) read(r, predict, sensors);
    spread_ = find_torque_spread();
  }

  GearVerdict run() {
    for (const Series& s : series_) add(s);
    if (train_.empty()) return std::move(out_);
    total_ = sum(train_, kWidth);
    find_sides();
    find_noise();
    choose();
    write();
    return std::move(out_);
  }

 private:
  void read(const LinkRecording& link, const LinkReadings& predict, const LinkSensors& sensors) {
    const TorqueRecording* motor = nullptr;
    for (const TorqueRecording& r : motion_.recordings) {
      if (r.index == link.index) motor = &r;
    }
    if (!motor) return;
    long at = -1;
    for (const ReadingGroup& g : predict.groups()) {
      if (predict.sensors()[g.sensor].joint == joint_) at = g.first;
    }
    const Eigen::VectorXd deflection = motor->q.col(joint_) - link.q.col(joint_);
    const Eigen::VectorXd torque = sensors.has_torque(joint_) ? link.read.col(at) : link.predicted.col(at);
    const Eigen::VectorXd rate = differentiate(deflection, link.step);
    const long kept = std::max(0L, (link.q.rows() - 2 * link.trim + link.stride - 1) / link.stride);
    const auto keep = [&](const Eigen::VectorXd& full) {
      Eigen::VectorXd out(kept);
      for (long k = 0; k < kept; ++k) out[k] = full[link.trim + k * link.stride];
      return out;
    };
    Series s{link.train,
             keep(deflection),
             keep(rate),
             keep(torque),
             {},
             keep(motor->v.col(joint_)),
             keep(motor->a.col(joint_))};
    if (motion_.source[static_cast<size_t>(joint_)] == EffortSource::kRecorded)
      s.effort = keep(motor->effort.col(joint_));
    series_.push_back(std::move(s));
  }

  double find_torque_spread() const {
    Spread spread;
    for (const Series& s : series_) {
      for (double t : s.torque) spread.add(t);
    }
    return std::max(1e-12, spread.get());
  }

  Eigen::VectorXd make_row(const Series& s, long k) const {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(kWidth);
    x[kZero] = 1.0;
    x[kTorque] = s.torque[k];
    x[kRate] = -s.rate[k];
    x[kPlay] = 0.5 * std::tanh(s.torque[k] / (kMinor * spread_));
    return x;
  }

  void add(const Series& s) {
    const long n = s.deflection.size();
    std::vector<Gram> parts(static_cast<size_t>(kStretches), Gram(kWidth));
    for (long k = 0; k < n; ++k)
      parts[static_cast<size_t>(kStretches * k / std::max(1L, n))].add_row(make_row(s, k), s.deflection[k]);
    alone_.push_back(sum(parts, kWidth));
    if (s.train)
      train_.insert(train_.end(), parts.begin(), parts.end());
    else
      held_.push_back(alone_.back());
  }

  void find_sides() {
    double positive = 0.0, n = 0.0;
    for (const Series& s : series_) {
      for (double t : s.torque) {
        positive += t > 0.0 ? 1.0 : 0.0;
        n += 1.0;
      }
    }
    out_.one_sided = positive < kMinor * n || positive > (1.0 - kMinor) * n;
  }

  void find_noise() {
    if (held_.empty()) held_ = train_;
    const auto known = e_.other_noise.find(column_);
    const double link = known == e_.other_noise.end() ? 0.0 : known->second.sigma,
                 motor = e_.joint_noise[static_cast<size_t>(joint_)][0].sigma;
    const double passed = std::min(1.0, 2.0 * motion_.cutoff * motion_.recordings[0].step);
    floor_ = std::max(1e-18, (link * link + motor * motor) * passed);
    const Columns all{kZero, kTorque, kRate, kPlay};
    const Eigen::VectorXd theta = solve(total_, all);
    double time = 0.0;
    for (const Series& s : series_) {
      Eigen::VectorXd left(s.deflection.size());
      for (long k = 0; k < left.size(); ++k) left[k] = s.deflection[k] - make_row(s, k).head(4).dot(theta);
      time += left.size() > 8 ? calc_correlation_time(left) : 1.0;
    }
    effective_ = std::max(8.0, total_.n * static_cast<double>(series_.size()) / std::max(1.0, time));
  }

  double calc_evidence(const Columns& columns) const {
    double cost = 0.0;
    for (long c : columns) cost += c == kPlay ? kOneValue : c == kZero || c == kTorque ? kOdds : 1.0;
    const double square =
        columns.empty() ? total_.c / std::max(1.0, total_.n) : cross_validate(train_, total_, columns);
    return -0.5 * effective_ * std::log(std::max(square, floor_)) - cost;
  }

  bool is_physical(const Columns& columns, const Eigen::VectorXd& theta) const {
    for (size_t i = 0; i < columns.size(); ++i) {
      if ((columns[i] == kTorque || columns[i] == kPlay) && theta[static_cast<long>(i)] <= 0.0) return false;
    }
    return true;
  }

  // Selects the model: elasticity, free play, or both, with or without a zero. Damping needs elasticity beside it.
  void choose() {
    static const std::vector<Columns> models{{},
                                             {kZero},
                                             {kTorque},
                                             {kTorque, kRate},
                                             {kZero, kTorque},
                                             {kZero, kTorque, kRate},
                                             {kPlay},
                                             {kZero, kPlay},
                                             {kTorque, kPlay},
                                             {kTorque, kRate, kPlay},
                                             {kZero, kTorque, kPlay},
                                             {kZero, kTorque, kRate, kPlay}};
    double best = -1e300;
    for (const Columns& columns : models) {
      const Eigen::VectorXd theta = solve(total_, columns);
      if (!is_physical(columns, theta)) continue;
      const double evidence = calc_evidence(columns) - (columns.empty() ? 0.0 : kOdds);
      if (evidence > best) {
        best = evidence;
        model_ = columns;
        theta_ = theta;
      }
    }
    find_deviations();
  }

  void find_deviations() {
    if (model_.empty()) return;
    std_ = calc_covariance(train_, total_, model_, theta_).diagonal().cwiseAbs().cwiseSqrt();
    const double left = std::max(floor_, calc_rest(total_, model_, theta_) / total_.n) * total_.n / effective_;
    for (long c = 0; c < theta_.size(); ++c) {
      std::vector<double> values, variances;
      for (const Gram& gram : alone_) {
        values.push_back(solve(gram, model_)[c]);
        variances.push_back(std::max(1e-300, left * calc_inverse(gram, model_)(c, c)));
      }
      const double between = calc_variance_between(values, variances) / static_cast<double>(values.size());
      std_[c] = std::sqrt(std_[c] * std_[c] + between + std::pow(kSeveralTimes * kAgreement * theta_[c], 2));
    }
  }

  double get(Column column, bool deviation = false) const {
    for (size_t i = 0; i < model_.size(); ++i) {
      if (model_[i] == column) return deviation ? std_[static_cast<long>(i)] : theta_[static_cast<long>(i)];
    }
    return 0.0;
  }

  bool is_sure(Column column) const {
    return get(column) != 0.0 && std::abs(get(column)) > kSignificantInJoint * get(column, true);
  }

  double find_held(const Columns& columns, const Eigen::VectorXd& theta) const {
    double rest = 0.0, n = 0.0;
    for (const Gram& gram : held_) {
      rest += calc_rest(gram, columns, theta);
      n += gram.n;
    }
    return n > 0.0 ? rest / n : 0.0;
  }

  std::string name() const { return e_.robot.tree.joint(joint_).name; }
  std::string unit(const char* turning) const { return get_joint_unit(e_.robot.tree.joint(joint_), turning); }

  void write() {
    const double before = find_held({}, Eigen::VectorXd()), after = find_held(model_, theta_);
    out_.mismatch = before > kNoiseLeft * kNoiseLeft * floor_;
    out_.to_noise = after < std::max(kNoiseLeft * kNoiseLeft * floor_, kBlur * kBlur * before);
    out_.fit = {column_, unit("rad"), std::sqrt(before), std::sqrt(after), std::sqrt(before)};
    out_.remaining.where = {{"sensor", column_}};
    out_.remaining.unit = unit("rad");
    out_.remaining.before = std::sqrt(before);
    out_.remaining.after = std::sqrt(after);
    out_.remaining.statement = column_ + ": of " + number(std::sqrt(before), 3) + " " + unit("rad") +
                               " against the joint's encoder, " + number(std::sqrt(after), 3) + " " + unit("rad") +
                               " remain.";
    if (!out_.mismatch) return;
    const double share = std::clamp(1.0 - after / std::max(1e-300, before), 0.0, 1.0);
    if (is_sure(kZero)) {
      out_.zero_found = true;
      out_.zero = get(kZero);
      out_.zero_std = get(kZero, true);
    }
    const Columns zero{kZero};
    const double shifted = find_held(zero, solve(total_, zero));  // what remains for elasticity and play
    const double law = shifted > floor_ ? 1.0 - std::max(0.0, after - floor_) / shifted : 0.0;
    const Grade grade = law > kLargely ? Grade::kSupported : Grade::kAmbiguous;
    if (is_sure(kPlay))
      add_play(grade, share);
    else if (is_sure(kTorque))
      add_give(grade, share);
  }

  Finding start(EffectId id, Grade grade, double share) const {
    Finding f = make_finding(get_effect(id), {{"joint", name()}}, {});
    f.grade = grade;
    f.probability = kSurest;
    f.share = f.weight = share;
    return f;
  }

  // Stiffness and damping of teeth or shaft, converted from the coefficients 1/k and d/k.
  std::vector<Estimate> list_give() const {
    const double compliance = get(kTorque), rate = get(kRate);
    if (compliance <= 0.0) return {};
    const double k = 1.0 / compliance, std = get(kTorque, true) / (compliance * compliance);
    std::vector<Estimate> list{make_one("stiffness", unit("N m/rad"), k, std)};
    if (rate > 0.0)
      list.push_back(make_one("damping", unit("N m s/rad"), rate * k, std::hypot(get(kRate, true) * k, rate * std)));
    return list;
  }

  void finish(Finding f, const std::string& words) {
    f.statement = name() + ": " + get_effect(find_effect(f.effect)->id).phrase + ", " + words + " (" +
                  get_grade_name(f.grade) + "), by its two encoders. It takes away " + number(100.0 * f.share, 3) +
                  " % of what they differ by on held-out data.";
    out_.findings.push_back(std::move(f));
  }

  void add_give(Grade grade, double share) {
    Finding f = start(EffectId::kElasticity, grade, share);
    f.parameters = list_give();
    finish(f, "stiffness " + number(f.parameters[0].value[0], 4) + " +- " +
                  number(kNinetyFive * f.parameters[0].std[0], 2) + " " + f.parameters[0].unit);
  }

  void add_play(Grade grade, double share) {
    Finding f = start(EffectId::kBacklash, grade, share);
    f.parameters = {make_one("gap", unit("rad"), get(kPlay), get(kPlay, true))};
    for (const Estimate& e : list_give()) f.parameters.push_back(e);
    finish(f, "gap " + number(get(kPlay), 4) + " +- " + number(kNinetyFive * get(kPlay, true), 2) + " " + unit("rad"));
  }

  const Experiment& e_;
  const TorqueData& motion_;
  const int joint_;
  std::string column_;
  std::vector<Series> series_;
  std::vector<Gram> train_, held_, alone_;
  Gram total_;
  Columns model_;
  Eigen::VectorXd theta_, std_;
  double spread_ = 1.0, floor_ = 1e-18, effective_ = 8.0;
  GearVerdict out_;
};

}  // namespace

std::vector<GearVerdict> judge_gears(const Experiment& e, const TorqueData& motion, const LinkSensors& sensors,
                                     const std::vector<Effect>& known) {
  std::vector<GearVerdict> out;
  if (sensors.link_encoders.empty()) return out;
  LinkSensors torque;
  torque.link_encoders = sensors.link_encoders;
  for (int j : sensors.link_encoders) {
    LinkSensor s;
    s.name = "/joint_states_link/" + e.robot.tree.joint(j).name + "/effort";
    s.joint = j;
    s.link = j + 1;
    torque.sensors.push_back(s);
  }
  LinkReadings predict = make_link_readings(e, torque, known);
  const LinkData links = make_link_data(e, motion, torque, known, &predict);
  for (int j : sensors.link_encoders) out.push_back(Gear(e, motion, sensors, links, predict, j).run());
  return out;
}

}  // namespace hrp::diagnosis
