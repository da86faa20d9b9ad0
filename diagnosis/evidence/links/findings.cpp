// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/links/findings.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/estimate_words.h"

namespace hrp::diagnosis {
namespace {

struct Graded {
  size_t term = 0;  // of the design
  Eigen::VectorXd theta, std;
  double share = 0.0, gain = 0.0;
  bool significant = false, stable = true, helps = false, whole = false;
  std::vector<std::pair<size_t, Eigen::VectorXd>> rivals;
};

Where make_place(const LinkDesign& d, const LinkTerm& term) {
  const TreeSpec& tree = d.experiment->robot.tree;
  if (term.of_link_encoder) return {{"sensor", "/joint_states_link/" + tree.joint(term.index).name + "/position"}};
  if (term.row->place == PlaceKind::kLink) return {{"link", tree.links[static_cast<size_t>(term.index)].name}};
  if (term.row->place == PlaceKind::kJoint) return {{"joint", tree.joint(term.index).name}};
  if (term.row->place == PlaceKind::kNone) return {{"sensor", "/joint_states"}};
  const std::string& name = term.group >= 0 ? d.groups[static_cast<size_t>(term.group)].reading.name
                                            : d.readings->sensors()[static_cast<size_t>(term.index)].name;
  return {{"sensor", name}};
}

std::vector<Estimate> make_parameters(const LinkDesign& d, const LinkTerm& term, const Eigen::VectorXd& p,
                                      const Eigen::VectorXd& s) {
  std::vector<double> value, std;
  find_link_values(term, p, s, &value, &std);
  const std::vector<EffectParameter>& row = term.effect().parameters;
  std::vector<Estimate> list;
  for (size_t i = 0; i < value.size() && i < row.size(); ++i) {
    if (row[i].axis <= 0) {
      std::string unit = row[i].unit;
      if (unit.empty() && term.group >= 0) unit = d.groups[static_cast<size_t>(term.group)].reading.unit;
      if (unit.empty() && term.of_link_encoder) unit = "rad";
      if (term.row->place == PlaceKind::kJoint) unit = get_joint_unit(d.experiment->robot.tree.joint(term.index), unit);
      list.push_back({row[i].name, unit, {}, {}, row[i].axis == 0 && term.columns > 1});
    }
    list.back().value.push_back(value[i]);
    list.back().std.push_back(std[i]);
  }
  return list;
}

class Judge {
 public:
  Judge(const Experiment& e, const TorqueData& motion, const LinkSensors& sensors, const std::vector<Effect>& known)
      : e_(e),
        sensors_(sensors),
        readings_(std::make_shared<LinkReadings>(make_link_readings(e, sensors, known))),
        data_(make_link_data(e, motion, sensors, known, readings_.get())) {}

  // Held-out mean squares of read - predicted, by group; of all recordings if none is held out.
  std::vector<double> calc_nominal() {
    std::vector<double> out(readings_->groups().size(), 0.0), n(out);
    const bool has_held =
        std::any_of(data_.recordings.begin(), data_.recordings.end(), [](const LinkRecording& r) { return !r.train; });
    for (const LinkRecording& r : data_.recordings) {
      if (has_held && r.train) continue;
      for (size_t g = 0; g < out.size(); ++g) {
        const ReadingGroup& group = readings_->groups()[g];
        const long rows = r.read.rows() - 2 * r.trim;
        out[g] += (r.read - r.predicted).block(r.trim, group.first, rows, group.size).squaredNorm();
        n[g] += static_cast<double>(rows * group.size);
      }
    }
    for (size_t g = 0; g < out.size(); ++g) out[g] /= std::max(1.0, n[g]);
    return out;
  }

  // `before`: mean squares of the nominal model, if the prediction contains known effects.
  LinkVerdict run(const std::vector<double>& before) {
    before_ = before;
    return run();
  }

  LinkVerdict run() {
    for (const std::string& note : sensors_.notes) out_.evidence.warnings.push_back(note);
    if (data_.recordings.empty() || sensors_.sensors.empty()) return std::move(out_);
    check_units(data_, *readings_);
    choose();
    if (before_.empty()) before_ = nominal_.held;
    find_mismatch();
    grade();
    add_findings();
    add_remaining();
    out_.design = std::shared_ptr<const LinkDesign>(design_.get(), [a = design_, b = readings_](const LinkDesign*) {});
    return std::move(out_);
  }

 private:
  // Load positions and sensor rotations are nonlinear. Therefore each is linearised again, up to twice, at the last
  // result.
  void choose() {
    LinkPoints points;
    for (int pass = 0; pass < 3; ++pass) {
      design_ = std::make_shared<LinkDesign>(make_link_design(data_, sensors_, readings_.get(), points));
      out_.model = choose_link_terms(*design_);
      out_.fit = fit_links(*design_, out_.model, true);
      if (!move_points(&points)) break;
    }
    nominal_ = fit_links(*design_, {});
  }

  bool move_points(LinkPoints* points) const {
    bool moved = false;
    for (size_t i = 0; i < out_.model.size(); ++i) {
      const LinkTerm& term = design_->terms[out_.model[i]];
      if (!term.row->move) continue;
      Vector3d near = term.near;
      moved = term.row->move(out_.fit.theta[i], &near) || moved;
      const LinkPoint* known = find_point(*points, *term.row, term.index);
      if (known)
        (*points)[static_cast<size_t>(known - points->data())].near = near;
      else
        points->push_back({term.row, term.index, near});
    }
    return moved;
  }

  bool is_off(size_t g, double square, double share = kTrace) const {
    const LinkGroup& group = design_->groups[g];
    return square > kNoiseLeft * kNoiseLeft * group.floor && square > std::pow(share * group.spread, 2);
  }

  void find_mismatch() {
    out_.to_noise = true;
    double before = 0.0, after = 0.0, n = 0.0;
    for (size_t g = 0; g < design_->groups.size(); ++g) {
      const LinkGroup& group = design_->groups[g];
      const double count = group.reading.size, floor = std::max(group.floor, 1e-300);
      before += count * before_[g] / floor;
      after += count * out_.fit.held[g] / floor;
      n += count;
      if (is_off(g, out_.fit.held[g], kBlur)) out_.to_noise = false;
      if (!is_off(g, before_[g], kBlur)) continue;
      out_.mismatch = true;
      Mismatch m;
      m.signal = group.reading.name;
      m.recording = find_held_name();
      m.score = std::sqrt(before_[g] / floor);
      out_.evidence.mismatch.push_back(m);
    }
    out_.noise_before = std::sqrt(before / n);
    out_.noise_after = std::sqrt(after / n);
  }

  std::string find_held_name() const {
    for (const LinkRecording& r : data_.recordings) {
      if (!r.train) return e_.recordings[r.index].spec.name;
    }
    return e_.recordings[data_.recordings[0].index].spec.name;
  }

  // Held-out mean squares relative to the residual of the chosen model, weighted by independent samples and summed over
  // groups.
  double sum_held(const LinkFit& fit) const {
    double out = 0.0;
    for (size_t g = 0; g < design_->groups.size(); ++g)
      out += design_->groups[g].effective * fit.held[g] / std::max(out_.fit.cross[g], design_->groups[g].floor);
    return out;
  }

  void grade() {
    const double nominal = sum_held(nominal_), all = sum_held(out_.fit);
    long at = 0;
    for (size_t i = 0; i < out_.model.size(); ++i) {
      Graded g;
      g.term = out_.model[i];
      g.theta = out_.fit.theta[i];
      const long columns = g.theta.size();
      g.std = out_.fit.covariance.block(at, at, columns, columns).diagonal().cwiseAbs().cwiseSqrt();
      at += columns;
      widen(i, &g);
      LinkTerms without = out_.model;
      without.erase(without.begin() + static_cast<long>(i));
      const LinkFit others = fit_links(*design_, without), alone = fit_links(*design_, {g.term});
      g.gain = out_.fit.evidence - others.evidence;
      g.helps = sum_held(others) > all;
      g.share = std::clamp(0.5 * ((sum_held(others) - all) + (nominal - sum_held(alone))) / std::max(1e-300, nominal),
                           0.0, 1.0);
      judge_whole(others, &g);
      find_rivals(i, &g);
      graded_.push_back(std::move(g));
    }
  }

  // Standard deviations contain the variance between recordings (random effects). `stable` becomes false if a recording
  // that determines a scalar parameter (three standard errors) gives it the opposite sign.
  void widen(size_t i, Graded* g) const {
    const long columns = g->theta.size();
    std::vector<LinkAlone> alone;
    for (size_t r = 0; r < data_.recordings.size(); ++r) alone.push_back(fit_alone(*design_, out_.model, out_.fit, r));
    for (long c = 0; c < columns; ++c) {
      std::vector<double> values, variances;
      for (const LinkAlone& a : alone) {
        values.push_back(a.theta[i][c]);
        variances.push_back(std::max(1e-300, a.variance[i][c]));
        const bool tells = std::abs(values.back()) > 3.0 * std::sqrt(variances.back());
        if (columns == 1 && tells && values.back() * g->theta[c] < 0.0) g->stable = false;
      }
      double white = 0.0;
      for (double v : variances) white += 1.0 / v;
      const double between = calc_variance_between(values, variances) / static_cast<double>(values.size());
      const double variance = std::max(g->std[c] * g->std[c], 1.0 / std::max(1e-300, white)) + between;
      g->std[c] = std::hypot(std::sqrt(variance), kSeveralTimes * kAgreement * std::abs(g->theta[c]));
    }
    const double limit = columns > 1 ? kSignificantVector : kSignificantInJoint;
    double distance = 0.0;
    for (long c = 0; c < columns; ++c)
      distance = std::max(distance, std::abs(g->theta[c]) / std::max(1e-300, g->std[c]));
    g->significant = distance > limit;
  }

  // `helps` requires that the term removes a tenth of the mismatch of at least one reading. `whole` requires that the
  // model removes 70 % of the mismatch of these readings.
  void judge_whole(const LinkFit& others, Graded* g) const {
    bool matters = false;
    double before = 0.0, after = 0.0;
    for (size_t k = 0; k < design_->groups.size(); ++k) {
      const double floor = design_->groups[k].floor;
      const double gone = others.held[k] - out_.fit.held[k], missing = std::max(0.0, nominal_.held[k] - floor);
      if (gone > kDetail * missing && is_off(k, others.held[k])) {
        matters = true;
        before += missing / floor;
        after += std::max(0.0, out_.fit.held[k] - floor) / floor;
      }
    }
    g->helps = g->helps && matters;
    g->whole = before > 0.0 && after < kMuch * before;
  }

  void find_rivals(size_t i, Graded* g) const {
    std::vector<LinkTerms> models;
    std::vector<size_t> other;
    for (size_t t = 0; t < design_->terms.size(); ++t) {
      if (has(out_.model, t)) continue;
      models.push_back(out_.model);
      models.back()[i] = t;
      other.push_back(t);
    }
    const std::vector<double> evidence = compare_links(*design_, models, out_.fit);
    std::vector<std::pair<double, size_t>> near;
    for (size_t k = 0; k < models.size(); ++k) {
      if (evidence[k] > out_.fit.evidence - kOdds) near.push_back({evidence[k], k});
    }
    std::sort(near.rbegin(), near.rend());
    for (size_t k = 0; k < near.size() && k < kMostInList; ++k) {
      const size_t at = near[k].second;
      g->rivals.push_back({other[at], fit_links(*design_, models[at]).theta[i]});
    }
  }

  Finding make_finding(const Graded& g) const {
    const LinkTerm& term = design_->terms[g.term];
    const EffectInfo& row = term.effect();
    Finding f =
        diagnosis::make_finding(row, make_place(*design_, term), make_parameters(*design_, term, g.theta, g.std));
    const bool sure = g.significant && g.stable && g.helps && g.whole && g.rivals.empty();
    f.grade = sure ? Grade::kSupported : Grade::kAmbiguous;
    f.probability = std::min(kSurest, 1.0 / (1.0 + std::exp(-g.gain)));
    f.share = f.weight = g.share;
    for (const auto& [other, theta] : g.rivals) {
      const LinkTerm& rival = design_->terms[other];
      f.alternatives.push_back(make_alternative(rival.effect(), make_place(*design_, rival),
                                                make_parameters(*design_, rival, theta, 0.5 * theta.cwiseAbs()),
                                                term.row->motion));
    }
    f.statement = f.where.begin().value().get<std::string>() + ": " + row.phrase + ", " + describe(f.parameters) +
                  " (" + get_grade_name(f.grade) + "), by the sensors behind the gears. It takes away " +
                  number(100.0 * g.share, 2) + " % of what they read beyond the prediction on held-out data.";
    return f;
  }

  void add_findings() {
    for (const Graded& g : graded_) {
      if (g.helps && (g.significant || !g.rivals.empty())) {
        out_.evidence.findings.push_back(make_finding(g));
        continue;
      }
      const LinkTerm& term = design_->terms[g.term];
      out_.evidence.not_identifiable.push_back({term.effect().name, make_place(*design_, term),
                                                g.helps ? "sensors behind the gears do not tell it from none"
                                                        : "it helps sensors behind the gears to predict, but hardly",
                                                term.row->motion});
    }
    sort_findings(&out_.evidence.findings);
    out_.mismatch = out_.mismatch || !out_.evidence.findings.empty();  // a bias may be a small share of the reading
  }

  void add_remaining() {
    double before = 0.0, after = 0.0;
    for (size_t g = 0; g < design_->groups.size(); ++g) {
      const LinkGroup& group = design_->groups[g];
      Remaining r;
      const double axes = group.reading.size;
      r.where = {{"sensor", group.reading.name}};
      r.unit = group.reading.unit;
      r.before = std::sqrt(before_[g]);
      r.after = std::sqrt(out_.fit.held[g]);
      r.statement =
          group.reading.name + ": of " + number(r.before, 3) + " " + r.unit +
          " beyond the prediction (root mean square" + (axes > 1.0 ? " of its axes), " : "), ") + number(r.after, 3) +
          " " + r.unit + " remain" +
          (is_off(g, out_.fit.held[g], kBlur) ? "." : ", which is noise or what fast motions leave uncertain.");
      out_.evidence.fit.signals.push_back({group.reading.name, r.unit, r.before, r.after, group.spread});
      out_.evidence.remaining.push_back(r);
      if (!is_off(g, before_[g])) continue;
      before += std::max(0.0, before_[g] - group.floor) / group.floor;
      after += std::max(0.0, out_.fit.held[g] - group.floor) / group.floor;
    }
    out_.evidence.explained = before > 0.0 ? std::clamp(1.0 - after / before, 0.0, 1.0) : 0.0;
    out_.evidence.ceiling = 1.0;
  }

  const Experiment& e_;
  LinkSensors sensors_;
  std::shared_ptr<LinkReadings> readings_;
  LinkData data_;
  std::vector<double> before_;
  std::shared_ptr<LinkDesign> design_;
  LinkFit nominal_;
  std::vector<Graded> graded_;
  LinkVerdict out_;
};

}  // namespace

namespace {

// Sum over the groups of the ratio `square` / `of`.
double sum_over(const std::vector<double>& square, const std::vector<double>& of) {
  double out = 0.0;
  for (size_t g = 0; g < square.size(); ++g) out += square[g] / std::max(1e-300, of[g]);
  return out;
}

}  // namespace

LinkVerdict judge_links(const Experiment& e, const TorqueData& motion, const LinkSensors& sensors,
                        const std::vector<Effect>& known) {
  Judge nominal(e, motion, sensors, {});
  if (known.empty() || sensors.sensors.empty()) return nominal.run();
  Judge with(e, motion, sensors, known);
  const std::vector<double> before = nominal.calc_nominal(), after = with.calc_nominal();
  // Mean ratio of the squares with and without the known effects. True effects do not increase it, so an increase
  // contradicts them.
  if (sum_over(after, before) > (1.0 + kKnown) * static_cast<double>(before.size())) return nominal.run();
  LinkVerdict out = with.run(before);
  out.agrees = true;
  return out;
}

bool LinkVerdict::excludes(const std::string& effect, const Where& where, double value) const {
  if (!design) return false;
  for (size_t t = 0; t < design->terms.size(); ++t) {
    const LinkTerm& term = design->terms[t];
    if (term.effect().name != effect || make_place(*design, term) != where) continue;
    LinkTerms with = model;
    const auto at = std::find(model.begin(), model.end(), t);
    if (at != model.end()) return false;
    with.push_back(t);
    const LinkFit both = fit_links(*design, with, true);
    // Of a vector, `value` is the length.
    const long last = both.covariance.rows() - term.columns, width = term.effect().parameters[0].axis < 0 ? 1 : 3;
    const double asked = std::abs(term.row->factor ? value - 1.0 : value);
    const double found = both.theta.back().head(width).norm();
    const double std = std::sqrt(both.covariance.diagonal().segment(last, width).cwiseAbs().maxCoeff());
    // One of half the size would show, too.
    return 0.5 * asked > kUnlikely * std && found < 0.5 * asked;
  }
  return false;
}

std::pair<double, double> LinkVerdict::find_torque_fault(int joint) const {
  std::pair<double, double> fault{0.0, 1.0};
  for (size_t i = 0; i < model.size(); ++i) {
    const LinkTerm& term = design->terms[model[i]];
    if (term.row->place != PlaceKind::kSensor ||
        design->readings->sensors()[static_cast<size_t>(term.index)].joint != joint)
      continue;
    if (term.row->effect->change.constant != 0.0) fault.first = fit.theta[i][0];
    if (term.row->effect->change.of_reading != 0.0) fault.second = 1.0 + fit.theta[i][0];
  }
  return fault;
}

}  // namespace hrp::diagnosis
