// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/torque/stops.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "common/base/rounding.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/gram.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/torque/use.h"
#include "diagnosis/model/nominal.h"

namespace hrp::diagnosis {
namespace {

constexpr int kTried = 25;   // angles: a hundredth of the travel apart
constexpr long kSmooth = 7;  // columns: v, direction, a, tau, 1, q, q^2

// Training samples of one joint in use, from the one that stays furthest from one end of the travel to the one that
// comes nearest, within the filter's reach.
class Samples {
 public:
  // `side`: 1 for the upper end, -1 for the lower one.
  Samples(const TorqueData& data, int joint, double side) {
    for (const TorqueRecording& r : data.recordings) {
      if (r.train) add(data, r, joint, side);
    }
    order_.resize(furthest_.size());
    std::iota(order_.begin(), order_.end(), 0);
    std::sort(order_.begin(), order_.end(), [&](size_t a, size_t b) { return furthest_[a] < furthest_[b]; });
  }

  // The angle beyond which something stops the joint; the one that leaves out least.
  std::optional<double> find() const {
    const size_t count = order_.size();
    if (count < static_cast<size_t>(kRowsPerColumn * kSmooth)) return std::nullopt;
    const double nearest = furthest_[order_.front()], travel = furthest_[order_.back()] - nearest;
    Gram whole(kSmooth), within(kSmooth);
    for (size_t i = 0; i < count; ++i) whole.add_row(rows_[i], missing_[i]);
    const double enough = kTrace * calc_mean_square(whole);
    std::optional<double> angle;
    size_t i = 0;
    for (int part = 0; part < kTried; ++part) {
      const double at = nearest + travel * (kLargely + kMuch * part / kTried);
      for (; i < count && furthest_[order_[i]] <= at; ++i) within.add_row(rows_[order_[i]], missing_[order_[i]]);
      if (2 * i > count && calc_mean_square(within) < enough && pushes_back(within, i)) angle = at;
    }
    return angle;
  }

 private:
  void add(const TorqueData& data, const TorqueRecording& r, int joint, double side) {
    const Eigen::VectorXd sign = data.calc_sign(r, joint), q = side * r.q.col(joint),
                          furthest = find_largest_near(q, r, data.cutoff);
    for (long k = 0; k < r.kept(); ++k) {
      if (!r.use(k, joint)) continue;
      const long i = r.full_row(k);
      Eigen::VectorXd row(kSmooth);
      row << side * r.v(i, joint), side * sign[i], side * r.a(i, joint), side * r.tau(i, joint), 1.0, q[i], q[i] * q[i];
      rows_.push_back(row);
      missing_.push_back(side * r.missing(k, joint));
      furthest_.push_back(furthest[k]);
    }
  }

  static double calc_mean_square(const Gram& gram) { return calc_rest(gram, all(), solve(gram, all())) / gram.n; }
  static Columns all() {
    Columns columns(kSmooth);
    std::iota(columns.begin(), columns.end(), 0L);
    return columns;
  }

  // What the laws of the first samples leave of the others is a torque against the motion towards the end, larger than
  // what they leave there.
  bool pushes_back(const Gram& within, size_t first) const {
    const Eigen::VectorXd law = solve(within, all());
    double sum = 0.0;
    for (size_t i = first; i < order_.size(); ++i) sum += missing_[order_[i]] - law.dot(rows_[order_[i]]);
    return sum / static_cast<double>(order_.size() - first) > std::sqrt(calc_mean_square(within));
  }

  std::vector<Eigen::VectorXd> rows_;
  std::vector<double> missing_, furthest_;
  std::vector<size_t> order_;
};

}  // namespace

void leave_out_stops(TorqueWork* w, int j) {
  // Commands that jump to one end of the travel, late, look like a stop.
  if (w->data.source[static_cast<size_t>(j)] != EffortSource::kRecorded || !is_effort_driven(w->e)) return;
  const JointSpec& joint = w->e.robot.tree.joint(j);
  for (double side : {1.0, -1.0}) {
    const std::optional<double> angle = Samples(w->data, j, side).find();
    if (!angle) continue;
    for (TorqueRecording& r : w->data.recordings)
      r.use.col(j) = r.use.col(j) && find_largest_near(side * r.q.col(j), r, w->data.cutoff).array() <= *angle;
    w->data.warnings.push_back(joint.name + ": something stops it " + (side > 0.0 ? "above " : "below ") +
                               number(side * *angle, 2) + (joint.kind == JointKind::kPrismatic ? " m" : " rad") +
                               ", as a stop, a table or a tight cable does: samples there are left out");
  }
}

}  // namespace hrp::diagnosis
