// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/weight_check.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "diagnosis/data/mean.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/robust.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/checks/foot_scales.h"
#include "diagnosis/floating/equations/equations.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/log/body_motion.h"
#include "diagnosis/floating/log/foot_sensors.h"
#include "diagnosis/floating/log/whole_readings.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr const char* kMotion = "the robot on a scale; one more load of known mass";

// What rows have, by phase, by block: sum, count.
using PhaseSums = std::map<int, std::map<int, std::pair<double, double>>>;

PhaseSums sum_phases(const ChannelRows& c) {
  PhaseSums out;
  for (size_t i = 0; i < c.rows(); ++i) {
    auto& [sum, count] = out[c.phase[i]][c.block[i]];
    sum += c.y[i];
    count += 1;
  }
  return out;
}

class WeightChecker {
 public:
  WeightChecker(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels,
                const ColumnLayout& layout, CheckResult* out)
      : log_(log), contacts_(contacts), channels_(channels), at_(layout), out_(*out) {}

  void run() {
    const ChannelRows* c = find_weight_equation(channels_);
    if (!c) return;
    const double weight = get_weight();
    const std::vector<double> ratios = list_ratios(*c);
    if (is_in_other_unit(ratios)) return find_units(*c);
    const Consensus k = weigh_parts(*c, ratios);
    const std::string odd = describe_odd(*c, k), phases = describe_phases(*c, weight);
    const std::string carry = format("weight: the feet carry %.4f", k.mean) +
                              (k.kept > 1 ? format(" +- %.4f", 2 * k.std) : "") + " of what the model weighs";
    if (!is_same_in_phases(*c, (k.mean - 1) * weight)) {
      out_.notes.push_back(carry + ", but not the same in all phases: no mass does that." + odd);
      return add_differing(*c, phases);
    }
    if (is_off(k)) return add_weight(k, weight, phases + odd);
    const Consensus main = weigh_main_phase(*c, weight);
    if (is_off(main)) return add_weight(main, weight, phases + describe_odd(*c, main));
    out_.notes.push_back(carry + ": they agree." + odd);
  }

  bool has_raw_counts() const {
    const ChannelRows* c = find_weight_equation(channels_);
    return c && is_in_other_unit(list_ratios(*c));
  }

 private:
  double get_weight() const { return (log_.mass - log_.mass_below) * get_gravity(); }

  // What the feet carry over what the model weighs, by parts of the recordings.
  std::vector<double> list_ratios(const ChannelRows& c) const {
    std::vector<double> out;
    for (const std::vector<double>& y : list_parts(c)) out.push_back(1 + find_median(y) / get_weight());
    return out;
  }

  // Parts of one recording are few, and know their own scatter badly.
  static Consensus weigh_parts(const ChannelRows& c, const std::vector<double>& ratios) {
    Consensus k = find_consensus(ratios, kTrace);
    if (count_recordings(c) == 1 && k.kept > 1) k.std *= find_widening(k.kept);
    return k;
  }

  static bool is_in_other_unit(const std::vector<double>& ratios) {
    const double middle = find_median(ratios);
    return middle > kClearlyMore || middle < 1 / kClearlyMore;
  }

  double get_gravity() const { return log_.experiment->scenario.gravity_W.norm(); }

  // Whether it is a mismatch. Where a foot has no sensor, that foot may bear what the others lack.
  bool is_off(const Consensus& k) const {
    if (k.kept < 2 || std::abs(k.mean - 1) <= std::max(3 * k.std, kTrace)) return false;
    return k.mean > 1 || all_feel(log_);
  }

  // A sentence, or nothing.
  static std::string describe_odd(const ChannelRows& c, const Consensus& k) {
    if (k.odd == 0) return "";
    const std::string part = count_recordings(c) > 1 ? "recording" : "part";
    return format(" %.0f ", static_cast<double>(k.odd)) + part + (k.odd == 1 ? " differs" : "s differ") +
           " by more than chance: the sensors changed in between, or something pushed the robot.";
  }

  // By phase: what the feet carry over what the model weighs, by blocks.
  std::map<int, Consensus> weigh_phases(const ChannelRows& c, double weight) const {
    std::map<int, Consensus> out;
    for (const auto& [phase, blocks] : sum_phases(c)) {
      std::vector<double> ratios;
      for (const auto& [block, sum] : blocks) ratios.push_back(1 + sum.first / sum.second / weight);
      const Consensus k = find_consensus(ratios, kTrace);
      if (k.kept >= kFewestBlocks && phase != 0) out[phase] = k;
    }
    return out;
  }

  std::string name_phase(int phase) const {
    const int all = get_phase_of_all(log_);
    if (phase == all) return "all feet";
    std::string names;
    for (size_t f = 0; f < log_.feet.size(); ++f) {
      if (phase >> f & 1) names += (names.empty() ? "" : " and ") + log_.feet[f].name;
    }
    return names + " alone";
  }

  // Sentences about the phases, if two of them differ by more than chance and than masses do. Empty: they do not.
  std::string describe_phases(const ChannelRows& c, double weight) const {
    const std::map<int, Consensus> phases = weigh_phases(c, weight);
    bool differ = false;
    std::string text;
    for (const auto& [phase, a] : phases) {
      for (const auto& [other, b] : phases) {
        differ = differ || std::abs(a.mean - b.mean) > std::max(kTrace, 3 * std::hypot(a.std, b.std));
      }
      text += (text.empty() ? "" : ", ") + format("%.3f +- %.3f on ", a.mean, 2 * a.std) + name_phase(phase);
    }
    if (!differ) return "";
    return " By phase they carry " + text +
           ". A mass would show the same share in every phase. Scales, zeros and cross-talk of force sensors would "
           "not.";
  }

  void add_differing(const ChannelRows& c, const std::string& phases) {
    if (phases.empty()) return;
    Remaining r;
    r.where = {{"link", log_.tree.links[0].name}};
    r.unit = "N";
    r.before = r.after = calc_rms(c.y);
    r.statement = "What the feet carry does not fit the model's weight." + phases;
    out_.remaining.push_back(std::move(r));
  }

  // By recording, while the robot is in the phase that it is in for most of the time. Steps shake the other phases.
  Consensus weigh_main_phase(const ChannelRows& c, double weight) const {
    std::map<int, size_t> rows;
    for (int phase : c.phase) ++rows[phase];
    int main = 0;
    for (const auto& [phase, count] : rows) {
      if (static_cast<double>(count) > kHalf * static_cast<double>(c.rows())) main = phase;
    }
    std::map<int, std::vector<double>> parts;
    for (size_t i = 0; i < c.rows(); ++i) {
      if (main != 0 && c.phase[i] == main) parts[c.recording[i]].push_back(c.y[i]);
    }
    std::vector<double> ratios;
    for (const auto& [r, y] : parts) {
      if (y.size() >= kFewestToTell) ratios.push_back(1 + find_median(y) / weight);
    }
    return find_consensus(ratios, kTrace);
  }

  static size_t count_recordings(const ChannelRows& c) { return split_by_recording(c).size(); }

  // An equation's rows by recording; of one alone by quarters of half a second at least, which have to agree as
  // recordings do.
  static std::vector<std::vector<double>> list_parts(const ChannelRows& c) {
    std::vector<std::vector<double>> parts;
    for (const auto& [r, y] : split_by_recording(c)) parts.push_back(y);
    const size_t count = parts.size() == 1 ? std::min(static_cast<size_t>(kStretches),
                                                      parts[0].size() / static_cast<size_t>(kBlock / kCell))
                                           : 0;
    if (count < kFewestToAgree) return parts;
    const std::vector<double> whole = std::move(parts[0]);
    parts.clear();
    for (size_t q = 0; q < count; ++q) {
      const auto at = [&](size_t i) { return whole.begin() + static_cast<long>(i * whole.size() / count); };
      parts.emplace_back(at(q), at(q + 1));
    }
    return parts;
  }

  // Whether each phase that is no rare one has half to twice the missing weight [N], as far as its blocks tell.
  bool is_same_in_phases(const ChannelRows& c, double more) const {
    const PhaseSums phases = sum_phases(c);
    const double least = kTrace * log_.mass * get_gravity();
    return std::none_of(phases.begin(), phases.end(), [&](const auto& phase) {
      std::vector<double> means;
      for (const auto& [block, sum] : phase.second) means.push_back(sum.first / sum.second);
      double rows = 0;
      for (const auto& [block, sum] : phase.second) rows += sum.second;
      if (means.size() < kFewestBlocks || rows < kMinority * static_cast<double>(c.rows())) return false;
      const Consensus k = find_consensus(means, least);
      const bool other = k.mean / more < 0.5 || k.mean / more > 2;
      return other && std::abs(k.mean - more) > std::max(least, 3 * k.std);
    });
  }

  // One number, many causes: nothing but other sensors, or another load, can tell them apart.
  void add_weight(const Consensus& k, double weight, const std::string& more_words) {
    const double more = (k.mean - 1) * weight, error = k.std * weight, g = get_gravity();
    const LinkInertia& root = log_.tree.links[0].inertia;
    const double own = std::max(1e-6, root.mass);
    const Where link{{"link", log_.tree.links[0].name}};
    const EffectInfo &heavier = laws_.mass_error.info(), &load = laws_.payload.info();
    const std::vector<Estimate> scale{make_value(heavier, 1 + more / g / own, error / g / own)};
    Finding f = make_finding(heavier, link, scale);
    if (more > 0) {
      f = make_finding(load, link, {make_value(load, more / g, error / g), make_assumed_centre(root.p_LLcm_L)});
      f.alternatives.push_back(make_alternative(heavier, link, scale, kMotion));
    }
    f.grade = Grade::kAmbiguous;
    f.probability = 0.95;
    f.share = 1;
    f.weight = 1;
    f.statement = format("The feet carry %.3f +- %.3f of what the model weighs. ", k.mean, 2 * k.std) +
                  format(more > 0 ? "The model is too light by %.1f %% (%.2f kg, %.1f N)"
                                  : "The model is too heavy by %.1f %% (%.2f kg, %.1f N)",
                         100 * std::abs(k.mean - 1), std::abs(more) / g, std::abs(more)) +
                  ", or the scale or zero of the force sensors is off. Standing and walking alone cannot tell which." +
                  more_words;
    add_sensors(k, more, error, &f);
    const std::vector<FootScale> scales =
        list_foot_scales(weigh_phases(*find_weight_equation(channels_), weight), log_.feet.size());
    const bool scaled = take_foot_scale(log_, scales, kMotion, &f);
    out_.findings.push_back(std::move(f));
    if (scaled) return;
    Candidate mass;
    mass.law = &laws_.payload;
    mass.where = link;
    mass.place = 0;
    mass.terms = {{{at_.link(0, 0), 1.0}}};
    for (int a = 0; a < 3; ++a) mass.terms[0].emplace_back(at_.link(0, 1 + a), root.p_LLcm_L(a));
    out_.weight = {mass};
  }

  void add_sensors(const Consensus& k, double more, double error, Finding* f) const {
    const auto n = static_cast<double>(std::max<size_t>(1, log_.sensors.size()));
    const Where all{{"sensor", log_.sensors.size() > 1 ? "/wrench" : "/wrench/" + log_.sensors[0].name + "/force"}};
    const auto scaled = [&](const Where& where, double value, double std) {
      const EffectInfo& effect = laws_.sensor_scale.info();
      f->alternatives.push_back(make_alternative(effect, where, {make_value(effect, value, std)}, kMotion));
    };
    const auto shifted = [&](const Where& where, double value, double std) {
      const EffectInfo& effect = laws_.sensor_bias.info();
      f->alternatives.push_back(make_alternative(effect, where, {make_value(effect, value, std, "N")}, kMotion));
    };
    scaled(all, k.mean, k.std);
    shifted(all, more / n, error / n);
    for (const ForceSensor& s : log_.sensors) {
      if (log_.sensors.size() < 2) break;
      const Where one{{"sensor", "/wrench/" + s.name + "/force"}};
      shifted(one, more, error);
      // Of feet that bear the weight in turn, one sensor's scale would show in its own phase only.
      const double part = 1 / n;
      if (!contacts_.walks) scaled(one, 1 + (k.mean - 1) / part, k.std / part);
    }
    if (BodyMotion::find_force_source(log_) != MotionSource::kImu) return;
    const auto imu = static_cast<size_t>(BodyMotion::find_main_imu(log_));
    scaled({{"sensor", "/imu/" + log_.imus[imu].name + "/linear_acceleration"}}, 1 / k.mean, k.std);
  }

  // Places of each sensor's reading along the normal in a row.
  std::vector<size_t> find_readings(const ChannelRows& c) const {
    std::vector<size_t> out;
    for (int s = 0; s < at_.sensors; ++s)
      out.push_back(static_cast<size_t>(c.find_column(at_.sensor(s, kForceScaleColumn))));
    return out;
  }

  // Readings beyond those in the air, what they have to bear [N], by row; normal equations of 1 / scale, by recording.
  struct UnitRows {
    std::vector<Eigen::VectorXd> readings;
    std::vector<double> needed;
    std::map<int, std::pair<Eigen::MatrixXd, Eigen::VectorXd>> normal;
  };

  UnitRows collect_units(const ChannelRows& c) const {
    UnitRows out;
    const long n = at_.sensors;
    const std::vector<size_t> places = find_readings(c);
    for (size_t i = 0; i < c.rows(); ++i) {
      Eigen::VectorXd reading(n);
      double sum = 0;
      for (long s = 0; s < n; ++s) {
        const double f = c.row(i)[places[static_cast<size_t>(s)]];
        sum += f;
        reading(s) = f - contacts_.levels[static_cast<size_t>(s)].air;
      }
      out.readings.push_back(reading);
      out.needed.push_back(sum - c.y[i] + log_.mass_below * get_gravity());
      auto& [A, b] =
          out.normal.try_emplace(c.recording[i], Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n)).first->second;
      A += reading * reading.transpose();
      b += out.needed.back() * reading;
    }
    return out;
  }

  // [unit of the log] What each sensor reads beyond what it bears, if the unit is that of force after all. Empty: it is
  // not, as the ground would have to pull at a foot.
  static std::optional<double> find_common_zero(const UnitRows& rows) {
    double more = 0;
    Eigen::VectorXd lowest = rows.readings[0];
    const auto n = static_cast<double>(lowest.size());
    for (size_t i = 0; i < rows.needed.size(); ++i) {
      more += (rows.readings[i].sum() - rows.needed[i]) / static_cast<double>(rows.needed.size()) / n;
      lowest = lowest.cwiseMin(rows.readings[i]);
    }
    if (lowest.minCoeff() > more) return more;
    return std::nullopt;
  }

  // Forces in an unknown unit: required = sum of (reading - reading in the air) / scale. The ground bears the feet,
  // too, whether they hang below their sensors or are part of what those feel.
  void find_units(const ChannelRows& c) {
    out_.raw_counts = true;
    const long n = at_.sensors;
    const UnitRows rows = collect_units(c);
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
    for (const auto& [r, one] : rows.normal) {
      if (log_.experiment->recordings[static_cast<size_t>(r)].spec.train) {
        A += one.first;
        b += one.second;
      }
    }
    const double common = b.sum() / A.sum(), left = find_left(rows.readings, rows.needed, common),
                 prior = left / std::pow(kMuch * common, 2);
    const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(n, n);
    const auto solve = [&](const Eigen::MatrixXd& G, const Eigen::VectorXd& h) -> Eigen::VectorXd {
      return (G + prior * one).ldlt().solve(h + Eigen::VectorXd::Constant(n, prior * common));
    };
    std::vector<Eigen::VectorXd> each;
    for (const auto& [r, sums] : rows.normal) each.push_back(solve(sums.first, sums.second));
    const Eigen::VectorXd x = solve(A, b);
    // Recordings that agree by chance, or one alone, know no scale better than its rows do.
    const Eigen::VectorXd least = (left * (A + prior * one).inverse().diagonal()).cwiseSqrt();
    const std::optional<double> zero = find_common_zero(rows);
    for (int s = 0; s < n; ++s) add_unit(s, x(s), std::max(least(s), find_spread(each, s, x(s))), zero);
    add_unit_fit(c, rows.readings, rows.needed, x);
    out_.notes.push_back("the feet's forces are no newtons: nothing is told of masses, friction and ground");
  }

  // Squares that one scale for all sensors leaves in a block, whose rows have one error. Feet of a trot bear in pairs,
  // so that rows tell little of one foot: against these squares, a common scale weighs.
  static double find_left(const std::vector<Eigen::VectorXd>& readings, const std::vector<double>& needed,
                          double common) {
    double left = 0;
    for (size_t i = 0; i < needed.size(); ++i) left += std::pow(needed[i] - common * readings[i].sum(), 2);
    return kBlock / kCell * left / std::max(1.0, static_cast<double>(needed.size()));
  }

  // Of one sensor's scale, by recordings.
  static double find_spread(const std::vector<Eigen::VectorXd>& each, int sensor, double value) {
    double spread = 0;
    for (const Eigen::VectorXd& e : each) spread += std::pow(e(sensor) - value, 2) / static_cast<double>(each.size());
    return std::sqrt(spread);
  }

  // What scales and zeros leave of the weight that the motion asks for.
  void add_unit_fit(const ChannelRows& c, const std::vector<Eigen::VectorXd>& readings,
                    const std::vector<double>& needed, const Eigen::VectorXd& x) {
    UnitFit& fit = out_.units;
    for (size_t i = 0; i < c.rows(); ++i) {
      const int part = c.train[i] ? 0 : 1;
      fit.before[part] += std::pow(c.y[i], 2);
      fit.after[part] += std::pow(needed[i] - readings[i].dot(x), 2);
      fit.rows[part] += 1;
    }
    for (int part = 0; part < 2; ++part) {
      fit.before[part] /= std::max(1.0, fit.rows[part]);
      fit.after[part] /= std::max(1.0, fit.rows[part]);
    }
    fit.signal = c.info.signal + " (weight)";
    fit.scale = c.scale;
    fit.exact = std::pow(kTrace * log_.mass * get_gravity(), 2);
  }

  // What a finding about a sensor begins with: its scale or its zero.
  static Finding make_of_sensor(const EffectInfo& effect, const std::string& name, const Estimate& value,
                                double weight) {
    Finding f = make_finding(effect, {{"sensor", name}}, {value});
    f.grade = Grade::kSupported;
    f.probability = 0.95;
    f.share = 1;
    f.weight = weight;
    return f;
  }

  // `zero`: what each sensor reads beyond what it has to bear, if its unit is that of force after all.
  void add_unit(int s, double per_unit, double spread, std::optional<double> zero) {
    const std::string name = "/wrench/" + log_.sensors[static_cast<size_t>(s)].name + "/force";
    const ForceLevels& level = contacts_.levels[static_cast<size_t>(s)];
    const EffectInfo &scale = laws_.sensor_scale.info(), &bias = laws_.sensor_bias.info();
    Estimate counts = make_value(scale, 1 / per_unit, spread / (per_unit * per_unit));
    counts.unit = "counts/N";
    Finding f = make_of_sensor(scale, name, counts, 1);
    f.statement = name +
                  format(": these are no newtons but raw counts: %.4f +- %.4f N a count, ", per_unit, 2 * spread) +
                  (level.swings ? format("and %.1f counts in the air.", level.air)
                                : "if nothing is read in the air: no foot leaves the ground.") +
                  " Scale and zero may differ from foot to foot, and readings may saturate.";
    if (!level.swings && zero) {
      f.grade = Grade::kAmbiguous;
      f.alternatives.push_back(make_alternative(
          bias, f.where, {make_value(bias, *zero, std::abs(*zero) * spread / per_unit, "N")}, "each foot lifted once"));
      if (per_unit > 1)
        f.statement += " Or they are newtons, and something else carries part of the robot: a rope, a hand.";
    }
    out_.findings.push_back(f);
    if (level.swings && std::abs(level.air) >= level.air_spread && is_clear_of_stance(s)) add_zero(s, per_unit, name);
  }

  // What a foot reads in the air is its zero, unless it hangs on its sensor and pulls at it.
  void add_zero(int s, double per_unit, const std::string& name) {
    const ForceLevels& level = contacts_.levels[static_cast<size_t>(s)];
    const double hanging = -find_mass_below(log_.sensors[static_cast<size_t>(s)]) * get_gravity() / per_unit;
    if (std::abs(level.air - hanging) < std::max(2 * level.air_spread, kDetail * std::abs(hanging))) return;
    const EffectInfo& bias = laws_.sensor_bias.info();
    // Along the sensor's own axis: levels are along the foot's.
    const double sense = std::copysign(1.0, log_.sensors[static_cast<size_t>(s)].X_LS.R(2, 2)), air = sense * level.air;
    Finding zero = make_of_sensor(bias, name, make_value(bias, air, level.air_spread, "N"), 0.5);
    zero.statement = name + format(": its zero is off: %.1f +- %.1f counts in the air.", air, 2 * level.air_spread);
    if (hanging != 0) {
      zero.grade = Grade::kAmbiguous;
      zero.statement += format(" Or it is %.1f counts, and the foot's own weight hangs on the sensor.",
                               sense * (level.air - hanging));
    }
    out_.findings.push_back(std::move(zero));
  }

  // Whether swings are longer than the kernel reaches to both sides: else what it brings in of the stance before and
  // after passes for a zero.
  bool is_clear_of_stance(int sensor) const {
    std::vector<double> kernels;
    for (const Contact& spell : contacts_.spells) {
      const Clip& clip = log_.clips[spell.clip];
      const bool swings = log_.feet[spell.foot].sensor == sensor && !spell.loaded;
      if (swings) kernels.push_back(static_cast<double>(spell.end - spell.begin) / static_cast<double>(2 * clip.edge));
    }
    return find_median(kernels) > 1;
  }

  const LeggedLog& log_;
  const Contacts& contacts_;
  const std::vector<ChannelRows>& channels_;
  const ColumnLayout& at_;
  const LawTable& laws_ = get_laws();
  CheckResult& out_;
};

}  // namespace

const ChannelRows* find_weight_equation(const std::vector<ChannelRows>& channels) {
  const ChannelRows* best = nullptr;
  for (const ChannelRows& c : channels) {
    const bool force = c.info.equation.is(EquationKind::kWeight) || c.info.equation.is(EquationKind::kForce);
    if (force && c.rows() > 0 && (!best || std::abs(c.mean) > std::abs(best->mean))) best = &c;
  }
  return best;
}

void check_weight(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels,
                  const ColumnLayout& layout, CheckResult* out) {
  WeightChecker(log, contacts, channels, layout, out).run();
}

bool has_raw_counts(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels,
                    const ColumnLayout& layout) {
  CheckResult none;
  return WeightChecker(log, contacts, channels, layout, &none).has_raw_counts();
}

}  // namespace hrp::diagnosis::floating
