// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/fit/regimes.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/estimate/robust.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/fit/candidate_laws.h"

namespace hrp::diagnosis::floating {
namespace {

// Sizes of an effect are relative to its size in the whole fit: 1 is the same.
constexpr double kMost = 2;  // largest size of one law: laws harden, and other effects are beside it

// What one row tells of the size of an effect. With z what the effect predicts there and r what the fit leaves, zr / zz
// is by how much the size should change.
struct Product {
  size_t channel = 0, row = 0;
  double zz = 0, zr = 0;  // weighted, without the square of the noise
  double size = 0;        // of z, in the unit of the row
  int block = 0, phase = 0;
  double roughness = 0;
  double bears = -1;         // [N] reading of the sensor whose zero or scale the effect is; -1: it is of none
  double load = 0, arm = 0;  // [N] force on a sole, [m] how far from its middle it presses
};

// An effect without the coefficients that may differ between regimes. Of a sole: its give without its damping, because
// a foot that comes down on its edge turns while it lands, which looks like damping.
Candidate take_core(const Candidate& effect, Eigen::VectorXd* x) {
  const std::vector<long>& core = effect.law->core;
  if (core.empty()) return effect;
  Candidate out = effect;
  Eigen::VectorXd own(static_cast<long>(core.size()));
  out.terms.clear();
  out.prior.clear();
  for (long k = 0; k < own.size(); ++k) {
    const long from = core[static_cast<size_t>(k)];
    own(k) = (*x)(from);
    out.terms.push_back(effect.terms[static_cast<size_t>(from)]);
  }
  *x = own;
  return out;
}

// Whether it adds a constant to a reading, or a share of the reading.
bool is_zero_or_scale(const Candidate& c) {
  if (!c.is_listed()) return false;
  const ReadingChange& change = c.info().change;
  return change.constant != 0 || change.of_reading != 0;
}

class Splitter {
 public:
  Splitter(const LeggedFitter& fitter, const LeggedFit& fit, size_t effect, const ColumnLayout& layout)
      : fitter_(fitter), layout_(layout) {
    const Candidate& c = fit.effects[effect];
    const bool of_one_sensor =
        c.place >= 0 && c.place < layout.sensors && c.where.dump().find("/wrench/") != std::string::npos;
    if (of_one_sensor && is_zero_or_scale(c)) reading_ = layout.sensor(c.place, kForceScaleColumn);
    for (size_t c = 0; c < fitter.channels().size(); ++c) add_channel(c, fit, effect);
  }

  std::vector<Regime> run() {
    std::map<int, std::vector<Product>> phases;
    for (const Product& p : all_) phases[p.phase].push_back(p);
    for (const auto& [phase, rows] : phases) add(RegimeKind::kPhase, "phase " + std::to_string(phase), rows);
    const std::vector<Product> calm = take(
        all_, [](const Product& p) { return p.roughness; }, 0, 0.5);
    add(RegimeKind::kCalm, "calm", calm);
    add(RegimeKind::kRough, "rough",
        take(
            all_, [](const Product& p) { return p.roughness; }, 0.5, 1));
    add_soles();
    add_bearing();
    return std::move(out_);
  }

 private:
  // Places of a sole's force and moment in the rows of its tilt; -1: none.
  std::pair<int, int> find_press(const ChannelRows& rows) const {
    std::pair<int, int> out{-1, -1};
    for (size_t i = 0; i < rows.columns.size(); ++i) {
      const int at = rows.columns[i] - layout_.foot(0, 0), kind = at % kFootColumns;
      if (at < 0 || at >= kFootColumns * layout_.feet) continue;
      if (kind == kRollShiftColumn || kind == kPitchShiftColumn) out.first = static_cast<int>(i);
      if (kind == kRollGiveColumn || kind == kPitchGiveColumn) out.second = static_cast<int>(i);
    }
    return out.second < 0 ? std::pair<int, int>{-1, -1} : out;
  }

  void add_channel(size_t c, const LeggedFit& fit, size_t effect) {
    const ChannelRows& rows = fitter_.channels()[c];
    Eigen::VectorXd x = fit.get(effect);
    const std::vector<Candidate> one{take_core(fit.effects[effect], &x)};
    const Eigen::VectorXd z = fitter_.calc_columns(c, one, false) * x;
    if (rows.rows() == 0 || z.isZero(0)) return;
    const Eigen::VectorXd n = fitter_.calc_columns(c, one, true) * x;
    const std::pair<int, int> press = find_press(rows);
    const int reading = find_reading(rows);
    const std::vector<double> r = fitter_.calc_residuals(fit, c), e = fitter_.calc_residuals(fit, c, true);
    for (size_t i = 0; i < rows.rows(); ++i) {
      const auto k = static_cast<long>(i);
      const double w = fitter_.get_weight(c, i);
      Product p{c,
                i,
                w * (z(k) * z(k) - n(k) * n(k)),
                w * (z(k) * r[i] - n(k) * e[i]),
                std::abs(z(k)),
                rows.block[i],
                rows.phase[i],
                rows.roughness[i]};
      if (press.first >= 0) {
        p.load = rows.row(i)[press.first];
        p.arm = std::abs(rows.row(i)[press.second]) / std::max(1e-9, p.load);
      }
      if (reading >= 0) p.bears = std::abs(rows.row(i)[reading]);
      all_.push_back(p);
    }
  }

  // Place of a sensor's reading in the rows of the feet's sum of vertical forces; -1: none.
  int find_reading(const ChannelRows& rows) const {
    if (reading_ < 0 || !rows.info.equation.is_vertical_force()) return -1;
    return rows.find_column(reading_);
  }

  // Compares rows in which the foot bears little and much. A zero is the same in both, and the error of a scale grows
  // with the load: so a scale does not pass for a zero.
  void add_bearing() {
    std::vector<Product> felt;
    for (const Product& p : all_) {
      if (p.bears >= 0) felt.push_back(p);
    }
    if (felt.empty()) return;
    const auto by_load = [](const Product& p) { return p.bears; };
    add(RegimeKind::kLittle, "the foot bears little", take(felt, by_load, 0, 0.25));
    add(RegimeKind::kMuch, "the foot bears much", take(felt, by_load, 0.75, 1));
  }

  // The rows between two shares (0 to 1) of all information on the effect, in the order of a key.
  template <class Key>
  static std::vector<Product> take(std::vector<Product> rows, const Key& key, double from, double to) {
    std::stable_sort(rows.begin(), rows.end(), [&](const Product& a, const Product& b) { return key(a) < key(b); });
    double total = 0, so_far = 0;
    for (const Product& p : rows) total += p.zz;
    std::vector<Product> out;
    for (const Product& p : rows) {
      if (so_far >= from * total && so_far < to * total) out.push_back(p);
      so_far += p.zz;
    }
    return out;
  }

  void add(RegimeKind kind, const std::string& name, const std::vector<Product>& rows, double least = 0.5) {
    double zz = 0, zr = 0;
    for (const Product& p : rows) {
      zz += p.zz;
      zr += p.zr;
    }
    if (zz <= 0) return;
    const double more = zr / zz;
    std::map<int, double> scores;
    for (const Product& p : rows) scores[p.block] += p.zr - more * p.zz;
    double scatter = 0;
    for (const auto& [block, score] : scores) scatter += score * score;
    // An equation may err by its exactness in line with the effect, in all rows of the regime.
    std::map<size_t, double> exact;
    for (const Product& p : rows)
      exact[p.channel] += fitter_.get_weight(p.channel, p.row) * fitter_.find_exactness(p.channel) * p.size;
    for (const auto& [channel, score] : exact) scatter += score * score;
    if (scores.size() <= 3) return;
    // Of few blocks: a short walk has some steps of each foot.
    const double few = std::sqrt(find_few(static_cast<double>(scores.size()))) * find_widening(scores.size());
    out_.push_back({kind, name, 1 + more, few * std::sqrt(scatter) / zz, least});
  }

  // A sole that carries much and presses near its middle lies flat for certain. A sole that gives turns there, too. A
  // rigid one that rolls over its edge does not.
  void add_soles() {
    std::vector<Product> soles;
    for (const Product& p : all_) {
      if (p.load > 0) soles.push_back(p);
    }
    if (soles.empty()) return;
    const std::vector<Product> loaded = take(
        soles, [](const Product& p) { return p.load; }, 0.5, 1);
    add(RegimeKind::kMiddle, "pressed in the middle",
        take(
            loaded, [](const Product& p) { return p.arm; }, 0, 0.25),
        kMostly);
  }

  const LeggedFitter& fitter_;
  const ColumnLayout& layout_;
  int reading_ = -1;  // column of the reading of the sensor whose zero or scale it is
  std::vector<Product> all_;
  std::vector<Regime> out_;
};

// Whether two regimes differ by more than a law that hardens does, and by more than chance does.
bool are_apart(const Regime& a, const Regime& b) {
  const double most = std::max(a.size, b.size), least = std::min(a.size, b.size);
  return std::max(a.std, b.std) < kMinority && most > kMost * least &&
         most - least > kUnlikely * std::hypot(a.std, b.std);
}

bool are_apart(const std::vector<Regime>& regimes, RegimeKind first, RegimeKind second) {
  const auto find = [&](RegimeKind kind) {
    return std::find_if(regimes.begin(), regimes.end(), [&](const Regime& r) { return r.kind == kind; });
  };
  const auto a = find(first), b = find(second);
  return a != regimes.end() && b != regimes.end() && are_apart(*a, *b);
}

}  // namespace

std::vector<Regime> list_regimes(const LeggedFitter& fitter, const LeggedFit& fit, size_t effect,
                                 const ColumnLayout& layout) {
  return Splitter(fitter, fit, effect, layout).run();
}

bool is_steady(const std::vector<Regime>& regimes) {
  if (are_apart(regimes, RegimeKind::kLittle, RegimeKind::kMuch)) return false;
  return std::none_of(regimes.begin(), regimes.end(), [](const Regime& r) {
    const bool far = r.size < r.least || r.size > kMost, by_chance = std::abs(r.size - 1) <= kUnlikely * r.std;
    if (r.least == kMostly) return far && r.std < kMinority;
    // A size with the other sign is wrong even where it is not told exactly.
    return !by_chance && ((far && r.std < kMinority) || (r.size < 0 && r.std < kHalf));
  });
}

double find_phase_spread(const std::vector<Regime>& regimes) {
  double out = 0;
  for (const Regime& r : regimes) {
    const double away = std::abs(r.size - 1);
    if (r.kind == RegimeKind::kPhase && r.std < kMinority && away > kUnlikely * r.std) out = std::max(out, away);
  }
  return out;
}

bool is_alike(const std::vector<Regime>& regimes) { return !are_apart(regimes, RegimeKind::kCalm, RegimeKind::kRough); }

}  // namespace hrp::diagnosis::floating
