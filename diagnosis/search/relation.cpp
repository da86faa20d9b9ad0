// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/relation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/format.h"
#include "common/base/has.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

constexpr int kCoarse = 16, kFine = 60;  // intervals of one quantity, for smooth and for sharp functions
constexpr double kHighest = 14.0;        // [Hz] faster oscillations are averaged away

double get_squares(const std::vector<Observed>& recordings) {
  double sum = 0.0;
  for (const Observed& o : recordings) sum += std::inner_product(o.y.begin(), o.y.end(), o.y.begin(), 0.0);
  return std::max(1e-300, sum);
}

// Limits of intervals with equally many samples.
std::vector<double> find_edges(const std::vector<Observed>& recordings, int quantity, int count) {
  std::vector<double> values, edges;
  for (const Observed& o : recordings) {
    const std::vector<double>& x = o.x[static_cast<size_t>(quantity)];
    values.insert(values.end(), x.begin(), x.end());
  }
  std::sort(values.begin(), values.end());
  for (int b = 1; b < count && !values.empty(); ++b)
    edges.push_back(values[values.size() * static_cast<size_t>(b) / static_cast<size_t>(count)]);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

// Table of means over the intervals of one quantity, or of a parabola of a second quantity in each interval.
class Table {
 public:
  Table(const std::vector<Observed>& train, int quantity, int count, int beside = -1)
      : quantity_(quantity), beside_(beside), edges_(find_edges(train, quantity, count)) {
    std::vector<Eigen::Matrix3d> A(edges_.size() + 1, Eigen::Matrix3d::Zero());
    std::vector<Eigen::Vector3d> b(edges_.size() + 1, Eigen::Vector3d::Zero());
    for (const Observed& o : train) scale_ = std::max(scale_, find_largest(o));
    for (const Observed& o : train) {
      for (size_t k = 0; k < o.y.size(); ++k) {
        const Eigen::Vector3d row = make_row(get_beside(o, k));
        A[find(o, k)] += row * row.transpose();
        b[find(o, k)] += row * o.y[k];
      }
    }
    for (size_t cell = 0; cell < A.size(); ++cell) {
      // The ridge removes dependence on the second quantity where it hardly varies within an interval.
      A[cell].diagonal().array() += kRidge * std::max(1.0, A[cell](0, 0));
      parabolas_.push_back(A[cell].ldlt().solve(b[cell]));
    }
  }

  double judge(const std::vector<Observed>& test) const {
    double left = 0.0;
    for (const Observed& o : test) {
      for (size_t k = 0; k < o.y.size(); ++k) left += std::pow(o.y[k] - get_value(find(o, k), get_beside(o, k)), 2);
    }
    return 1.0 - left / get_squares(test);
  }

  double get_value(size_t cell, double beside) const { return make_row(beside).dot(parabolas_[cell]); }
  const std::vector<double>& edges() const { return edges_; }

 private:
  static constexpr double kRidge = 1e-3;  // of the samples of a cell: an empty cell then has the value 0

  double get_beside(const Observed& o, size_t k) const {
    return beside_ < 0 ? 0.0 : o.x[static_cast<size_t>(beside_)][k];
  }

  double find_largest(const Observed& o) const {
    double largest = 1e-12;
    for (size_t k = 0; k < o.y.size(); ++k) largest = std::max(largest, std::abs(get_beside(o, k)));
    return largest;
  }

  Eigen::Vector3d make_row(double beside) const {
    const double x = std::min(1.0, std::max(-1.0, beside / scale_));
    return {1.0, x, x * x};
  }

  size_t find(const Observed& o, size_t k) const {
    const double x = o.x[static_cast<size_t>(quantity_)][k];
    return static_cast<size_t>(std::upper_bound(edges_.begin(), edges_.end(), x) - edges_.begin());
  }

  int quantity_, beside_;
  std::vector<double> edges_;
  std::vector<Eigen::Vector3d> parabolas_;
  double scale_ = 1e-12;
};

// Share of squares of an oscillation, alone or times a quantity. Amplitude and phase are fitted to each recording.
double judge_oscillation(const std::vector<Observed>& recordings, double frequency, int factor) {
  double taken = 0.0;
  for (const Observed& o : recordings) {
    Eigen::Matrix2d A = Eigen::Matrix2d::Identity() * 1e-12;
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    for (size_t k = 0; k < o.y.size(); ++k) {
      const double scale = factor < 0 ? 1.0 : o.x[static_cast<size_t>(factor)][k], w = 2.0 * M_PI * frequency;
      const Eigen::Vector2d row(scale * std::cos(w * o.time[k]), scale * std::sin(w * o.time[k]));
      A += row * row.transpose();
      b += row * o.y[k];
    }
    taken += b.dot(A.ldlt().solve(b));
  }
  return taken / get_squares(recordings);
}

double find_length(const std::vector<Observed>& recordings) {
  double longest = 1.0;
  for (const Observed& o : recordings)
    longest = std::max(longest, o.time.empty() ? 0.0 : o.time.back() - o.time.front());
  return longest;
}

// A function of a quantity: centres of the table's inner intervals, and its values there.
struct Curve {
  std::vector<double> x, y;
};

// Range in which a function acts, if it is a small part of the quantity's range.
std::string describe_range(const Curve& curve, const std::string& unit) {
  if (curve.x.size() < 6) return "";
  const double middle = find_median(curve.y);
  double height = 0.0;
  for (double y : curve.y) height = std::max(height, std::abs(y - middle));
  size_t first = curve.y.size(), last = 0;
  for (size_t i = 0; i < curve.y.size(); ++i) {
    if (std::abs(curve.y[i] - middle) > kPart * height) {
      first = std::min(first, i);
      last = i;
    }
  }
  if (first > last || curve.x[last] - curve.x[first] > kHalf * (curve.x.back() - curve.x.front())) return "";
  if (last + 1 == curve.x.size()) return format(" above %.3g ", curve.x[first]) + unit;
  if (first == 0) return format(" below %.3g ", curve.x[last]) + unit;
  return format(" between %.3g and %.3g ", curve.x[first], curve.x[last]) + unit;
}

// Exponent of an odd power of the quantity, if one fits.
std::string describe_power(const Curve& curve) {
  std::vector<std::pair<double, double>> points;  // logarithms
  double height = 0.0;
  for (double y : curve.y) height = std::max(height, std::abs(y));
  for (size_t i = 0; i < curve.x.size(); ++i) {
    if (std::abs(curve.y[i]) > 0.05 * height && curve.x[i] != 0.0)
      points.push_back({std::log(std::abs(curve.x[i])), std::log(std::abs(curve.y[i]))});
  }
  if (points.size() < 6) return "";
  double mx = 0.0, my = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  for (const auto& p : points) {
    mx += p.first / points.size();
    my += p.second / points.size();
  }
  for (const auto& p : points) {
    xx += std::pow(p.first - mx, 2);
    xy += (p.first - mx) * (p.second - my);
    yy += std::pow(p.second - my, 2);
  }
  if (xy * xy < kNearlyAll * xx * yy) return "";
  return format(", about as its power %.2g", xy / xx);
}

class Finder {
 public:
  Finder(const std::vector<Regressor>& quantities, const std::vector<Observed>& train,
         const std::vector<Observed>& test)
      : quantities_(quantities), train_(train), test_(test) {}

  Relation run() {
    const int time = find("time"), load = find("load");
    repeats_ = does_repeat();
    std::vector<double> alone;
    for (int i = 0; i < count(); ++i) alone.push_back(repeats_ && i == time ? 0.0 : judge_alone(i));
    Oscillation swing, driven;
    const double lowest = 2.0 / find_length(train_);
    if (time >= 0) swing = find_oscillation(train_, test_, lowest);
    if (moves_like(swing)) swing.share = 0.0;
    if (time >= 0 && load >= 0) driven = find_oscillation(train_, test_, lowest, load);
    double best = swing.share - kBlur;  // in an oscillating motion, everything oscillates
    for (double share : alone) best = std::max(best, share);

    Relation one;
    one.share = best;
    const bool swings = swing.share - kBlur >= best;
    const int direction = find("direction");
    const bool by_direction = direction >= 0 && alone[static_cast<size_t>(direction)] >= best - kBlur;
    for (int i = 0; i < count(); ++i) {
      const bool contained = (by_direction && i == find("velocity")) || (swings && i == time);
      if (alone[static_cast<size_t>(i)] >= best - kBlur && !contained) add(i, describe(i), &one);
    }
    if (swings) add(time, describe(swing), &one);
    Relation two = find_pair();
    if (driven.share > two.share) {
      two = {driven.share, {}, ""};
      add(load, "", &two);
      add(time, describe(driven), &two);
    }
    // A second quantity must leave less than the first one leaves, and explain more of the whole.
    const bool second = 1.0 - two.share < kLargely * (1.0 - one.share) && two.share > one.share + kMinor;
    const Relation& chosen = second ? two : one;
    return chosen.share > kDetail ? chosen : Relation{};
  }

 private:
  int count() const { return static_cast<int>(quantities_.size()); }

  int find(const std::string& name) const {
    for (int i = 0; i < count(); ++i) {
      if (quantities_[static_cast<size_t>(i)].name == name) return i;
    }
    return -1;
  }

  // The recordings with a quantity minus its mean as the series.
  static std::vector<Observed> take(std::vector<Observed> recordings, int quantity) {
    for (Observed& o : recordings) {
      o.y = o.x[static_cast<size_t>(quantity)];
      const double mean =
          std::accumulate(o.y.begin(), o.y.end(), 0.0) / static_cast<double>(std::max<size_t>(1, o.y.size()));
      for (double& y : o.y) y -= mean;
    }
    return recordings;
  }

  // True if all recordings contain the same motion. Then time explains everything that the motion explains.
  bool does_repeat() const {
    const int time = find("time"), position = find("position");
    if (time < 0 || position < 0) return false;
    return Table(take(train_, position), time, kFine).judge(take(test_, position)) > kHalf;
  }

  // True if the joint itself moves at that frequency. The cause may then be anything that follows the motion.
  bool moves_like(const Oscillation& o) const {
    for (const char* name : {"position", "velocity"}) {
      const int quantity = find(name);
      if (quantity >= 0 && judge_oscillation(take(test_, quantity), o.frequency, -1) > kHalf * o.share) return true;
    }
    return false;
  }

  double judge_alone(int i) const {
    double share = std::max(Table(train_, i, kCoarse).judge(test_), Table(train_, i, kFine).judge(test_));
    // The velocity contains the direction.
    if (i == find("velocity") && find("direction") >= 0)
      share = std::max(share, Table(train_, find("direction"), kCoarse, i).judge(test_));
    return share;
  }

  bool is(int i, const char* name) const { return quantities_[static_cast<size_t>(i)].name == name; }

  bool is_other_joint(int i) const { return is(i, "position") && quantities_[static_cast<size_t>(i)].unit.empty(); }

  bool is_pair(int i, int j) const {
    if (i == j || (is(i, "direction") && is(j, "velocity")) || (is(i, "velocity") && is(j, "direction"))) return false;
    if (repeats_ && (is(i, "time") || is(j, "time"))) return false;
    // A coupling acts on both positions, the joint's own and the other's.
    const bool other_i = is_other_joint(i), other_j = is_other_joint(j);
    if (other_i || other_j) return other_i != other_j && is(i, "position") && is(j, "position");
    return quantities_[static_cast<size_t>(i)].pairs && quantities_[static_cast<size_t>(j)].pairs;
  }

  Relation find_pair() const {
    Relation best;
    int first = -1, second = -1;
    for (int i = 0; i < count(); ++i) {
      for (int j = 0; j < count(); ++j) {
        if (!is_pair(i, j)) continue;
        for (int fine : {kCoarse, kFine}) {
          const double share = Table(train_, i, fine, j).judge(test_);
          if (share > best.share) {
            best.share = share;
            first = i;
            second = j;
          }
        }
      }
    }
    if (first < 0) return best;
    add(first, describe_beside(first, second), &best);
    add(second, describe_beside(second, first), &best);
    return best;
  }

  void add(int i, const std::string& more, Relation* relation) const {
    const Regressor& quantity = quantities_[static_cast<size_t>(i)];
    if (!has(relation->names, quantity.name)) relation->names.push_back(quantity.name);
    relation->words += (relation->words.empty() ? "" : ", ") + quantity.words + more;
  }

  std::string describe(const Oscillation& o) const { return format(", %.3g times a second", o.frequency); }

  std::string describe(int i) const {
    const Regressor& quantity = quantities_[static_cast<size_t>(i)];
    if (quantity.unit.empty()) return "";
    const Table table(train_, i, kFine);
    const Curve curve = make_curve(table, [&](size_t cell) { return table.get_value(cell, 0.0); });
    const std::string range = describe_range(curve, quantity.unit);
    return range.empty() && quantity.name == "velocity" ? describe_power(curve) : range;
  }

  // For friction that depends on a quantity: half the difference of both directions.
  std::string describe_beside(int i, int other) const {
    const Regressor& quantity = quantities_[static_cast<size_t>(i)];
    if (quantity.unit.empty() || quantities_[static_cast<size_t>(other)].name != "direction") return "";
    const Table table(train_, i, kFine, other);
    const Curve curve = make_curve(
        table, [&](size_t cell) { return 0.5 * (table.get_value(cell, 1.0) - table.get_value(cell, -1.0)); });
    return describe_range(curve, quantity.unit);
  }

  // Uses the intervals that are bounded on both sides.
  template <class Get>
  static Curve make_curve(const Table& table, Get get) {
    Curve curve;
    const std::vector<double>& edges = table.edges();
    for (size_t i = 0; i + 1 < edges.size(); ++i) {
      curve.x.push_back(0.5 * (edges[i] + edges[i + 1]));
      curve.y.push_back(get(i + 1));
    }
    return curve;
  }

  const std::vector<Regressor>& quantities_;
  const std::vector<Observed>&train_, &test_;
  bool repeats_ = false;
};

}  // namespace

Oscillation find_oscillation(const std::vector<Observed>& train, const std::vector<Observed>& test, double lowest,
                             int factor) {
  Oscillation best;
  const double step = 0.2 / find_length(train);
  for (double f = lowest; f < kHighest; f += step) {
    const double share = judge_oscillation(train, f, factor);
    if (share > best.share) best = {f, share};
  }
  best.share = judge_oscillation(test, best.frequency, factor);
  return best;
}

Relation find_relation(const std::vector<Regressor>& quantities, const std::vector<Observed>& train,
                       const std::vector<Observed>& test) {
  return Finder(quantities, train, test).run();
}

}  // namespace hrp::diagnosis
