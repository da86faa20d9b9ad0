// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/drifting_zeros.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "common/base/format.h"
#include "diagnosis/data/mean.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/checks/weight_check.h"
#include "diagnosis/floating/equations/equations.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/log/clip_maker.h"
#include "diagnosis/floating/log/contacts.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr int kAxes = 6;
constexpr size_t kParts = kStretches;  // of each group: how much a zero differs within it tells how much it may differ
constexpr double kChance = 1e-3;       // of one false drift in so many clean robots

// One row of an equation, in units of what is left of that equation.
struct Row {
  size_t part = 0;  // group * kParts + part of it
  double y = 0;
  Eigen::VectorXd constant;  // by what stays as it is: masses, scales, soles, joints
  Eigen::VectorXd zero;      // by the zero of each axis of each sensor
};

// Probability that values of the same mean have such a variance between groups: F with two degrees of freedom exactly,
// with a few more to a small factor.
double calc_chance(double between, double within, double groups, double freedom) {
  const double f = within > 0 ? between / within : 0;
  return std::pow(1 + f * (groups - 1) / freedom, -0.5 * freedom);
}

// `done`: share of a recording's time. Each stretch's zero is that of its middle; between the middles and beyond them a
// zero goes on evenly.
double find_zero_at(double done, const std::vector<double>& stretches) {
  const size_t n = stretches.size();
  if (n < 2) return stretches[0];
  const double place = done * static_cast<double>(n) - kHalf;
  const auto from = static_cast<size_t>(std::clamp(place, 0.0, static_cast<double>(n - 2)));
  return stretches[from] + (place - static_cast<double>(from)) * (stretches[from + 1] - stretches[from]);
}

class DriftFinder {
 public:
  DriftFinder(const LeggedLog& log, bool walks, const std::vector<ChannelRows>& channels)
      : log_(log),
        walks_(walks),
        layout_(log),
        zeros_(kAxes * layout_.sensors),
        stretches_(count_stretches(log.experiment->recordings.size())),
        groups_(stretches_ * log.experiment->recordings.size()) {
    list_constants();
    for (const ChannelRows* c : list_equations(channels)) add_rows(*c);
  }

  ZeroDrift run() {
    ZeroDrift out;
    const std::vector<size_t> counts = count_rows();
    if (*std::min_element(counts.begin(), counts.end()) < kFewestOfItsOwn || !solve()) return out;
    for (int z = 0; z < zeros_; ++z) chances_.push_back(find_chance(z));
    if (*std::min_element(chances_.begin(), chances_.end()) > kChance / zeros_) return out;
    // Now that zeros are known to drift, what differs between recordings is theirs first.
    if (solve(kDetail)) write(&out);
    return out;
  }

 private:
  // Each with the size that it has in a usual robot: a tenth of a link's mass, a centimetre, faults of 0.02 or 0.1
  // m/s^2. What the motion within recordings tells of them counts more than that.
  void list_constants() {
    const auto add = [&](int first, int count, double prior) {
      for (int i = 0; i < count; ++i) constants_.push_back({first + i, prior});
    };
    for (int l = 0; l < layout_.links; ++l) {
      const double mass = log_.tree.links[static_cast<size_t>(l)].inertia.mass;
      if (mass > 0) {
        add(layout_.link(l, 0), 1, kDetail * mass);
        add(layout_.link(l, 1), 3, kDetail * kHalfFoot * mass);
      }
    }
    for (int s = 0; s < layout_.sensors; ++s) {
      add(layout_.sensor(s, kForceScaleColumn), 2, kKnown);
      add(layout_.sensor(s, kWrenchTurnColumn), 3, kKnown);
    }
    for (int i = 0; i < layout_.imus; ++i) {
      add(layout_.imu(i, kAccelerometerTurnColumn), 3, kKnown);
      add(layout_.imu(i, kAccelerometerBiasColumn), 3, kDetail);
    }
    for (int j = 0; j < layout_.joints; ++j) add(layout_.joint(j, kOffsetColumn), 1, kKnown);
  }

  // The balance of the whole body, else its weight.
  static std::vector<const ChannelRows*> list_equations(const std::vector<ChannelRows>& channels) {
    std::vector<const ChannelRows*> out, weight;
    for (const ChannelRows& c : channels) {
      if (c.info.equation.is_balance())
        out.push_back(&c);
      else if (c.info.equation.is_vertical_force())
        weight.push_back(&c);
    }
    return out.empty() ? weight : out;
  }

  void add_rows(const ChannelRows& c) {
    const double spread = calc_rms(c.y);
    if (spread <= 0) return;
    const auto get = [&](size_t i, int column) {
      const int at = c.find_column(column);
      return at < 0 ? 0.0 : c.row(i)[at] / spread;
    };
    for (size_t i = 0; i < c.rows(); ++i) {
      const auto r = static_cast<size_t>(c.recording[i]);
      const std::vector<double>& time = log_.experiment->recordings[r].time;
      Row row;
      const double done = (c.time[i] - time.front()) / std::max(1e-9, time.back() - time.front());
      const size_t parts = stretches_ * kParts;
      row.part = r * parts + std::min(parts - 1, static_cast<size_t>(done * static_cast<double>(parts)));
      row.y = c.y[i] / spread;
      row.constant.resize(static_cast<long>(constants_.size()));
      row.zero.resize(zeros_);
      for (size_t k = 0; k < constants_.size(); ++k) row.constant(static_cast<long>(k)) = get(i, constants_[k].column);
      for (int z = 0; z < zeros_; ++z) row.zero(z) = get(i, layout_.sensor(z / kAxes, kForceBiasColumn + z % kAxes));
      rows_.push_back(std::move(row));
    }
  }

  std::vector<size_t> count_rows() const {
    std::vector<size_t> out(kParts * groups_, 0);
    for (const Row& row : rows_) ++out[row.part];
    return out;
  }

  // [N], [N m] Of drifts that the equations cannot tell apart, the one that is smallest beside these is taken.
  double find_prior(int zero) const {
    const double weight = log_.mass * log_.experiment->scenario.gravity_W.norm();
    return kDetail * weight * (zero % kAxes < 3 ? 1 : kHalfFoot);
  }

  long at(size_t part, int zero) const {
    return static_cast<long>(constants_.size()) + static_cast<long>(part) * zeros_ + zero;
  }

  // Zeros go on while one long recording lasts as they do from one to the next. Where too few recordings follow one
  // another to agree, their stretches do.
  static size_t count_stretches(size_t recordings) {
    return recordings < kFewestToAgree ? kStretches / std::max<size_t>(1, recordings) : 1;
  }

  // Constants of all groups beside zeros of each part, in one least squares.
  bool solve(double trust = 1) {
    const auto n = static_cast<long>(constants_.size());
    const long all = at(groups_ * kParts, 0);
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(all, all);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(all);
    for (const Row& row : rows_) {
      const long own = at(row.part, 0);
      A.topLeftCorner(n, n).selfadjointView<Eigen::Lower>().rankUpdate(row.constant);
      A.block(own, 0, zeros_, n).noalias() += row.zero * row.constant.transpose();
      A.block(own, own, zeros_, zeros_).noalias() += row.zero * row.zero.transpose();
      b.head(n) += row.constant * row.y;
      b.segment(own, zeros_) += row.zero * row.y;
    }
    for (long k = 0; k < n; ++k) A(k, k) += 1 / std::pow(trust * constants_[static_cast<size_t>(k)].prior, 2);
    for (size_t p = 0; p < groups_ * kParts; ++p) {
      for (int z = 0; z < zeros_; ++z) A(at(p, z), at(p, z)) += 1 / std::pow(find_prior(z), 2);
    }
    x_ = Eigen::MatrixXd(A.selfadjointView<Eigen::Lower>()).ldlt().solve(b);
    return x_.allFinite();
  }

  std::string get_column(int z) const {
    return get_force_column(log_.sensors[static_cast<size_t>(z / kAxes)].name, z % kAxes);
  }

  double get_part(size_t group, size_t part, int z) const { return x_(at(group * kParts + part, z)); }
  double find_middle(size_t group, int z) const {
    double sum = 0;
    for (size_t p = 0; p < kParts; ++p) sum += get_part(group, p, z) / kParts;
    return sum;
  }

  double find_mean(int z) const {
    double sum = 0;
    for (size_t g = 0; g < groups_; ++g) sum += find_middle(g, z) / static_cast<double>(groups_);
    return sum;
  }

  // What drifts between groups does so within them: one slope of all of them is no scatter.
  double get_freedom() const { return static_cast<double>(groups_ * (kParts - 1) - 1); }

  // From one part of a group to the next one.
  double find_slope(int z) const {
    double xy = 0, xx = 0;
    for (size_t g = 0; g < groups_; ++g) {
      for (size_t p = 0; p < kParts; ++p) {
        xy += get_place(p) * get_part(g, p, z);
        xx += get_place(p) * get_place(p);
      }
    }
    return xy / xx;
  }
  static double get_place(size_t part) { return static_cast<double>(part) - 0.5 * (kParts - 1); }

  // Of the zeros of one group's parts. Zeros wander while a part lasts, so that neighbours resemble each other: two of
  // them count as one.
  double find_variance_within(int z) const {
    double sum = 0;
    const double slope = find_slope(z);
    for (size_t g = 0; g < groups_; ++g) {
      for (size_t p = 0; p < kParts; ++p)
        sum += std::pow(get_part(g, p, z) - find_middle(g, z) - slope * get_place(p), 2);
    }
    return sum / get_freedom();
  }

  double find_chance(int z) const {
    double between = 0;
    const auto n = static_cast<double>(groups_);
    for (size_t g = 0; g < groups_; ++g)
      between += static_cast<double>(kParts) * std::pow(find_middle(g, z) - find_mean(z), 2) / (n - 1);
    return is_steady(z) ? calc_chance(between, find_variance_within(z), n, 0.5 * get_freedom()) : 1;
  }

  // From each group to the next one the same way.
  bool is_steady(int z) const {
    int up = 0, down = 0;
    for (size_t g = 1; g < groups_; ++g) ++(find_middle(g, z) > find_middle(g - 1, z) ? up : down);
    return up == 0 || down == 0;
  }

  void write(ZeroDrift* out) const {
    for (int z = 0; z < zeros_; ++z) {
      std::vector<std::vector<double>>& by_recording = out->zero[get_column(z)];
      by_recording.resize(log_.experiment->recordings.size());
      for (size_t g = 0; g < groups_; ++g) by_recording[g / stretches_].push_back(find_middle(g, z) - find_mean(z));
    }
    std::vector<Finding> all;
    for (int first = 0; first < zeros_; first += 3) {
      if (log_.experiment->recordings[0].other.count(get_column(first)) == 0) continue;
      const auto own = chances_.begin() + first, clearest = std::min_element(own, own + 3);
      all.push_back(make_one_finding(first, static_cast<int>(clearest - chances_.begin())));
      if (*clearest <= kChance / zeros_) out->findings.push_back(all.back());
    }
    join(all, &out->findings);
  }

  // The value is how far the zero goes from the first to the last group.
  Finding make_one_finding(int first, int clearest) const {
    Estimate value{"value", first % kAxes == 0 ? "N" : "N m", {}, {}, true};
    for (int z = first; z < first + 3; ++z) {
      value.value.push_back(find_middle(groups_ - 1, z) - find_middle(0, z));
      value.std.push_back(std::sqrt(2 * find_variance_within(z) / kParts));
    }
    const std::string column = get_column(clearest), sensor = column.substr(0, column.rfind('/')),
                      axis = column.substr(sensor.rfind('/') + 1);
    Finding f = make_finding(get_laws().sensor_bias.info(), {{"sensor", sensor}}, {value});
    std::string each;
    for (size_t g = 0; g < groups_; ++g)
      each += (g ? ", " : "") + format("%+.3g", find_middle(g, clearest) - find_mean(clearest));
    f.statement = sensor + ": its zero drifts, by " + each + " " + value.unit + " about " + axis +
                  " from its mean, in the order of the " + (stretches_ > 1 ? "stretches" : "recordings") + " (" +
                  get_grade_name(Grade::kSupported) +
                  "). The readings were rid of it before anything else was looked for.";
    f.grade = Grade::kSupported;
    f.probability = 0.95;
    f.share = kHalf;
    f.weight = kHalf;
    return f;
  }

  // Feet that stay add up to one force and one moment: whose zero it is, is not told.
  void join(std::vector<Finding> all, std::vector<Finding>* findings) const {
    const auto size = [](const Finding& f) {
      return Eigen::Map<const Eigen::Vector3d>(f.parameters[0].value.data()).norm() /
             (f.parameters[0].unit == "N" ? 1 : kHalfFoot);
    };
    for (std::vector<Finding>* list : {&all, findings}) {
      std::stable_sort(list->begin(), list->end(),
                       [&](const Finding& a, const Finding& b) { return size(a) > size(b); });
    }
    if (walks_) return;
    Finding first = findings->front();
    for (const Finding& other : all) {
      if (other.where == first.where) continue;
      first.alternatives.push_back(make_alternative(get_laws().sensor_bias.info(), other.where, other.parameters,
                                                    "each foot lifted in turn, in every recording"));
    }
    first.grade = Grade::kAmbiguous;
    first.statement = say_ambiguous(first.statement) +
                      " Feet that stay tell what all zeros together differ by, not whose they are; a load or a pull in "
                      "some of the recordings looks the same.";
    findings->assign(1, first);
  }

  struct Constant {
    int column;
    double prior;
  };
  const LeggedLog& log_;
  bool walks_;
  ColumnLayout layout_;
  int zeros_;
  size_t stretches_, groups_;  // of each recording, of all of them
  std::vector<Constant> constants_;
  std::vector<Row> rows_;
  Eigen::VectorXd x_;
  std::vector<double> chances_;  // by zero
};

}  // namespace

ZeroDrift find_zero_drift(const Experiment& e) {
  const LeggedLog log = make_legged_log(e, Half::kEven);
  if (log.clips.empty() || log.sensors.empty()) return {};
  const Contacts contacts = find_contacts(log);
  const std::vector<ChannelRows> channels = make_equations(log, contacts).channels();
  return has_raw_counts(log, contacts, channels, ColumnLayout(log)) ? ZeroDrift{}
                                                                    : DriftFinder(log, contacts.walks, channels).run();
}

Experiment take_out(const ZeroDrift& drift, Experiment e) {
  for (const auto& [name, zero] : drift.zero) {
    for (size_t r = 0; r < e.recordings.size(); ++r) {
      const auto column = e.recordings[r].other.find(name);
      if (column == e.recordings[r].other.end()) continue;
      const std::vector<double>& time = e.recordings[r].time;
      const double whole = std::max(1e-9, time.back() - time.front());
      for (size_t k = 0; k < time.size(); ++k)
        column->second[k] -= find_zero_at((time[k] - time.front()) / whole, zero[r]);
    }
  }
  return e;
}

}  // namespace hrp::diagnosis::floating
