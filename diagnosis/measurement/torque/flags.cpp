// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/torque/flags.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/gaps.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

// Stretches in which no encoder moves although drives work: a frozen log, or a robot that was switched off. Leaves out
// a block before and after as well.
constexpr double kFrozenTime = 0.3;  // [s] shortest stretch
// While a joint sticks, friction equals the drive's effort, and no term describes it. The filter spreads this to
// neighbouring samples. A joint that only reverses is slow for a shorter time than the filter sees: a detail of a
// period of its cutoff.

// Range of each joint's effort over the samples with `still` == `wanted`.
Eigen::ArrayXd find_range(const TorqueRecording& r, const Flags& still, bool wanted) {
  Eigen::ArrayXd low = Eigen::ArrayXd::Constant(r.effort.cols(), 1e300), high = -low;
  for (long k = 0; k < r.effort.rows(); ++k) {
    if (still[k] != wanted) continue;
    low = low.min(r.effort.row(k).transpose().array());
    high = high.max(r.effort.row(k).transpose().array());
  }
  return (high - low).max(0.0);
}

}  // namespace

Flags find_moving(const Eigen::VectorXd& v, double slow, double step, double cutoff) {
  const long rows = v.size(), least = std::lround(kDetail / cutoff / step),
             reach = std::lround(kFilterReach / cutoff / step);
  Flags moving = v.array().abs() > slow;
  const Flags fast = moving;
  for (long begin = 0; begin < rows; ++begin) {
    if (fast[begin]) continue;
    long end = begin;
    while (end < rows && !fast[end]) ++end;
    const long from = std::max(0L, begin - reach), to = std::min(rows, end + reach);
    if (end - begin >= least) moving.segment(from, to - from).setConstant(false);
    begin = end;
  }
  return moving;
}

void mark_gaps(const std::vector<double>& time, const std::vector<double>& signal, const TorqueRecording& r,
               double sample_time, double cutoff, Flags* read) {
  if (signal.empty()) return;
  const double least = std::max(kFilterReach / cutoff, kLostPeriods * sample_time);
  double last = r.begin;
  const auto mark = [&](double from, double to) {
    if (to - from <= least) return;
    const long begin = std::max(0L, std::lround((from - 2.0 * kFilterReach / cutoff - r.begin) / r.step));
    const long end = std::min(read->size(), std::lround((to + 2.0 * kFilterReach / cutoff - r.begin) / r.step) + 1);
    if (begin < end) read->segment(begin, end - begin).setConstant(false);
  };
  for (size_t k = 0; k < std::min(time.size(), signal.size()); ++k) {
    if (!std::isfinite(signal[k])) continue;
    mark(last, time[k]);
    last = time[k];
  }
  mark(last, time.back());
}

Flags find_still(const Eigen::MatrixXd& raw, const std::vector<double>& noise, double step) {
  const long rows = raw.rows(), window = std::min(rows - 1, std::lround(kFrozenTime / step));
  Flags still = Flags::Constant(rows, true);
  for (long j = 0; j < raw.cols(); ++j) {
    // Far beyond any noise: the encoder does not rest.
    const double limit = kTenTimes * noise[static_cast<size_t>(j)] + 1e-9;
    for (long k = 0; k < rows; ++k) {
      const long end = std::min(rows - 1, k + window), begin = end - window;
      for (long i = begin; i < end && still[k]; i += std::max(1L, window / 16))
        still[k] = std::abs(raw(i, j) - raw(end, j)) < limit;
    }
  }
  return still;
}

// True if the effort of a joint that this recording moves has a clearly larger range while nothing moves. Of a joint
// that is held, noise alone decides which range is the larger one.
bool works_unmoved(const TorqueRecording& r, const Flags& still) {
  const Eigen::ArrayXd travel = (r.q.colwise().maxCoeff() - r.q.colwise().minCoeff()).transpose().array();
  return (travel > kHardlyMoved && find_range(r, still, true) > kClearlyMore * find_range(r, still, false)).any();
}

Flags find_frozen(const TorqueRecording& r, const Flags& still) {
  const long rows = r.v.rows(), lead = std::lround(kBlock / r.step);
  Flags frozen = Flags::Constant(rows, false);
  if (r.q.cols() < 2 || !still.any() || still.all() || !works_unmoved(r, still)) return frozen;
  for (long k = 0; k < rows; ++k) {
    if (still[k])
      frozen.segment(std::max(0L, k - lead), std::min(rows, k + lead) - std::max(0L, k - lead)).setConstant(true);
  }
  return frozen;
}

void mark_sudden(const Eigen::VectorXd& raw, const Eigen::VectorXd& smooth, long reach, Flags* sudden) {
  const Eigen::ArrayXd apart = (raw - smooth).array().abs();
  // Far beyond any noise, a reading that the filter takes apart.
  const double limit = kTenTimes * find_deviation({apart.data(), apart.data() + apart.size()});
  for (long k = 0; k < apart.size() && limit > 0.0; ++k) {
    const long from = std::max(0L, k - reach), to = std::min(apart.size(), k + reach + 1);
    if (apart[k] > limit) sudden->segment(from, to - from).setConstant(true);
  }
}

Flags find_clipped(const Eigen::VectorXd& effort) {
  const double greatest = effort.cwiseAbs().maxCoeff();
  const Flags high = effort.array().abs() > 0.99 * greatest;
  return greatest > 0.0 && static_cast<double>(high.count()) > 0.02 * static_cast<double>(high.size())
             ? high
             : Flags::Constant(effort.size(), false);
}

}  // namespace hrp::diagnosis
