// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/imu_checks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/base/has.h"
#include "common/multibody/kinematics.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/checks/weight_check.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/log/body_motion.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kGravity = 0.003;  // gravity itself differs by so much from place to place

class ImuChecker {
 public:
  ImuChecker(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels,
             const ColumnLayout& layout, CheckResult* out)
      : log_(log), contacts_(contacts), channels_(channels), at_(layout), out_(*out) {}

  void run() {
    for (size_t i = 0; i < log_.imus.size(); ++i) {
      if (log_.imus[i].accelerometer) {
        check_gravity(i);
        check_offset(i);
      }
    }
    for (const ChannelRows& c : channels_) check_gyro(c);
  }

 private:
  // Specific force at rest against gravity, by recording.
  std::vector<double> list_rest(size_t imu) const {
    const std::string signal = "/imu/" + log_.imus[imu].name + "/linear_acceleration";
    const double g = log_.experiment->scenario.gravity_W.norm();
    std::vector<double> out;
    for (const ChannelRows& c : channels_) {
      if (!c.info.equation.is(EquationKind::kGravity) || c.info.signal != signal) continue;
      for (const auto& [r, y] : split_by_recording(c)) {
        double sum = 0;
        for (double v : y) sum += v;
        if (y.size() >= kFewestToTell) out.push_back(1 + sum / static_cast<double>(y.size()) / g);
      }
    }
    return out;
  }

  static std::pair<double, double> calc_spread(const std::vector<double>& v) {
    double mean = 0, square = 0;
    for (double x : v) mean += x / static_cast<double>(v.size());
    for (double x : v) square += std::pow(x - mean, 2) / static_cast<double>(v.size());
    return {mean, std::sqrt(square)};
  }

  // The mean size of its reading while the robot stands still on all feet for some blocks, over which the mean
  // acceleration of a body nearly vanishes, by recording. Feet that chatter, and falls,
  // add to the mean what is sampled too slowly.
  std::vector<double> list_stands(size_t imu) const {
    const double g = log_.experiment->scenario.gravity_W.norm();
    const int all = get_phase_of_all(log_);
    std::map<size_t, std::pair<double, double>> sums;  // by recording: sum, count
    for (size_t c = 0; c < log_.clips.size(); ++c) {
      const Clip& clip = log_.clips[c];
      for (size_t begin = clip.edge, end = 0; begin + clip.edge < clip.size(); begin = end) {
        const int phase = contacts_.find_phase(c, begin);
        for (end = begin + 1; end + clip.edge < clip.size() && contacts_.find_phase(c, end) == phase;) ++end;
        if (phase != all || static_cast<double>(end - begin) * clip.step < kFewestBlocks * kBlock) continue;
        std::vector<double> sizes;
        for (size_t k = begin; k < end; ++k) sizes.push_back(get_values(clip.imus[imu].accelerometer, k).norm());
        const auto [mean, spread] = calc_spread(sizes);
        if (spread > kKnown * g) continue;
        auto& [sum, count] = sums[clip.recording];
        sum += mean * static_cast<double>(sizes.size());
        count += static_cast<double>(sizes.size());
      }
    }
    std::vector<double> out;
    for (const auto& [r, sum] : sums) out.push_back(sum.first / sum.second / g);
    return out;
  }

  // Its mean over walks that are long enough.
  std::vector<double> list_walks(size_t imu) const {
    const double g = log_.experiment->scenario.gravity_W.norm();
    std::vector<double> out;
    for (const Clip& clip : log_.clips) {
      if (clip.time.back() - clip.time.front() < kFewestBlocks * kBlock) continue;
      BodyMotion motion(log_, clip);
      double sum = 0, count = 0;
      for (size_t k = clip.edge; k + clip.edge < clip.size(); k += kStride) {
        motion.update(k);
        const Transform X = get_pose(motion.data(), log_.imus[imu].link);
        const Vector3d f = get_values(clip.imus[imu].accelerometer, k);
        sum += motion.find_up(k).dot(X.R * log_.imus[imu].R_LI * f);
        count += 1;
      }
      out.push_back(1 + (sum / count - g) / g);
    }
    return out;
  }

  // Equations that hold sample by sample tell an accelerometer's scale better than its mean over a walk, to which
  // impacts that were sampled too slowly, and falls, add what they like. Standing is no worse. Torques of legs tell the
  // weight to some percent only: the balance by them says less than the mean does.
  bool is_weighed(size_t imu) const {
    const int column = at_.imu(static_cast<int>(imu), kAccelerometerScaleColumn);
    return std::any_of(channels_.begin(), channels_.end(), [&](const ChannelRows& c) {
      const Equation& e = c.info.equation;
      const bool dynamic =
          e.is_balance() || e.is(EquationKind::kAccelerometer) || (e.is(EquationKind::kWeight) && !out_.raw_counts);
      return dynamic && c.rows() > kFewestToTell && has(c.columns, column);
    });
  }

  void check_gravity(size_t imu) {
    const bool weighed = is_weighed(imu);
    std::vector<double> values = weighed ? list_stands(imu) : list_rest(imu);
    const bool at_rest = values.size() >= 2;
    if (!at_rest && !weighed && static_cast<int>(imu) == BodyMotion::find_main_imu(log_)) values = list_walks(imu);
    const std::string name = "/imu/" + log_.imus[imu].name + "/linear_acceleration";
    if (values.size() < 2) return;
    const Consensus k = find_consensus(values, kGravity);
    const double g = log_.experiment->scenario.gravity_W.norm();
    const std::string when = weighed ? ": standing," : at_rest ? ": at rest" : ": on average";
    // A trace of a scale is within what every accelerometer's data sheet allows.
    if (k.kept < 2 || std::abs(k.mean - 1) <= std::max(3 * k.std, kTrace)) {
      out_.notes.push_back(name + when + format(" it reads %.4f +- %.4f of gravity: they agree", k.mean, 2 * k.std));
      return;
    }
    const EffectInfo &scale = get_laws().sensor_scale.info(), &bias = get_laws().sensor_bias.info();
    Finding f = make_finding(scale, {{"sensor", name}}, {make_value(scale, k.mean, k.std)});
    f.grade = Grade::kAmbiguous;
    f.probability = 0.9;
    f.share = 1;
    f.weight = 0.3;
    f.statement = name + when +
                  format(
                      " it reads %.4f +- %.4f of gravity: its scale or its zero is off; a body that stays upright "
                      "shows only their sum.",
                      k.mean, 2 * k.std);
    const Estimate zero = make_value(bias, (k.mean - 1) * g, k.std * g, "m/s^2");
    f.alternatives.push_back(make_alternative(bias, f.where, {zero}, "the IMU at rest in six attitudes"));
    out_.findings.push_back(std::move(f));
  }

  // How an accelerometer on the base differs from the base's recorded pose while the robot stands.
  void check_offset(size_t imu) {
    if (!log_.base_pose || log_.imus[imu].link != 0) return;
    const std::string name = "/imu/" + log_.imus[imu].name + "/linear_acceleration";
    Vector3d mean = Vector3d::Zero(), spread = Vector3d::Zero();
    for (int a = 0; a < 3; ++a) {
      const std::vector<double> each = list_offsets(name, {EquationKind::kAccelerometer, a});
      if (each.size() < 2) return;
      for (double v : each) mean(a) += v / static_cast<double>(each.size());
      const auto [least, most] = std::minmax_element(each.begin(), each.end());
      spread(a) = *most - *least;
    }
    if (mean.norm() < kGravity * log_.experiment->scenario.gravity_W.norm()) return;
    Remaining r;
    r.where = {{"sensor", name}};
    r.unit = "m/s^2";
    r.before = r.after = mean.norm();
    r.statement = name +
                  format(": standing, it differs from the base's recorded pose by %.3f, %.3f, %.3f m/s^2", mean.x(),
                         mean.y(), mean.z()) +
                  format(" (x y z; recordings by %.3f).", spread.maxCoeff()) + describe_size(imu) +
                  " Its zero, its scale or its mounting is off, or the pose is turned.";
    out_.remaining.push_back(std::move(r));
  }

  std::string describe_size(size_t imu) const {
    const std::vector<double> sizes = list_stands(imu);
    return sizes.empty() ? ""
                         : format(" It reads %.4f of gravity, which differs by %.3f from place to place.",
                                  find_median(sizes), kGravity);
  }

  // [m/s^2] By recording, while the robot stands on all feet.
  std::vector<double> list_offsets(const std::string& signal, const Equation& equation) const {
    std::vector<double> out;
    for (const ChannelRows& c : channels_) {
      if (c.info.signal != signal || !(c.info.equation == equation)) continue;
      for (const auto& [r, y] : split_stands(c)) {
        if (y.size() >= kFewestToTell) out.push_back(find_median(y));
      }
    }
    return out;
  }

  // An equation's rows by recording, while the robot stands on all feet for some time.
  std::map<int, std::vector<double>> split_stands(const ChannelRows& c) const {
    const int all = get_phase_of_all(log_);
    std::map<int, std::vector<double>> out;
    for (size_t begin = 0, end = 0; begin < c.rows(); begin = end) {
      const auto follows = [&](size_t i) {
        return c.recording[i] == c.recording[begin] && c.phase[i] == c.phase[begin] &&
               c.time[i] < c.time[i - 1] + kPause;
      };
      for (end = begin + 1; end < c.rows() && follows(end);) ++end;
      if (c.phase[begin] != all || c.time[end - 1] < c.time[begin] + kFewestBlocks * kBlock) continue;
      for (size_t i = begin; i < end; ++i) out[c.recording[i]].push_back(c.y[i]);
    }
    return out;
  }

  void check_gyro(const ChannelRows& c) {
    if (!c.info.equation.is_gyroscope() || c.rows() < kFewestToTell || c.scale <= 0) return;
    double sum = 0;
    for (double y : c.y) sum += y * y;
    const double left = std::sqrt(sum / static_cast<double>(c.rows())) / c.scale;
    out_.notes.push_back(c.info.signal + format(", %.0f cells: ", static_cast<double>(c.rows())) +
                         get_text(c.info.equation) +
                         format(" differs from encoders and attitude by %.2f of its spread", left));
  }

  const LeggedLog& log_;
  const Contacts& contacts_;
  const std::vector<ChannelRows>& channels_;
  const ColumnLayout& at_;
  CheckResult& out_;
};

}  // namespace

void check_imus(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels,
                const ColumnLayout& layout, CheckResult* out) {
  ImuChecker(log, contacts, channels, layout, out).run();
}

}  // namespace hrp::diagnosis::floating
