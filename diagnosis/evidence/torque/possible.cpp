// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/possible.h"

#include <algorithm>
#include <set>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/subsets.h"
#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {
namespace {

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
    return list_;
  }

 private:
  // True if the family at this joint is in the model or a rival of a named term.
  bool is_listed(EffectFamily family, int joint) const {
    const auto is_it = [&](const Term& t) { return t.effect().family == family && (t.whole() || t.place == joint); };
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
        if (own > most) {
          most = own;
          likeliest = t;
        }
      }
      if (probability >= kMinority) add_own(i, likeliest, probability);
    }
  }

  void add_own(size_t i, size_t term, double probability) {
    Candidate c{choice_, {static_cast<int>(i), 0}, probability};
    std::vector<size_t>& own = c.choice.model.own[i];
    const auto at = own.insert(std::lower_bound(own.begin(), own.end(), term), term);
    c.place.at = static_cast<size_t>(at - own.begin());
    if (is_sensible(design_.joints[i], own)) list_.push_back(std::move(c));
  }

  const TorqueDesign& design_;
  const Choice& choice_;
  const std::vector<GradedTerm>& graded_;
  std::vector<Candidate> list_;
};

// The conditions of a finding, except the one on evidence.
bool is_worth_listing(const TorqueDesign& design, const Candidate& c, const GradedTerm& g) {
  const double size = g.parameters.norm();
  const auto over = [&](const Eigen::VectorXd& std) { return (g.parameters.array() != 0.0).select(std, 0.0).norm(); };
  // parts of the recordings agree about the sign
  const bool told = size > kNinetyFive * over(g.std) && size > over(g.width);
  const auto joint = static_cast<size_t>(c.place.joint);
  return told && g.helps_held && g.share > kMinor && g.agreement >= kMostly && size >= g.term.row->material &&
         !g.term.row->excess && is_physical(design, joint, {c.choice.model.own[joint][c.place.at]}, g.parameters);
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
  for (size_t i = 0; i < all.size(); ++i) {
    if (!is_worth_listing(design, candidates[i], all[i])) continue;
    all[i].named = true;
    all[i].grade = Grade::kAmbiguous;
    list.push_back(std::move(all[i]));
  }
  return list;
}

}  // namespace hrp::diagnosis
