// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/by_recording.h"

#include <algorithm>
#include <cmath>

#include "common/base/format.h"
#include "diagnosis/data/mean.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/checks/weight_check.h"

namespace hrp::diagnosis::floating {
namespace {

// y = slope x + constant: slope, correlation, range of x. A constant of each group is taken out.
struct Slope {
  double xx = 0, xy = 0, yy = 0, range = 0;
  size_t count = 0;
  double slope() const { return xy / std::max(1e-300, xx); }
  double correlation() const { return xy / std::sqrt(std::max(1e-300, xx * yy)); }
  void add(const std::vector<double>& x, const std::vector<double>& y) {
    if (x.empty()) return;
    const double mean_x = calc_mean(x), mean_y = calc_mean(y);
    for (size_t i = 0; i < x.size(); ++i) {
      const double a = x[i] - mean_x, b = y[i] - mean_y;
      xx += a * a;
      xy += a * b;
      yy += b * b;
    }
    const auto [least, most] = std::minmax_element(x.begin(), x.end());
    range = std::max(range, *most - *least);
    count += x.size();
  }
};

class RecordingSays {
 public:
  RecordingSays(const LeggedLog& log, const std::vector<ChannelRows>& channels, int recording)
      : log_(log), layout_(log), channels_(channels), recording_(recording) {}

  std::string describe(bool raw_counts) {
    if (!raw_counts) add_weight();
    for (size_t i = 0; i < log_.imus.size(); ++i) {
      add_gravity(i);
      add_gyroscope(i);
    }
    for (size_t f = 0; f < log_.feet.size(); ++f) {
      add_sole(f, 0, "roll");
      add_sole(f, 1, "pitch");
    }
    std::string out;
    for (const std::string& text : texts_) out += (out.empty() ? "" : "; ") + text;
    return out;
  }

 private:
  // Values of this recording's rows.
  template <class Get>
  std::vector<double> list(const ChannelRows& c, const Get& get) const {
    std::vector<double> out;
    for (size_t i = 0; i < c.rows(); ++i) {
      if (c.recording[i] == recording_) out.push_back(get(i));
    }
    return out;
  }

  std::vector<double> list_y(const ChannelRows& c) const {
    return list(c, [&](size_t i) { return c.y[i]; });
  }

  // Of one column; empty where the equation does not have it.
  std::vector<double> list_column(const ChannelRows& c, int column) const {
    const int at = c.find_column(column);
    if (at < 0) return {};
    return list(c, [&](size_t i) { return c.row(i)[at]; });
  }

  void add_weight() {
    const ChannelRows* c = find_weight_equation(channels_);
    const std::vector<double> y = c ? list_y(*c) : std::vector<double>{};
    if (y.size() < kFewestToTell) return;
    const double weight = (log_.mass - log_.mass_below) * log_.experiment->scenario.gravity_W.norm();
    texts_.push_back(format("the feet carry %.3f of what the model weighs", 1 + find_median(y) / weight));
  }

  void add_gravity(size_t imu) {
    const std::string signal = "/imu/" + log_.imus[imu].name + "/linear_acceleration";
    for (const ChannelRows& c : channels_) {
      if (!c.info.equation.is(EquationKind::kGravity) || c.info.signal != signal) continue;
      const std::vector<double> y = list_y(c);
      if (y.size() < kFewestToTell) continue;
      texts_.push_back(signal + format(" reads %.3f of gravity at rest",
                                       1 + calc_mean(y) / log_.experiment->scenario.gravity_W.norm()));
    }
  }

  // Its reading over what the others tell of it, beside a zero of each axis; the sensor's own delay is the slope of
  // what is left over minus its rate.
  void add_gyroscope(size_t imu) {
    const std::string signal = "/imu/" + log_.imus[imu].name + "/angular_velocity";
    Slope gain, late;
    for (const ChannelRows& c : channels_) {
      if (!c.info.equation.is_gyroscope() || c.info.signal != signal) continue;
      const std::vector<double> told = list_column(c, layout_.imu(static_cast<int>(imu), kGyroScaleColumn)),
                                left = list_y(c);
      std::vector<double> reading;
      for (size_t i = 0; i < told.size(); ++i) reading.push_back(told[i] + left[i]);
      gain.add(told, reading);
      late.add(list_column(c, layout_.imu(static_cast<int>(imu), kGyroDelayColumn)), left);
    }
    if (gain.count < kFewestToTell || gain.xx <= 0) return;
    texts_.push_back(signal +
                     format(" reads %.2f of the rate that it is compared with, %.0f ms late (correlation %.2f)",
                            gain.slope(), 1e3 * late.slope(), gain.correlation()));
  }

  // Only where the sole's moment follows its tilt.
  void add_sole(size_t foot, int axis, const char* name) {
    for (const ChannelRows& c : channels_) {
      if (!(c.info.equation == Equation(EquationKind::kTilt, axis)) || c.info.name != log_.feet[foot].name) continue;
      const std::vector<double> moment =
          list_column(c, layout_.foot(static_cast<int>(foot), axis == 0 ? kRollGiveColumn : kPitchGiveColumn));
      Slope s;
      if (!moment.empty()) s.add(list_y(c), moment);
      if (s.count < kFewestToTell || s.range < kFarMore * kCalibrated || std::abs(s.correlation()) < kMostly) continue;
      texts_.push_back(
          log_.feet[foot].name + ": its " + name +
          format(" moment over its tilt is %.3g N m/rad (correlation %.2f)", std::abs(s.slope()), s.correlation()));
    }
  }

  const LeggedLog& log_;
  const ColumnLayout layout_;
  const std::vector<ChannelRows>& channels_;
  int recording_;
  std::vector<std::string> texts_;
};

}  // namespace

std::vector<std::string> describe_recordings(const LeggedLog& log, const std::vector<ChannelRows>& channels,
                                             bool raw_counts) {
  std::vector<std::string> out;
  const std::vector<Recording>& recordings = log.experiment->recordings;
  for (size_t r = 0; r < recordings.size(); ++r) {
    const std::string text = RecordingSays(log, channels, static_cast<int>(r)).describe(raw_counts);
    if (!text.empty()) out.push_back(recordings[r].spec.name + ": " + text);
  }
  return out;
}

}  // namespace hrp::diagnosis::floating
