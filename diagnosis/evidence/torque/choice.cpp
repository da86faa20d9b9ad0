// SPDX-License-Identifier: BSD-3-Clause
// Selects terms of the whole robot one by one, each with the joints' best subsets beside it.
#include <algorithm>
#include <numeric>
#include <set>

#include "common/base/has.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/model.h"
#include "diagnosis/evidence/torque/subsets.h"
#include "diagnosis/model/link_reach.h"
#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {
namespace {

constexpr size_t kMostWhole = 4;  // terms of the whole robot in one model: more trade off against each other

using Terms = std::vector<size_t>;

// True for a wrong mass or centre of mass: one or three of the four parameters of a load.
bool is_link_mass(const Term& term) { return term.row->is_of_mass() && !term.row->load; }

// Reach [m] of the link at which the term acts; 0 for terms at other places.
double find_reach(const TorqueData& data, const Term& term) {
  if (term.row->place != PlaceKind::kLink) return 0.0;
  return calc_link_reach(data.experiment->robot.tree, term.place);
}

class Chooser {
 public:
  Chooser(const TorqueDesign& design, int jobs, Timing timing) : design_(design), jobs_(jobs), timing_(timing) {}

  Choice run_joints() { return choose_own({}, Eigen::VectorXd::Zero(whole_width())); }

  Choice run() {
    Choice choice = run_joints();
    while (choice.model.whole.size() < kMostWhole && add_whole(&choice)) {
    }
    merge_into_loads(&choice);
    share_zeros(&choice);
    for (size_t i = 0; i < kMostWhole && exchange_whole(&choice); ++i) {
    }
    return choice;
  }

  // The joints' best subsets beside terms of the whole robot. A joint fit gives the parameters of the latter.
  Choice choose_beside(const Terms& whole) const { return choose_beside(whole, list_usual_terms(design_)); }

 private:
  long whole_width() const {
    return std::accumulate(design_.whole.begin(), design_.whole.end(), 0L,
                           [](long sum, const Term& term) { return sum + term.columns(); });
  }

  // True if the model also has the mass or centre of mass of a load's link. A load has all four of these parameters.
  // Such a second term would only fit inertia that differs from a point mass.
  bool is_twice(const Terms& whole, size_t load) const {
    return design_.whole[load].row->load && std::any_of(whole.begin(), whole.end(), [&](size_t term) {
             return is_link_mass(design_.whole[term]) && design_.whole[term].place == design_.whole[load].place;
           });
  }
  bool is_twice(const Terms& whole) const {
    return std::any_of(whole.begin(), whole.end(), [&](size_t term) { return is_twice(whole, term); });
  }

  // Adds a term, and removes the mass terms that a load replaces.
  Terms add_term(Terms whole, size_t term) const {
    const auto is_part = [&](size_t other) { return is_twice({other}, term); };
    whole.erase(std::remove_if(whole.begin(), whole.end(), is_part), whole.end());
    whole.push_back(term);
    return whole;
  }

  // Tries one load in place of the mass and centre-of-mass terms of one link, which have the same four parameters.
  void merge_into_loads(Choice* choice) const {
    for (size_t load = 0; load < design_.whole.size(); ++load) {
      if (!design_.whole[load].row->load) continue;
      const Terms whole = add_term(choice->model.whole, load);
      if (whole.size() + 1 != choice->model.whole.size()) continue;
      const Choice with = choose_beside(whole);
      if (with.fit.evidence > choice->fit.evidence && is_choice_physical(with)) *choice = with;
    }
  }

  // Tries one zero of the whole robot in place of those at several joints: a tilted base is a constant torque at each
  // joint, or the constant part of a spring.
  void share_zeros(Choice* choice) const {
    for (size_t term = 0; term < design_.whole.size(); ++term) {
      if (design_.whole[term].effect().family != EffectFamily::kZero || has(choice->model.whole, term)) continue;
      std::vector<Terms> own = choice->model.own;
      size_t gone = 0;
      for (size_t i = 0; i < own.size(); ++i) {
        const auto is_zero = [&](size_t t) { return design_.joints[i].terms[t].row->is_like_zero(); };
        const auto end = std::remove_if(own[i].begin(), own[i].end(), is_zero);
        gone += static_cast<size_t>(own[i].end() - end);
        own[i].erase(end, own[i].end());
      }
      if (gone < 2) continue;
      const Choice other = choose_beside(add_term(choice->model.whole, term), own);
      if (other.fit.evidence > choice->fit.evidence && is_choice_physical(other)) *choice = other;
    }
  }

  // Tries one term in place of one or two chosen terms. A load may look like a wrong mass first, with a tilt or a zero
  // for the rest.
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

  // The best exchanges, with the joints' terms unchanged.
  std::vector<Terms> rank_exchanges(const Choice& choice) const {
    const Terms& have = choice.model.whole;
    std::vector<TorqueModel> models;
    for (size_t a = 0; a < have.size(); ++a) {
      for (size_t b = a; b < have.size(); ++b) {
        for (size_t term = 0; term < design_.whole.size(); ++term) {
          if (has(have, term) || design_.whole[term].row->is_of_bus()) continue;
          TorqueModel model = choice.model;
          model.whole.clear();
          for (size_t i = 0; i < have.size(); ++i) {
            if (i != a && i != b) model.whole.push_back(have[i]);
          }
          model.whole.push_back(term);
          if (!is_twice(model.whole)) models.push_back(std::move(model));
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
    for (size_t i = 0; i < std::min(kShortList, ranked.size()); ++i) {
      if (ranked[i].first > choice.fit.evidence - kOdds) list.push_back(models[ranked[i].second].whole);
    }
    return list;
  }

  // The same, starting from given terms of the joints: their values and those of the whole robot's terms depend on each
  // other.
  Choice choose_beside(const Terms& whole, const std::vector<Terms>& own) const {
    const TorqueModel model{own, whole};
    Choice again = choose_own(whole, spread_whole(model, fit_torque(design_, model)));
    // Repeats with the parameters that fit the chosen subsets.
    if (again.model.own != own) again = choose_own(whole, spread_whole(again.model, again.fit));
    while (drop_own(&again)) {
    }
    return again;
  }

  // Starts from the usual terms, and from the chosen terms without gains; returns the better result. A gain may have
  // absorbed, and so hidden, the effect of a new term of the whole robot.
  Choice choose_from_either(const Terms& whole, std::vector<Terms> chosen) const {
    const Choice usual = choose_beside(whole);
    for (size_t i = 0; i < chosen.size(); ++i) {
      const auto is_gain = [&](size_t t) { return design_.joints[i].terms[t].row->scales_effort; };
      chosen[i].erase(std::remove_if(chosen[i].begin(), chosen[i].end(), is_gain), chosen[i].end());
    }
    const Choice other = choose_beside(whole, chosen);
    return other.fit.evidence > usual.fit.evidence ? other : usual;
  }

  // Removes a joint's term if the joint fit is better without it. The subset was chosen with fixed parameters of the
  // whole robot, so a term may have absorbed part of them, such as a gain the weight of a load. Usual terms stay.
  bool drop_own(Choice* choice) const {
    Choice best = *choice;
    for (size_t i = 0; i < design_.joints.size(); ++i) {
      for (size_t term : choice->model.own[i]) {
        if (design_.joints[i].terms[term].row->usual) continue;
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

  // The joints' best subsets beside terms of the whole robot with the fixed parameters `theta`.
  Choice choose_own(const Terms& whole, const Eigen::VectorXd& theta) const {
    Choice choice;
    choice.model.whole = whole;
    choice.model.own.resize(design_.joints.size());
    choice.inclusion.resize(design_.joints.size());
    choice.choice_std.resize(design_.joints.size());
    parallel_for(jobs_, static_cast<int>(design_.joints.size()), [&](int i) {
      const size_t at = static_cast<size_t>(i);
      const std::vector<Subset> subsets = list_subsets(design_, at, theta, timing_);
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
    // Beside a rotor at every joint, a bus delay gains little, but it replaces a delay at each joint. It is always
    // tried.
    std::vector<size_t> ranked;
    bool delay = timing_ == Timing::kAsRecorded ||
                 std::any_of(have.begin(), have.end(), [&](size_t t) { return design_.whole[t].row->is_of_bus(); });
    for (size_t i = 0; i < gains.size(); ++i) {
      const bool of_bus = design_.whole[gains[i].second].row->is_of_bus();
      if (of_bus ? !delay : i < kShortList && gains[i].first > 0.0) ranked.push_back(gains[i].second);
      delay = delay || of_bus;
    }
    add_loads(have, &ranked);
    return ranked;
  }

  // If a link's mass or centre of mass is tried, the link's load is tried as well.
  void add_loads(const Terms& have, Terms* ranked) const {
    std::set<int> links;
    for (size_t term : *ranked) {
      if (is_link_mass(design_.whole[term])) links.insert(design_.whole[term].place);
    }
    for (size_t term = 0; term < design_.whole.size(); ++term) {
      const bool there = has(have, term) || has(*ranked, term);
      if (!there && design_.whole[term].row->load && links.count(design_.whole[term].place)) ranked->push_back(term);
    }
  }

  // Fitted parameters of the model's terms of the whole robot, by column of all such terms; 0 for the others.
  Eigen::VectorXd spread_whole(const TorqueModel& model, const TorqueFit& fit) const {
    Eigen::VectorXd theta = Eigen::VectorXd::Zero(whole_width());
    const Slots slots = list_slots(design_, model);
    for (size_t t = 0; t < model.whole.size(); ++t) {
      const long columns = design_.whole[model.whole[t]].columns();
      theta.segment(design_.whole_first[model.whole[t]], columns) = fit.theta.segment(slots.whole[t], columns);
    }
    return theta;
  }

  bool is_choice_physical(const Choice& choice) const { return is_model_physical(design_, choice.model, choice.fit); }

  // A bus delay replaces delays of joints and makes the model smaller, so it needs no additional gain.
  double get_margin(size_t whole_term) const { return design_.whole[whole_term].row->is_of_bus() ? 0.0 : kWholeGain; }

  bool add_whole(Choice* choice) const {
    Choice best;
    double most = 0.0;
    bool found = false;
    for (size_t term : rank_whole(choice->model.whole)) {
      const Terms whole = add_term(choice->model.whole, term);
      if (is_twice(whole)) continue;
      const Choice with = choose_from_either(whole, choice->model.own);
      const double gain = with.fit.evidence - choice->fit.evidence - get_margin(term);
      if (gain > most && is_choice_physical(with)) {
        best = with;
        most = gain;
        found = true;
      }
    }
    if (found) *choice = best;
    return found;
  }

  const TorqueDesign& design_;
  const int jobs_;
  const Timing timing_;
};

bool has_late_terms(const TorqueDesign& design, const TorqueModel& model) {
  const auto is_late_in = [](const std::vector<Term>& terms) {
    return [&terms](size_t t) { return terms[t].row->late; };
  };
  for (size_t i = 0; i < model.own.size(); ++i) {
    if (std::any_of(model.own[i].begin(), model.own[i].end(), is_late_in(design.joints[i].terms))) return true;
  }
  return std::any_of(model.whole.begin(), model.whole.end(), is_late_in(design.whole));
}

// True if the term alone is so much more than all of the missing torque that other terms take it back but for less than
// a detail: a constant and dry friction of a joint that turns one way. Their sum shows, neither of them does.
bool is_taken_back(const JointDesign& joint, size_t term, const Eigen::VectorXd& p) {
  return kDetail * kDetail * calc_square(joint.total, list_columns(joint, term), p) > joint.total.c;
}

}  // namespace

std::vector<Terms> list_usual_terms(const TorqueDesign& design) {
  std::vector<Terms> usual;
  for (const JointDesign& joint : design.joints) {
    usual.emplace_back();
    for (size_t t = 0; t < joint.terms.size(); ++t) {
      if (joint.terms[t].row->usual) usual.back().push_back(t);
    }
  }
  return usual;
}

bool is_model_physical(const TorqueDesign& design, const TorqueModel& model, const TorqueFit& fit) {
  const Slots slots = list_slots(design, model);
  for (size_t i = 0; i < design.joints.size(); ++i) {
    const Terms& own = model.own[i];
    if (own.empty()) continue;
    long columns = 0;
    for (size_t term : own) columns += design.joints[i].terms[term].columns();
    if (!is_physical(design, i, own, fit.theta.segment(slots.own[i][0], columns))) return false;
  }
  for (size_t t = 0; t < model.whole.size(); ++t) {
    const Term& term = design.whole[model.whole[t]];
    if (!is_whole_physical(design, term, fit.theta.segment(slots.whole[t], term.columns()))) return false;
  }
  return true;
}

bool is_physical(const TorqueDesign& design, size_t at, const Terms& terms, const Eigen::VectorXd& theta) {
  long column = 0;
  for (size_t term : terms) {
    const Term& own = design.joints[at].terms[term];
    const Eigen::VectorXd p = theta.segment(column, own.columns());
    if (!own.row->allows(p) || is_taken_back(design.joints[at], term, p)) return false;
    column += own.columns();
  }
  return true;
}

Eigen::VectorXd drop_unseen(const TorqueDesign& design, const Term& term, Eigen::VectorXd p) {
  const auto is_it = [&](const Term& t) { return t.row == term.row && t.place == term.place && t.shape == term.shape; };
  const auto at = std::find_if(design.whole.begin(), design.whole.end(), is_it);
  if (at == design.whole.end()) return p;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(p.size());
  for (const JointDesign& joint : design.joints) {
    const Columns columns = list_whole_columns(design, joint, static_cast<size_t>(at - design.whole.begin()));
    for (long c = 0; c < p.size(); ++c)
      squares[c] += joint.total.get(columns[static_cast<size_t>(c)], columns[static_cast<size_t>(c)]);
  }
  for (long c = 0; c < p.size(); ++c) {
    const bool mass = term.row->load && c == 0;  // its position is moment over mass
    // No more than a trace of the term's best column, of which these are squares.
    if (!mass && squares[c] < kTrace * kTrace * squares.maxCoeff()) p[c] = 0.0;
  }
  return p;
}

bool is_whole_physical(const TorqueDesign& design, const Term& term, const Eigen::VectorXd& all) {
  const Eigen::VectorXd p = drop_unseen(design, term, all);
  return term.row->allows(p, find_reach(*design.data, term));
}

Choice choose_joint_terms(const TorqueDesign& design, int jobs) {
  return Chooser(design, jobs, Timing::kFree).run_joints();
}

std::vector<Choice> list_loads_instead(const TorqueDesign& design, const TorqueModel& model, size_t at, int jobs) {
  const Chooser chooser(design, jobs, has_late_terms(design, model) ? Timing::kFree : Timing::kAsRecorded);
  std::vector<Choice> list;
  for (size_t load = 0; load < design.whole.size(); ++load) {
    if (!design.whole[load].row->load || has(model.whole, load)) continue;
    Terms whole = model.whole;
    whole.erase(whole.begin() + static_cast<long>(at));
    whole.push_back(load);
    Choice with = chooser.choose_beside(whole);
    if (is_model_physical(design, with.model, with.fit)) list.push_back(std::move(with));
  }
  return list;
}

Choice choose_torque_model(const TorqueDesign& design, int jobs, Timing timing) {
  return Chooser(design, jobs, timing).run();
}

}  // namespace hrp::diagnosis
