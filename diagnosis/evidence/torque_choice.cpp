// SPDX-License-Identifier: BSD-3-Clause
// All subsets of a joint's terms; terms of the whole robot one after another, each beside the joints' best subsets.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "diagnosis/evidence/torque_model.h"
#include "diagnosis/measurement/term_rows.h"
#include "diagnosis/model/link_reach.h"
#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {
namespace {

constexpr double kWorth = 3.0;       // [nats] beyond its cost
constexpr int kMostTerms = 7;        // of one joint
constexpr size_t kMostWhole = 4;
constexpr size_t kTried = 6;         // terms of the whole robot that are tried beside new subsets

constexpr double kBracket = 0.5;     // width of the two bounds of a gain, of its distance from one

using Terms = std::vector<size_t>;

double get_parameter(const JointDesign& joint, const Terms& terms, const Eigen::VectorXd& theta, TermKind kind) {
  long at = 0;
  for (size_t term : terms) {
    if (joint.terms[term].kind == kind) return theta[at];
    at += joint.terms[term].columns;
  }
  return 0.0;
}

bool has_kind(const JointDesign& joint, const Terms& terms, TermKind kind) {
  return std::any_of(terms.begin(), terms.end(), [&](size_t t) { return joint.terms[t].kind == kind; });
}

// A Stribeck curve is an excess over a level, a spring has a constant of its own. A gear with the loss 2 mu backwards and a
// gain of 1 + mu are load-dependent friction mu in two terms.
bool is_sensible(const JointDesign& joint, const Terms& terms) {
  if (has_kind(joint, terms, TermKind::kStribeck) && !has_kind(joint, terms, TermKind::kDry) &&
      !has_kind(joint, terms, TermKind::kLoadDry))
    return false;
  if (has_kind(joint, terms, TermKind::kBackdriven) && has_kind(joint, terms, TermKind::kGain)) return false;
  if (has_kind(joint, terms, TermKind::kLag) && has_kind(joint, terms, TermKind::kCommandDelay)) return false;
  return !(has_kind(joint, terms, TermKind::kSpring) && has_kind(joint, terms, TermKind::kConstant));
}

bool has(const Terms& terms, size_t term) { return std::find(terms.begin(), terms.end(), term) != terms.end(); }

// Two of the four parameters of a load.
bool is_link_mass(TermKind kind) { return kind == TermKind::kMassError || kind == TermKind::kComError; }

Columns list_own(const JointDesign& joint, const Terms& terms) {
  Columns columns;
  for (size_t term : terms) {
    const Columns own = list_columns(joint, term);
    columns.insert(columns.end(), own.begin(), own.end());
  }
  return columns;
}

// The joint's own columns with what terms of the whole robot contribute taken away.
Gram subtract_whole(const Gram& gram, long own_width, const Eigen::VectorXd& whole) {
  Gram out(own_width);
  const Eigen::MatrixXd G = gram.G.selfadjointView<Eigen::Lower>();
  const long rest = G.rows() - own_width;
  out.G = G.topLeftCorner(own_width, own_width);
  out.b = gram.b.head(own_width) - G.block(0, own_width, own_width, rest) * whole;
  out.c = gram.c - 2.0 * gram.b.tail(rest).dot(whole) +
          whole.dot(G.bottomRightCorner(rest, rest) * whole);
  out.n = gram.n;
  return out;
}

// [m] within which a body's effect may act; 0 where that says nothing.
double find_reach(const TorqueData& data, const Term& term) {
  if (get_term_row(term.kind).place != PlaceKind::kLink) return 0.0;
  return calc_link_reach(data.experiment->robot.tree, term.place);
}

struct Subset {
  Terms terms;
  double evidence = -1e300;
  std::vector<double> first;  // parameter of each term
};

class SubsetSearch {
 public:
  SubsetSearch(const TorqueDesign& design, size_t joint, const Eigen::VectorXd& whole, Timing timing)
      : design_(design), at_(joint), joint_(design.joints[joint]), timing_(timing) {
    for (const Gram& fold : joint_.train) folds_.push_back(subtract_whole(fold, joint_.own_width, whole));
    total_ = sum(folds_, joint_.own_width);
  }

  // Best first; all that are physical.
  std::vector<Subset> run() {
    const Terms pool = list_pool();
    std::vector<Subset> subsets;
    for (size_t mask = 0; mask < (size_t{1} << pool.size()); ++mask) {
      Terms terms;
      for (size_t i = 0; i < pool.size(); ++i) {
        if (mask >> i & 1) terms.push_back(pool[i]);
      }
      if (static_cast<int>(terms.size()) > kMostTerms || !is_sensible(joint_, terms)) continue;
      const Subset subset = judge(terms);
      if (subset.evidence > -1e299) subsets.push_back(subset);
    }
    std::sort(subsets.begin(), subsets.end(), [](const Subset& a, const Subset& b) { return a.evidence > b.evidence; });
    return subsets;
  }

 private:
  Subset judge(const Terms& terms) const {
    const Columns columns = list_own(joint_, terms);
    const Eigen::VectorXd theta = solve(total_, columns);
    if (!is_physical(design_, at_, terms, theta) || !has_bracketed_gain(terms)) return {terms, -1e300, {}};
    const double cross = cross_validate(folds_, total_, columns) * calc_per_effort(joint_, terms, theta);
    const double floor = 1e-6 * joint_.spread * joint_.spread;
    double evidence = -0.5 * joint_.effective * std::log(std::max({cross, floor, 1e-300}));
    Subset subset{terms, 0.0, {}};
    long at = 0;
    for (size_t term : terms) {
      evidence -= get_term_row(joint_.terms[term].kind).cost;
      subset.first.push_back(theta[at]);
      at += joint_.terms[term].columns;
    }
    subset.evidence = evidence - calc_gain_cost(joint_, terms, theta);
    return subset;
  }

  // Factor to which a term has to bring the mean square down to be worth its cost, and as many nats more as a supported
  // term must add: each term of the pool doubles the sets.
  double calc_worth(TermKind kind) const { return std::exp(-2.0 * (get_term_row(kind).cost + kWorth) / std::max(1.0, joint_.effective)); }

  // A wrong gain shows from both sides: by the effort and by the model's torque.
  bool has_bracketed_gain(const Terms& terms) const {
    if (!has_kind(joint_, terms, TermKind::kGain)) return true;
    const double k = 1.0 - get_parameter(joint_, terms, solve(total_, list_own(joint_, terms)), TermKind::kGain);
    Terms other;
    for (size_t term : terms) other.push_back(joint_.terms[term].kind == TermKind::kGain ? term + 1 : term);
    std::sort(other.begin(), other.end());
    const double g = get_parameter(joint_, other, solve(total_, list_own(joint_, other)), TermKind::kGainOfModel);
    const double other_k = 1.0 / std::max(1e-3, 1.0 + g), middle = 0.5 * (k + other_k);
    return (k - 1.0) * (other_k - 1.0) > 0.0 && std::abs(k - other_k) < kBracket * std::abs(middle - 1.0);
  }

  // One Stribeck velocity, one period of ripple, one delay: those that help most beside the usual terms. A gear that is
  // hard to turn backwards only if it is worth its cost beside all of these: load-dependent friction says much of it, too.
  Terms list_pool() const {
    Terms pool, base;
    for (size_t t = 0; t < joint_.terms.size(); ++t) {
      const TermKind kind = joint_.terms[t].kind;
      if (get_term_row(kind).scanned || kind == TermKind::kGainOfModel) continue;
      if (kind == TermKind::kGain && !joint_.loaded) continue;
      if (kind == TermKind::kBackdriven) continue;
      pool.push_back(t);
      if (kind == TermKind::kViscous || kind == TermKind::kDry || kind == TermKind::kRotor ||
          kind == TermKind::kConstant)
        base.push_back(t);
    }
    Terms all = base;
    for (TermKind kind : {TermKind::kStribeck, TermKind::kCogging, TermKind::kCommandDelay, TermKind::kBackdriven}) {
      const bool gear = kind == TermKind::kBackdriven;
      if (gear) base = all;
      double best = gear ? cross_validate(folds_, total_, list_own(joint_, all)) * calc_worth(kind) : 1e300;
      size_t chosen = joint_.terms.size();
      if (kind == TermKind::kCommandDelay && timing_ == Timing::kAsRecorded) continue;
      for (size_t t = 0; t < joint_.terms.size(); ++t) {
        if (joint_.terms[t].kind != kind) continue;
        Terms with = base;
        with.push_back(t);
        const double cross = cross_validate(folds_, total_, list_own(joint_, with));
        if (cross < best) best = cross, chosen = t;
      }

      if (chosen < joint_.terms.size()) pool.push_back(chosen), all.push_back(chosen);
    }
    return pool;
  }

  const TorqueDesign& design_;
  const size_t at_;
  const JointDesign& joint_;
  const Timing timing_;
  std::vector<Gram> folds_;
  Gram total_;
};

// Probability of each term, and how much its first parameter differs between subsets (Bayesian model averaging).
void average(const std::vector<Subset>& subsets, std::vector<double>* inclusion, std::vector<double>* std) {
  std::vector<double> mean(inclusion->size(), 0.0), square(mean);
  double all = 0.0;
  for (const Subset& subset : subsets) {
    const double weight = std::exp(subset.evidence - subsets[0].evidence);
    all += weight;
    for (size_t i = 0; i < subset.terms.size(); ++i) {
      const size_t term = subset.terms[i];
      (*inclusion)[term] += weight, mean[term] += weight * subset.first[i];
      square[term] += weight * subset.first[i] * subset.first[i];
    }
  }
  for (size_t t = 0; t < mean.size(); ++t) {
    const double weight = (*inclusion)[t];
    if (weight > 0.0) (*std)[t] = std::sqrt(std::max(0.0, square[t] / weight - mean[t] * mean[t] / (weight * weight)));
    (*inclusion)[t] = weight / all;
  }
}

class Chooser {
 public:
  Chooser(const TorqueDesign& design, int jobs, Timing timing) : design_(design), jobs_(jobs), timing_(timing) {}

  Choice run() {
    Choice choice = choose_own({}, Eigen::VectorXd::Zero(whole_width()));
    while (choice.model.whole.size() < kMostWhole && add_whole(&choice)) {
    }
    merge_into_loads(&choice);
    for (size_t i = 0; i < kMostWhole && exchange_whole(&choice); ++i) {
    }
    return choice;
  }

 private:
  long whole_width() const {
    return std::accumulate(design_.whole.begin(), design_.whole.end(), 0L,
                           [](long sum, const Term& term) { return sum + term.columns; });
  }

  // A wrong mass and a centre of mass elsewhere, of one link, are one load: it has the same four parameters.
  void merge_into_loads(Choice* choice) const {
    for (size_t load = 0; load < design_.whole.size(); ++load) {
      if (design_.whole[load].kind != TermKind::kPayload) continue;
      Terms rest;
      for (size_t term : choice->model.whole) {
        if (!is_link_mass(design_.whole[term].kind) || design_.whole[term].place != design_.whole[load].place) rest.push_back(term);
      }
      if (rest.size() + 2 != choice->model.whole.size()) continue;
      rest.push_back(load);
      const Choice with = choose_beside(rest);
      if (with.fit.evidence > choice->fit.evidence && is_choice_physical(with)) *choice = with;
    }
  }

  // One term in the place of one or two that were chosen one after another: a load looks like a wrong mass first, and a
  // tilt or a zero takes the rest.
  bool exchange_whole(Choice* choice) const {
    Choice best = *choice;
    for (const Terms& whole : rank_exchanges(*choice)) {
      const Choice with = choose_beside(whole, choice->model.own);
      if (with.fit.evidence > best.fit.evidence && is_choice_physical(with)) best = with;
    }
    const bool better = best.model.whole != choice->model.whole;
    *choice = best;
    return better;
  }

  // The best of all exchanges beside the joints' terms as they are.
  std::vector<Terms> rank_exchanges(const Choice& choice) const {
    const Terms& have = choice.model.whole;
    std::vector<TorqueModel> models;
    for (size_t a = 0; a < have.size(); ++a) {
      for (size_t b = a; b < have.size(); ++b) {
        for (size_t term = 0; term < design_.whole.size(); ++term) {
          if (has(have, term) || design_.whole[term].kind == TermKind::kBusDelay) continue;
          TorqueModel model = choice.model;
          model.whole.clear();
          for (size_t i = 0; i < have.size(); ++i) {
            if (i != a && i != b) model.whole.push_back(have[i]);
          }
          model.whole.push_back(term);
          models.push_back(std::move(model));
        }
      }
    }
    std::vector<std::pair<double, size_t>> ranked(models.size());
    parallel_for(jobs_, static_cast<int>(models.size()), [&](int i) {
      const size_t at = static_cast<size_t>(i);
      ranked[at] = {fit_torque(design_, models[at]).evidence, at};
    });
    std::sort(ranked.rbegin(), ranked.rend());
    std::vector<Terms> list;
    for (size_t i = 0; i < std::min(kTried, ranked.size()); ++i) {
      if (ranked[i].first > choice.fit.evidence - kWorth) list.push_back(models[ranked[i].second].whole);
    }
    return list;
  }

  // The joints' best subsets beside terms of the whole robot, whose parameters come from a fit of both.
  Choice choose_beside(const Terms& whole) const { return choose_beside(whole, list_usual_terms(design_)); }

  // The same from given terms of the joints: what they take, and what is left to the whole robot, depend on each other.
  Choice choose_beside(const Terms& whole, const std::vector<Terms>& own) const {
    const TorqueModel model{own, whole};
    const Choice with = choose_own(whole, spread_whole(model, fit_torque(design_, model)));
    // Once more, with parameters that the chosen subsets leave.
    Choice again = choose_own(whole, spread_whole(with.model, with.fit));
    while (drop_own(&again)) {
    }
    return again;
  }

  // From what every drive has, and from the terms chosen so far without their gains: a gain may have taken what a new
  // term of the whole robot says, and hides it.
  Choice choose_from_either(const Terms& whole, std::vector<Terms> chosen) const {
    const Choice usual = choose_beside(whole);
    for (size_t i = 0; i < chosen.size(); ++i) {
      const auto is_gain = [&](size_t t) { return design_.joints[i].terms[t].kind == TermKind::kGain; };
      chosen[i].erase(std::remove_if(chosen[i].begin(), chosen[i].end(), is_gain), chosen[i].end());
    }
    const Choice other = choose_beside(whole, chosen);
    return other.fit.evidence > usual.fit.evidence ? other : usual;
  }

  // A joint's subset is chosen beside given parameters of the whole robot: what it took in their place, as a gain takes a
  // load's weight, goes where the fit of all is better without. What every drive has stays.
  bool drop_own(Choice* choice) const {
    Choice best = *choice;
    for (size_t i = 0; i < design_.joints.size(); ++i) {
      for (size_t term : choice->model.own[i]) {
        if (get_term_row(design_.joints[i].terms[term].kind).usual) continue;
        Choice without = *choice;
        Terms& own = without.model.own[i];
        own.erase(std::find(own.begin(), own.end(), term));
        if (!is_sensible(design_.joints[i], own)) continue;
        without.fit = fit_torque(design_, without.model);
        if (without.fit.evidence > best.fit.evidence) best = without;
      }
    }
    const bool better = best.fit.evidence > choice->fit.evidence;
    *choice = best;
    return better;
  }

  // The joints' best subsets beside given terms of the whole robot, whose columns have the parameters `theta`.
  Choice choose_own(const Terms& whole, const Eigen::VectorXd& theta) const {
    Choice choice;
    choice.model.whole = whole;
    choice.model.own.resize(design_.joints.size());
    choice.inclusion.resize(design_.joints.size());
    choice.choice_std.resize(design_.joints.size());
    parallel_for(jobs_, static_cast<int>(design_.joints.size()), [&](int i) {
      const size_t at = static_cast<size_t>(i);
      const std::vector<Subset> subsets = SubsetSearch(design_, at, theta, timing_).run();
      choice.inclusion[at].assign(design_.joints[at].terms.size(), 0.0);
      choice.choice_std[at] = choice.inclusion[at];
      if (subsets.empty()) return;
      choice.model.own[at] = subsets[0].terms;
      average(subsets, &choice.inclusion[at], &choice.choice_std[at]);
    });
    choice.fit = fit_torque(design_, choice.model);
    return choice;
  }

  std::vector<size_t> rank_whole(const Terms& have) const {
    TorqueModel model;
    model.own = list_usual_terms(design_);
    model.whole = have;
    const double base = fit_torque(design_, model).evidence;
    std::vector<std::pair<double, size_t>> gains(design_.whole.size());
    parallel_for(jobs_, static_cast<int>(gains.size()), [&](int i) {
      const size_t term = static_cast<size_t>(i);
      TorqueModel with = model;
      with.whole.push_back(term);
      gains[term] = {has(have, term) ? -1e300 : fit_torque(design_, with).evidence - base, term};
    });
    std::sort(gains.rbegin(), gains.rend());
    // Beside a rotor at every joint a delay of all of them shows little, but it saves a delay at each.
    std::vector<size_t> ranked;
    bool delay = timing_ == Timing::kAsRecorded || std::any_of(have.begin(), have.end(), [&](size_t t) { return design_.whole[t].kind == TermKind::kBusDelay; });
    for (size_t i = 0; i < gains.size(); ++i) {
      const bool of_bus = design_.whole[gains[i].second].kind == TermKind::kBusDelay;
      if (of_bus ? !delay : i < kTried && gains[i].first > 0.0) ranked.push_back(gains[i].second);
      delay = delay || of_bus;
    }
    add_loads(have, &ranked);
    return ranked;
  }

  // Where a link's mass or its centre is worth trying, so is a load, which is both.
  void add_loads(const Terms& have, Terms* ranked) const {
    std::set<int> links;
    for (size_t term : *ranked) {
      if (is_link_mass(design_.whole[term].kind)) links.insert(design_.whole[term].place);
    }
    for (size_t term = 0; term < design_.whole.size(); ++term) {
      const bool there = has(have, term) || has(*ranked, term);
      if (!there && design_.whole[term].kind == TermKind::kPayload && links.count(design_.whole[term].place)) ranked->push_back(term);
    }
  }

  // The parameters of the whole robot's terms beside the joints' terms, by column of all such terms.
  Eigen::VectorXd spread_whole(const TorqueModel& model, const TorqueFit& fit) const {
    Eigen::VectorXd theta = Eigen::VectorXd::Zero(whole_width());
    const Slots slots = list_slots(design_, model);
    for (size_t t = 0; t < model.whole.size(); ++t) {
      const long columns = design_.whole[model.whole[t]].columns;
      theta.segment(design_.whole_first[model.whole[t]], columns) = fit.theta.segment(slots.whole[t], columns);
    }
    return theta;
  }

  // All together: beside terms of the whole robot a joint's own have other values than those that it was chosen with.
  bool is_choice_physical(const Choice& choice) const {
    const Slots slots = list_slots(design_, choice.model);
    for (size_t i = 0; i < design_.joints.size(); ++i) {
      const Terms& own = choice.model.own[i];
      if (own.empty()) continue;
      long columns = 0;
      for (size_t term : own) columns += design_.joints[i].terms[term].columns;
      if (!is_physical(design_, i, own, choice.fit.theta.segment(slots.own[i][0], columns))) return false;
    }
    for (size_t t = 0; t < choice.model.whole.size(); ++t) {
      const Term& term = design_.whole[choice.model.whole[t]];
      if (!is_whole_physical(design_, term, choice.fit.theta.segment(slots.whole[t], term.columns))) return false;
    }
    return true;
  }

  // One delay in the place of one at each joint adds nothing: it makes the model smaller.
  double get_margin(size_t whole_term) const {
    return design_.whole[whole_term].kind == TermKind::kBusDelay ? 0.0 : kWholeGain;
  }

  bool add_whole(Choice* choice) const {
    Choice best;
    double most = 0.0;
    bool found = false;
    for (size_t term : rank_whole(choice->model.whole)) {
      Terms whole = choice->model.whole;
      whole.push_back(term);
      const Choice with = choose_from_either(whole, choice->model.own);
      const double gain = with.fit.evidence - choice->fit.evidence - get_margin(term);
      if (gain > most && is_choice_physical(with)) best = with, most = gain, found = true;
    }
    if (found) *choice = best;
    return found;
  }

  const TorqueDesign& design_;
  const int jobs_;
  const Timing timing_;
};

}  // namespace

std::vector<Terms> list_usual_terms(const TorqueDesign& design) {
  std::vector<Terms> usual;
  for (const JointDesign& joint : design.joints) {
    usual.emplace_back();
    for (size_t t = 0; t < joint.terms.size(); ++t) {
      if (get_term_row(joint.terms[t].kind).usual) usual.back().push_back(t);
    }
  }
  return usual;
}

bool is_physical(const TorqueDesign& design, size_t at, const Terms& terms, const Eigen::VectorXd& theta) {
  long column = 0;
  for (size_t term : terms) {
    const Term& own = design.joints[at].terms[term];
    if (!get_term_row(own.kind).allows(theta.segment(column, own.columns))) return false;
    column += own.columns;
  }
  return true;
}

Eigen::VectorXd drop_unseen(const TorqueDesign& design, const Term& term, Eigen::VectorXd p) {
  constexpr double kUnseen = 1e-4;  // of the squares of the term's best column: a hundredth of its size
  const auto is_it = [&](const Term& t) { return t.kind == term.kind && t.place == term.place && t.shape == term.shape; };
  const auto at = std::find_if(design.whole.begin(), design.whole.end(), is_it);
  if (at == design.whole.end()) return p;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(p.size());
  for (const JointDesign& joint : design.joints) {
    const Columns columns = list_whole_columns(design, joint, static_cast<size_t>(at - design.whole.begin()));
    for (long c = 0; c < p.size(); ++c) squares[c] += joint.total.get(columns[static_cast<size_t>(c)], columns[static_cast<size_t>(c)]);
  }
  for (long c = 0; c < p.size(); ++c) {
    const bool mass = term.kind == TermKind::kPayload && c == 0;  // its place is its moment over it
    if (!mass && squares[c] < kUnseen * squares.maxCoeff()) p[c] = 0.0;
  }
  return p;
}

bool is_whole_physical(const TorqueDesign& design, const Term& term, const Eigen::VectorXd& all) {
  const Eigen::VectorXd p = drop_unseen(design, term, all);
  const double reach = find_reach(*design.data, term);
  if (term.kind == TermKind::kPayload) return p[0] > 0.0 && p.tail<3>().norm() < reach * p[0];
  if (term.kind == TermKind::kComError) return p.norm() < reach;
  return get_term_row(term.kind).allows(p);
}

Choice choose_torque_model(const TorqueDesign& design, int jobs, Timing timing) { return Chooser(design, jobs, timing).run(); }

}  // namespace hrp::diagnosis
