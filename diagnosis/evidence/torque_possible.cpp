// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque_possible.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque_subsets.h"
#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {
namespace {

constexpr double kPossible = 0.2;    // probability of a family: odds of one to four
constexpr double kMostSame = 0.85;   // of the stretches must give the same sign, as of any finding
constexpr double kLeast = 0.05;      // of its joint's held-out mismatch, as of any finding

struct Candidate {
  Choice choice;  // with the term
  TermPlace place;
  double probability = 0.0;
};

class Lister {
 public:
  Lister(const TorqueDesign& design, const Choice& choice, const std::vector<GradedTerm>& graded)
      : design_(design), choice_(choice), graded_(graded) {}

  std::vector<Candidate> run() {
    for (size_t i = 0; i < design_.joints.size(); ++i) add_of_joint(i);
    add_of_robot();
    return list_;
  }

 private:
  // In the model, or a rival of what is: at a joint, or (-1) anywhere.
  bool is_listed(EffectFamily family, int joint) const {
    const auto is_it = [&](const Term& t) {
      return t.effect().family == family && (joint < 0 || t.whole() || t.place == joint);
    };
    return std::any_of(graded_.begin(), graded_.end(), [&](const GradedTerm& g) {
      const bool rival = std::any_of(g.rivals.begin(), g.rivals.end(), [&](const Rival& r) { return is_it(r.term); });
      return is_it(g.term) || (g.named && rival);
    });
  }

  void add_of_joint(size_t i) {
    const JointDesign& joint = design_.joints[i];
    std::set<EffectFamily> families;
    for (const Term& term : joint.terms) families.insert(term.effect().family);
    for (EffectFamily family : families) {
      if (is_listed(family, joint.joint)) continue;
      double probability = 0.0, most = 0.0;
      size_t likeliest = 0;
      for (size_t t = 0; t < joint.terms.size(); ++t) {
        if (joint.terms[t].effect().family != family) continue;
        const double own = choice_.inclusion[i][t];
        probability += own;
        if (own > most) most = own, likeliest = t;
      }
      if (probability >= kPossible) add_own(i, likeliest, probability);
    }
  }

  void add_own(size_t i, size_t term, double probability) {
    Candidate c{choice_, {static_cast<int>(i), 0}, probability};
    std::vector<size_t>& own = c.choice.model.own[i];
    const auto at = own.insert(std::lower_bound(own.begin(), own.end(), term), term);
    c.place.at = static_cast<size_t>(at - own.begin());
    if (is_sensible(design_.joints[i], own)) list_.push_back(std::move(c));
  }

  // A term of the whole robot pays for all that could have been in its place: that much less, and it is possible. Of a
  // family the one that adds most.
  void add_of_robot() {
    const double least = std::log(std::max(1.0, static_cast<double>(design_.whole.size())));
    std::vector<Candidate> best;
    for (size_t t = 0; t < design_.whole.size(); ++t) {
      const Term& term = design_.whole[t];
      if (term.row->is_of_bus() || is_listed(term.effect().family, -1)) continue;
      Candidate c{choice_, {-1, choice_.model.whole.size()}, 0.0};
      c.choice.model.whole.push_back(t);
      const double gain = fit_torque(design_, c.choice.model).evidence - choice_.fit.evidence;
      if (gain < least) continue;
      c.probability = 1.0 / (1.0 + std::exp(kWholeGain - gain));
      const auto same = std::find_if(best.begin(), best.end(), [&](const Candidate& b) {
        return design_.whole[b.choice.model.whole.back()].effect().family == term.effect().family;
      });
      if (same == best.end()) best.push_back(std::move(c));
      else if (c.probability > same->probability) *same = std::move(c);
    }
    list_.insert(list_.end(), best.begin(), best.end());
  }

  const TorqueDesign& design_;
  const Choice& choice_;
  const std::vector<GradedTerm>& graded_;
  std::vector<Candidate> list_;
};

bool is_physical_term(const TorqueDesign& design, const GradedTerm& g) {
  return g.term.whole() ? is_whole_physical(design, g.term, g.parameters) : g.term.row->allows(g.parameters);
}

// What any finding has to show, but for the evidence.
bool is_worth_listing(const TorqueDesign& design, const GradedTerm& g) {
  const bool told = g.parameters.norm() > kNinetyFive * (g.parameters.array() != 0.0).select(g.std, 0.0).norm();
  return told && g.helps_held && g.share > kLeast && g.agreement >= kMostSame &&
         g.parameters.norm() >= g.term.row->material && !g.term.row->excess && is_physical_term(design, g);
}

}  // namespace

std::vector<GradedTerm> list_possible_terms(const TorqueDesign& design, const Choice& choice,
                                            const std::vector<GradedTerm>& graded, int jobs) {
  const std::vector<Candidate> candidates = Lister(design, choice, graded).run();
  std::vector<GradedTerm> all(candidates.size()), list;
  parallel_for(jobs, static_cast<int>(all.size()), [&](int i) {
    const Candidate& c = candidates[static_cast<size_t>(i)];
    all[static_cast<size_t>(i)] = grade_term(design, c.choice, c.place);
    all[static_cast<size_t>(i)].probability = c.probability;
  });
  for (GradedTerm& g : all) {
    if (!is_worth_listing(design, g)) continue;
    g.named = true, g.grade = Grade::kAmbiguous;
    list.push_back(std::move(g));
  }
  return list;
}

}  // namespace hrp::diagnosis
