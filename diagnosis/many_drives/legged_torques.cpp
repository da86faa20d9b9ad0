// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/many_drives/legged_torques.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "diagnosis/data/csv.h"
#include "diagnosis/data/low_pass.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/equations/residuals.h"
#include "diagnosis/measurement/torque/flags.h"

namespace hrp::diagnosis::many_drives {
namespace {

using floating::BodyChannels;
using floating::BodyMotion;
using floating::BodySample;
using floating::Clip;
using floating::ImuTracks;
using floating::Track;

// A clip on the rows [begin, begin + count) of a torque recording's grid, with that recording's filter.
class Gridder {
 public:
  Gridder(const Clip& in, const TorqueRecording& grid, double cutoff) : in_(in), grid_(grid), cutoff_(cutoff) {
    begin_ = std::max(0L, static_cast<long>(std::ceil((in.time.front() - grid.begin) / grid.step - kTrace)));
    const long end = static_cast<long>(std::floor((in.time.back() - grid.begin) / grid.step + kTrace)) + 1;
    count_ = std::max(0L, std::min(grid.q.rows(), end) - begin_);
  }

  long begin() const { return begin_; }
  long count() const { return count_; }

  Clip run() const {
    Clip out;
    out.recording = in_.recording;
    out.train = in_.train;
    out.step = grid_.step;
    for (long k = 0; k < count_; ++k) out.time.push_back(find_time(k));
    for (long j = 0; j < grid_.q.cols(); ++j) {
      const Track& measured = in_.position[static_cast<size_t>(j)];
      out.position.push_back(measured.empty() ? Track{} : make_track(grid_.q.col(j).segment(begin_, count_)));
    }
    for (const Track& t : in_.force) out.force.push_back(filter(t));
    for (const ImuTracks& imu : in_.imus) out.imus.push_back(filter(imu));
    for (size_t i = 0; i < 3; ++i) out.base_position[i] = filter(in_.base_position[i]);
    for (size_t i = 0; i < 4; ++i) out.base_attitude[i] = filter(in_.base_attitude[i]);
    return out;
  }

  // By row of the grid's part: no impact within the filter's reach.
  Flags find_calm() const {
    Flags sudden = Flags::Constant(count_, false);
    const long reach = std::lround(kFilterReach / cutoff_ / grid_.step);
    const auto mark = [&](const Track& t) {
      if (t.empty()) return;
      const Eigen::VectorXd raw = resample(t);
      mark_sudden(raw, low_pass(raw, grid_.step, cutoff_), reach, &sudden);
    };
    for (const Track& t : in_.force) mark(t);
    return !sudden;
  }

  // Sample of the clip nearest to a row of the grid's part.
  size_t find_sample(long row) const {
    const double k = std::round((find_time(row) - in_.time.front()) / in_.step);
    return static_cast<size_t>(std::clamp(k, 0.0, static_cast<double>(in_.size() - 1)));
  }

 private:
  double find_time(long row) const { return grid_.begin + grid_.step * static_cast<double>(begin_ + row); }

  Eigen::VectorXd resample(const Track& t) const {
    return diagnosis::resample(in_.time, t.value, find_time(0), grid_.step, count_);
  }

  Track make_track(const Eigen::VectorXd& value) const {
    const auto list = [](const Eigen::VectorXd& v) { return std::vector<double>(v.data(), v.data() + v.size()); };
    const Eigen::VectorXd rate = differentiate(value, grid_.step);
    return {list(value), list(rate), list(differentiate(rate, grid_.step))};
  }

  Track filter(const Track& t) const {
    return t.empty() ? Track{} : make_track(low_pass(resample(t), grid_.step, cutoff_));
  }

  ImuTracks filter(const ImuTracks& imu) const {
    ImuTracks out;
    for (size_t i = 0; i < 4; ++i) out.attitude[i] = filter(imu.attitude[i]);
    for (size_t i = 0; i < 3; ++i) {
      out.gyro[i] = filter(imu.gyro[i]);
      out.accelerometer[i] = filter(imu.accelerometer[i]);
    }
    return out;
  }

  const Clip& in_;
  const TorqueRecording& grid_;
  const double cutoff_;
  long begin_ = 0, count_ = 0;
};

// Fills the rows of one clip.
class ClipTorques {
 public:
  ClipTorques(const LeggedLogs& logs, size_t clip, const TorqueRecording& grid, double cutoff)
      : logs_(logs),
        clip_(clip),
        gridder_(logs.raw.clips[clip], grid, cutoff),
        reach_(std::lround(kFilterReach / cutoff / grid.step)) {
    none_.row.assign(size_t{floating::kJointRow} + static_cast<size_t>(logs.raw.num_joints()), -1);
  }

  void fill(Eigen::MatrixXd* tau) const {
    if (gridder_.count() <= 2 * reach_) return;
    const Clip grid = gridder_.run();
    BodyMotion motion(logs_.raw, grid);
    const Flags calm = lands() ? gridder_.find_calm() : Flags::Constant(gridder_.count(), true);
    for (long k = reach_; k + reach_ < gridder_.count(); ++k) {
      if (!calm[k] || !motion.update(static_cast<size_t>(k))) continue;
      const BodySample at{logs_.raw, grid, clip_, static_cast<size_t>(k), motion};
      const BodySample smooth{logs_.smooth, logs_.smooth.clips[clip_], clip_, gridder_.find_sample(k), motion};
      tau->row(gridder_.begin() + k) = calc_residuals(at, none_, Vector3d::Zero()).load;
      for (int j = 0; j < logs_.raw.num_joints(); ++j) {
        if (!is_joint_known(smooth, logs_.contacts, j)) (*tau)(gridder_.begin() + k, j) = kMissing;
      }
    }
  }

 private:
  // Whether a foot lands or lifts. The forces of feet that stay are sudden only where joints stick and slip, which both
  // sides of the equation show alike through the filter.
  bool lands() const {
    const auto& feet = logs_.contacts.loaded[clip_];
    return std::any_of(feet.begin(), feet.end(), [](const std::vector<char>& loaded) {
      return std::adjacent_find(loaded.begin(), loaded.end(), std::not_equal_to<>()) != loaded.end();
    });
  }

  const LeggedLogs& logs_;
  const size_t clip_;
  const Gridder gridder_;
  const long reach_;  // [rows] of the filter
  BodyChannels none_;
};

}  // namespace

TorqueData make_legged_torques(const LeggedLogs& logs) {
  const Experiment& e = *logs.raw.experiment;
  if (!is_base_felt(logs.raw, logs.contacts) || logs.raw.clips.size() != logs.smooth.clips.size()) {
    TorqueData nothing;
    nothing.experiment = &e;
    return nothing;
  }
  return make_torque_data(e, [&](const TorqueRecording& grid, double cutoff) {
    Eigen::MatrixXd tau = Eigen::MatrixXd::Constant(grid.q.rows(), grid.q.cols(), kMissing);
    for (size_t c = 0; c < logs.raw.clips.size(); ++c) {
      if (logs.raw.clips[c].recording == grid.index) ClipTorques(logs, c, grid, cutoff).fill(&tau);
    }
    return tau;
  });
}

}  // namespace hrp::diagnosis::many_drives
