// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/grade.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/estimate/odds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/doubts.h"
#include "diagnosis/evidence/torque/gain_spread.h"
#include "diagnosis/evidence/torque/intervals.h"
#include "diagnosis/evidence/torque/rivals.h"
#include "diagnosis/evidence/torque/shares.h"
#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {
namespace {

class Grader {
 public:
  Grader(const TorqueDesign& design, const Choice& choice, int jobs)
      : design_(design),
        choice_(choice),
        jobs_(jobs),
        slots_(list_slots(design, choice.model)),
        fit_(fit_torque(design, choice.model, true)) {}

  std::vector<GradedTerm> run() {
    for (size_t i = 0; i < design_.joints.size(); ++i) {
      for (size_t t = 0; t < choice_.model.own[i].size(); ++t) add({static_cast<int>(i), t});
    }
    for (size_t t = 0; t < choice_.model.whole.size(); ++t) add({-1, t});
    return grade();
  }

  GradedTerm run(const TermPlace& place) {
    add(place);
    return grade()[0];
  }

  // Only the values and their uncertainties.
  GradedTerm measure(const TermPlace& place) {
    add(place);
    find_agreement();
    find_widths();
    return graded_[0];
  }

 private:
  std::vector<GradedTerm> grade() {
    find_agreement();
    find_widths();
    find_shares();
    parallel_for(jobs_, static_cast<int>(graded_.size()), [&](int g) {
      compare(&graded_[static_cast<size_t>(g)]);
      decide(&graded_[static_cast<size_t>(g)]);
    });
    name_expected();
    return graded_;
  }

  // Where friction shows that a real drive is there, its rotor and its viscous friction are there, too. Three standard
  // errors guard against terms that may not exist; the rest of a drive is listed as ambiguous from 95 %.
  void name_expected() {
    for (GradedTerm& g : graded_) {
      const auto shows_drive = [&](const GradedTerm& other) {
        return other.place.joint == g.place.joint && other.term.row->usual && other.grade == Grade::kSupported;
      };
      const bool drive = g.place.joint >= 0 && std::any_of(graded_.begin(), graded_.end(), shows_drive);
      if (!g.named && drive && is_expected(g)) {
        g.named = true;
        g.grade = Grade::kAmbiguous;
      }
    }
  }

  bool is_expected(const GradedTerm& g) const {
    const double size = std::abs(g.parameters[0]);
    const bool told = size > kNinetyFive * g.std[0] && size >= g.width[0] && g.agreement >= kMostly;
    return g.term.row->usual && told && g.gain > 0.0 && g.share > 0.0 && g.helps_held && is_visible(g);
  }

  void add(const TermPlace& place) {
    GradedTerm g;
    g.place = place;
    long slot = 0;
    double between = 0.0;
    if (place.joint >= 0) {
      const size_t i = static_cast<size_t>(place.joint), term = choice_.model.own[i][place.at];
      g.term = design_.joints[i].terms[term];
      slot = slots_.own[i][place.at];
      between = choice_.choice_std[i][term];
      g.probability = find_family_probability(i, g.term);
    } else {
      g.term = design_.whole[choice_.model.whole[place.at]];
      slot = slots_.whole[place.at];
    }
    g.parameters = fit_.theta.segment(slot, g.term.columns());
    if (g.term.whole()) g.parameters = drop_unseen(design_, g.term, g.parameters);
    g.std = fit_.covariance.diagonal().segment(slot, g.term.columns()).cwiseMax(0.0).cwiseSqrt();
    if (g.term.whole() && !g.term.row->factor) g.std = (g.parameters.array() != 0.0).select(g.std, 0.0);
    g.std[0] = std::hypot(g.std[0], between);
    if (g.term.row->scales_effort) g.std[0] = std::hypot(g.std[0], find_bracket(g));
    graded_.push_back(g);
  }

  // Half the distance between the two estimates of a gain, by the effort column and by the torque column. They are
  // bounds: the true gain is between them.
  double find_bracket(const GradedTerm& g) const {
    const size_t i = static_cast<size_t>(g.place.joint);
    TorqueModel other = choice_.model;
    ++other.own[i][g.place.at];  // its column by the model's torque stands behind it in the list of terms
    const double by_model = fit_torque(design_, other).theta[slots_.own[i][g.place.at]];
    return 0.5 * std::abs(1.0 - g.parameters[0] - 1.0 / std::max(1e-3, 1.0 + by_model));
  }

  // Members of a family nearly always exclude each other in a subset, so their probabilities add up. So does that of a
  // spring, which contains a constant torque.
  double find_family_probability(size_t joint, const Term& term) const {
    double p = 0.0;
    for (size_t i = 0; i < design_.joints[joint].terms.size(); ++i) {
      const Term& other = design_.joints[joint].terms[i];
      if (is_same_family(other, term) || other.row->contains(*term.row)) p += choice_.inclusion[joint][i];
    }
    return std::min(1.0, p);
  }

  Columns list_own_columns(size_t i) const {
    Columns columns;
    for (size_t term : choice_.model.own[i]) {
      for (long c : list_columns(design_.joints[i], term)) columns.push_back(c);
    }
    return columns;
  }

  // Sums without what masses of links predict. The rows of all joints tell these. A stretch of one joint's rows cannot:
  // beside a free mass, a gain of 6 % would have either sign. A common delay stays: every joint takes it for its own
  // friction.
  Gram take_masses_out(size_t i, Gram gram) const {
    for (size_t t = 0; t < choice_.model.whole.size(); ++t) {
      if (!design_.whole[choice_.model.whole[t]].row->is_of_mass()) continue;
      const Columns columns = list_whole_columns(design_, design_.joints[i], choice_.model.whole[t]);
      for (size_t k = 0; k < columns.size(); ++k) {
        for (long c = 0; c < gram.b.size(); ++c)
          gram.b[c] -= gram.get(c, columns[k]) * fit_.theta[slots_.whole[t] + static_cast<long>(k)];
      }
    }
    return gram;
  }

  // Estimates each term from each stretch, with a weak prior from all data, at the joint that shows most of it. Its
  // parameters keep their proportion, because a stretch alone may not tell a load's mass from its place. The
  // differences between stretches in the first parameter widen the interval (random effects).
  void find_agreement() {
    for (GradedTerm& g : graded_) {
      const size_t i = find_judge(g);
      const JointDesign& joint = design_.joints[i];
      const bool others_tell = g.place.joint >= 0 && design_.joints.size() > 1;  // masses
      Columns columns = list_own_columns(i);
      for (size_t term : choice_.model.whole) {
        for (long c : list_whole_columns(design_, joint, term)) {
          if (!others_tell || !design_.whole[term].row->is_of_mass()) columns.push_back(c);
        }
      }
      const Gram total = others_tell ? take_masses_out(i, joint.total) : joint.total;
      const long first = find_first_column(g, i);
      const double value = solve(total, columns)[first];
      double same = 0.0, square = 0.0, n = 0.0;
      for (const Gram& fold : joint.train) {
        if (fold.n < 1.0) continue;
        Gram part = others_tell ? take_masses_out(i, fold) : fold;
        // All data keep a stretch's own in bounds, with a weight in average stretches.
        part.add(total, kMuch / static_cast<double>(joint.train.size()));
        same += solve_along(part, columns, first, g.parameters) > 0.0 ? 1.0 : 0.0;
        square += std::pow(solve(part, columns)[first] - value, 2);
        n += 1.0;
      }
      g.agreement = n > 0.0 ? same / n : 0.0;
      if (n > 1.0 && g.place.joint >= 0) g.std[0] = std::hypot(g.std[0], std::sqrt(square / (n - 1.0) / n));
    }
  }

  // Adds the spread between parts of the recordings to the interval widths.
  void find_widths() {
    std::vector<Eigen::VectorXd> between(design_.joints.size());
    std::vector<DryCurve> curves(between.size());
    std::vector<char> judges(between.size(), 0);
    const std::vector<double> gain_std = calc_gain_std(design_, choice_.model, fit_);
    for (const GradedTerm& g : graded_) judges[find_judge(g)] = 1;
    parallel_for(jobs_, static_cast<int>(between.size()), [&](int i) {
      if (!judges[static_cast<size_t>(i)]) return;
      between[static_cast<size_t>(i)] =
          calc_spread_between(design_, choice_.model, fit_, static_cast<size_t>(i), gain_std[static_cast<size_t>(i)]);
      curves[static_cast<size_t>(i)] = profile_dry_curve(design_, choice_.model, static_cast<size_t>(i));
    });
    const Eigen::VectorXd considered =
        choice_.model.whole.empty() ? Eigen::VectorXd() : calc_considered_std(design_, choice_.model, fit_);
    const Eigen::VectorXd of_masses = calc_unsure_mass_std(design_, choice_.model, fit_);
    for (GradedTerm& g : graded_) {
      const size_t i = find_judge(g);
      if (g.term.row->level) g.curve = curves[i];
      const long first = find_first_column(g, i);
      g.width = g.std;
      for (long c = 0; c < g.width.size(); ++c) {
        if (!(g.std[c] > 0.0)) continue;  // parameters that are not determined have std 0
        // Not further for terms of the whole robot: parts of one joint say little.
        const double most = g.term.whole() ? kUnlikely * g.std[c] : std::numeric_limits<double>::infinity();
        g.width[c] = std::hypot(g.std[c], std::min(most, between[i][first + c]));
        if (g.term.whole() || !is_loss(g.term.effect()))
          g.width[c] = std::hypot(g.width[c], (g.term.whole() ? considered : of_masses)[find_slot(g.place) + c]);
      }
      const long slot = find_slot(g.place);
      if (g.term.row->load) g.width = take_place_widths(g.parameters, fit_.covariance.block<4, 4>(slot, slot), g.width);
    }
  }

  long find_slot(const TermPlace& place) const {
    return place.joint >= 0 ? slots_.own[static_cast<size_t>(place.joint)][place.at] : slots_.whole[place.at];
  }

  // The joint whose rows contain most of the term's signal.
  size_t find_judge(const GradedTerm& g) const {
    if (g.place.joint >= 0) return static_cast<size_t>(g.place.joint);
    size_t best = 0;
    double most = -1.0;
    for (size_t i = 0; i < design_.joints.size(); ++i) {
      const JointDesign& joint = design_.joints[i];
      const Columns columns = list_whole_columns(design_, joint, choice_.model.whole[g.place.at]);
      double size = 0.0;
      for (size_t c = 0; c < columns.size(); ++c)
        size += joint.total.get(columns[c], columns[c]) * std::pow(g.parameters[static_cast<long>(c)], 2);
      size /= std::max(1e-300, fit_.cross[i]);
      if (size > most) {
        most = size;
        best = i;
      }
    }
    return best;
  }

  // Index of the term's first parameter among the columns that the model uses in the joint's rows.
  long find_first_column(const GradedTerm& g, size_t i) const {
    if (g.place.joint >= 0) return slots_.own[i][g.place.at] - slots_.own[i][0];
    long at = 0;
    for (size_t term : choice_.model.own[i]) at += design_.joints[i].terms[term].columns();
    for (size_t t = 0; t < g.place.at; ++t) at += design_.whole[choice_.model.whole[t]].columns();
    return at;
  }

  void find_shares() {
    double whole = 0.0;  // mismatch of all joints, each over the spread of its effort
    std::vector<double> scale;
    for (const JointDesign& joint : design_.joints) {
      scale.push_back(joint.weigh_squares());
      whole += calc_nominal_held(joint) * scale.back();
    }
    for (size_t i = 0; i < design_.joints.size(); ++i) {
      const std::vector<double> value = calc_term_shares(design_, choice_.model, fit_, i);
      const double nominal = std::max(1e-300, calc_nominal_held(design_.joints[i]));
      for (GradedTerm& g : graded_) {
        if (g.place.joint == static_cast<int>(i)) {
          g.share = value[g.place.at] / nominal;
          g.weight = value[g.place.at] * scale[i] / whole;
        } else if (g.place.joint < 0) {
          const double own = value[choice_.model.own[i].size() + g.place.at];
          g.weight += own * scale[i] / whole;
          g.joint_share.push_back(own / nominal);
          g.joint_weight.push_back(own * scale[i] / whole);
          g.share = std::max(g.share, own / nominal);  // of the joint that shows most of it
        }
      }
    }
  }

  TorqueModel without(const TermPlace& place) const {
    TorqueModel model = choice_.model;
    auto& list = place.joint >= 0 ? model.own[static_cast<size_t>(place.joint)] : model.whole;
    list.erase(list.begin() + static_cast<long>(place.at));
    return model;
  }

  // Finds what the model loses without the term, and which other terms fill the gap.
  void compare(GradedTerm* g) const {
    const TorqueModel rest = without(g->place);
    const TorqueFit alone = fit_torque(design_, rest);
    g->gain = fit_.evidence - alone.evidence;
    g->helps_held = calc_held_left(design_, alone) > calc_held_left(design_, fit_);
    const size_t judge = find_judge(*g);
    g->rescales = g->term.row->scales_effort && fit_.held[judge] < kPart * alone.held[judge];
    g->harms_one = harms_one(*g, alone);
    g->rivals = list_rivals(design_, {choice_.model, fit_, rest, alone}, judge, *g);
    for (Rival& r : g->rivals) {
      if (r.width.size() == 0) r.width = measure_rival(r).width;
    }
  }

  GradedTerm measure_rival(const Rival& r) const {
    Choice choice = choice_;
    choice.model = r.model;
    return Grader(design_, choice, 1).measure(r.place);
  }

  // True if the term makes the prediction of one held-out recording worse, at the joint that shows most of the term.
  bool harms_one(const GradedTerm& g, const TorqueFit& alone) const {
    const std::vector<double>& with = fit_.each_held[find_judge(g)];
    const std::vector<double>& without = alone.each_held[find_judge(g)];
    for (size_t r = 0; r < with.size(); ++r) {
      if (with[r] > (1.0 + kMinor) * without[r]) return true;
    }
    return false;
  }

  // True if the rms of a joint's term exceeds 2 % of the effort's spread.
  bool is_visible(const GradedTerm& g) const {
    const JointDesign& joint = design_.joints[find_judge(g)];
    const long c = list_columns(joint, choice_.model.own[static_cast<size_t>(g.place.joint)][g.place.at])[0];
    return std::sqrt(joint.total.get(c, c) / std::max(1.0, joint.total.n)) * std::abs(g.parameters[0]) >
           kKnown * joint.spread;
  }

  // False for deviations of gains and zeros that every real drive or encoder has.
  bool is_material(const GradedTerm& g) const { return g.parameters.norm() >= g.term.row->material; }

  // True if the delay may be an artefact of sampling. A log that holds values between samples, or writes them one cycle
  // early or late, shifts them by up to a period.
  bool is_of_sampling(const GradedTerm& g) const {
    return (g.term.row->late || g.term.row->of_log) &&
           g.parameters[0] - kNinetyFive * g.width[0] < design_.data->experiment->sample_time;
  }

  void decide(GradedTerm* g) const {
    const bool other_family = std::any_of(g->rivals.begin(), g->rivals.end(),
                                          [&](const Rival& r) { return !is_same_family(r.term, g->term); });
    // The value must differ from zero by more than its standard error and by more than the differences between parts of
    // the recordings. For a load, only its mass counts, not its position.
    const long counted = g->term.row->load ? 1 : g->parameters.size();
    const Eigen::VectorXd value = g->parameters.head(counted);
    const auto over = [&](const Eigen::VectorXd& std) {
      return (value.array() != 0.0).select(std.head(counted), 0.0).norm();
    };
    const double size = value.norm();
    const bool told = size > kUnlikely * over(g->std), clear = told && size > kNinetyFive * over(g->width);
    // A small share needs confirmation by held-out recordings, except for terms that every drive has.
    // Every drive has viscous and dry friction and a rotor.
    const double enough = g->term.row->usual ? kWholeGain : kOverwhelming;
    // A gain explains little alone where friction is most of the effort. Beside the others it decides all their values.
    const bool overwhelming =
        g->gain > enough && (g->share > kAgreement || g->rescales) && (design_.has_held || g->term.row->usual);
    const bool matters = (g->share >= kMinor || overwhelming) && is_material(*g);
    const bool holds = g->gain > 0.0 && matters && g->helps_held && g->agreement >= kMostly;
    // Friction and rotors that are clear in the model, though not on held-out data, are listed as ambiguous.
    const bool usual = g->term.row->usual && told && g->gain > kOdds && is_visible(*g);
    // If parts of the recordings differ by more than the value, the value is not reported. An exception is a term that
    // explains much of the mismatch: it is reported with its wide interval.
    const bool sized = size >= over(g->width), much = told && g->share > kMuch;
    // A common term that explains much of the held-out mismatch is listed, even if few independent samples make its
    // size uncertain.
    const bool likely =
        g->term.row->usual && g->share > kMuch && g->helps_held && g->gain > 0.0 && size > kNinetyFive * over(g->std);
    g->disagrees = g->agreement < kMostly;
    g->unsized = !sized;
    g->named = (sized && (holds || usual || likely)) || (holds && much);
    // A term that not every drive has could stand in for physics outside the list. It must improve the held-out
    // recordings, harm none of them, remove more than details of friction do, and have higher odds.
    const double odds = g->term.row->usual ? kOdds : kWholeGain;
    const bool confirmed =
        g->term.row->usual || (design_.joints[find_judge(*g)].has_held && !g->harms_one && g->share >= kMinor);
    const bool sure =
        confirmed && g->probability >= kNearlyAll && g->gain > odds && clear && !other_family && !is_of_sampling(*g);
    const bool stated = g->term.row->scales_effort && g->place.joint >= 0 && !is_measured(g->place.joint);
    g->grade = holds && sure && !stated ? Grade::kSupported : Grade::kAmbiguous;
    g->doubt = find_doubt(*g, {told, clear, is_of_sampling(*g), stated, confirmed && matters});
  }

  // True if the scale of the effort was recorded. Otherwise it follows from stated servo gains, also if they rescaled
  // the log, and the wrong gain may be the servo's or the drive's.
  bool is_measured(int i) const {
    const size_t joint = static_cast<size_t>(design_.joints[static_cast<size_t>(i)].joint);
    return design_.data->source[joint] == EffortSource::kRecorded && !design_.data->servo[joint].is_scaled();
  }

  const TorqueDesign& design_;
  const Choice& choice_;
  const int jobs_;
  const Slots slots_;
  const TorqueFit fit_;
  std::vector<GradedTerm> graded_;
};

}  // namespace

bool is_same_family(const Term& a, const Term& b) { return a.effect().family == b.effect().family; }

double calc_nominal_held(const JointDesign& joint) {
  double c = 0.0, n = 0.0;
  for (const Gram& held : joint.held) {
    c += held.c;
    n += held.n;
  }
  return c / std::max(1.0, n);
}

std::vector<GradedTerm> grade_terms(const TorqueDesign& design, const Choice& choice, int jobs) {
  return Grader(design, choice, jobs).run();
}

GradedTerm grade_term(const TorqueDesign& design, const Choice& choice, const TermPlace& place) {
  return Grader(design, choice, 1).run(place);
}

}  // namespace hrp::diagnosis
