// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/subsets.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/has.h"
#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

constexpr int kMostTerms = 7;  // in one subset

using Terms = std::vector<size_t>;

double get_parameter(const JointDesign& joint, const Terms& terms, const Eigen::VectorXd& theta,
                     bool TermRow::*property) {
  long at = 0;
  for (size_t term : terms) {
    if (joint.terms[term].row->*property) return theta[at];
    at += joint.terms[term].columns();
  }
  return 0.0;
}

bool has_term(const JointDesign& joint, const Terms& terms, bool TermRow::*property) {
  return std::any_of(terms.begin(), terms.end(), [&](size_t t) { return joint.terms[t].row->*property; });
}

Columns list_own(const JointDesign& joint, const Terms& terms) {
  Columns columns;
  for (size_t term : terms) {
    const Columns own = list_columns(joint, term);
    columns.insert(columns.end(), own.begin(), own.end());
  }
  return columns;
}

// Subtracts the whole robot's terms with the parameters `whole`, most of them zero, from sums of the joint's own
// columns.
void subtract_whole(const Gram& all, const Eigen::VectorXd& whole, Gram* own) {
  const long width = own->b.size();
  for (long i = 0; i < whole.size(); ++i) {
    if (whole[i] == 0.0) continue;
    for (long j = 0; j < width; ++j) own->b[j] -= all.get(width + i, j) * whole[i];
    double G_whole = 0.0;
    for (long j = 0; j < whole.size(); ++j) {
      if (whole[j] != 0.0) G_whole += all.get(width + i, width + j) * whole[j];
    }
    own->c += whole[i] * (G_whole - 2.0 * all.b[width + i]);
  }
}

class SubsetSearch {
 public:
  SubsetSearch(const TorqueDesign& design, size_t joint, const Eigen::VectorXd& whole, Timing timing)
      : design_(design), at_(joint), joint_(design.joints[joint]), timing_(timing) {
    const long width = joint_.own_width;
    folds_.assign(joint_.train.size(), Gram(width));
    for (size_t f = 0; f < folds_.size(); ++f) {
      const Gram& all = joint_.train[f];
      folds_[f].G = all.G.topLeftCorner(width, width);
      folds_[f].b = all.b.head(width);
      folds_[f].c = all.c;
      folds_[f].n = all.n;
      subtract_whole(all, whole, &folds_[f]);
    }
    total_ = sum(folds_, joint_.own_width);
  }

  // Physical subsets, best first.
  std::vector<Subset> run() {
    const Terms pool = list_pool();
    std::vector<Subset> subsets;
    // [nats] Below the best subset by so much, rounding loses a weight.
    const double lost = -std::log(std::numeric_limits<double>::epsilon());
    double least = -1e299;                                       // evidence below which a subset has no weight
    for (size_t mask = size_t{1} << pool.size(); mask-- > 0;) {  // the richest first: they are the best, as a rule
      Terms terms;
      for (size_t i = 0; i < pool.size(); ++i) {
        if (mask >> i & 1) terms.push_back(pool[i]);
      }
      if (static_cast<int>(terms.size()) > kMostTerms || !is_sensible(joint_, terms)) continue;
      const Subset subset = judge(terms, least);
      if (subset.evidence <= least) continue;
      subsets.push_back(subset);
      least = std::max(least, subset.evidence - lost);
    }
    std::sort(subsets.begin(), subsets.end(), [](const Subset& a, const Subset& b) { return a.evidence > b.evidence; });
    return subsets;
  }

 private:
  // Evidence -1e300 if the subset is not physical, or if it cannot exceed `least`. What a fit to all folds leaves is at
  // most what the folds leave that are predicted from the others, so it bounds the evidence at the cost of one
  // solution.
  Subset judge(const Terms& terms, double least) const {
    const Columns columns = list_own(joint_, terms);
    const Eigen::VectorXd theta = solve(total_, columns);
    Subset subset{terms, -1e300, {}};
    double cost = calc_gain_cost(joint_, terms, theta);
    long at = 0;
    for (size_t term : terms) {
      cost += joint_.terms[term].row->cost;
      subset.first.push_back(theta[at]);
      at += joint_.terms[term].columns();
    }
    const double per_effort = calc_per_effort(joint_, terms, theta), n = std::max(1.0, total_.n);
    if (calc_evidence(joint_, per_effort * calc_rest(total_, columns, theta) / n) - cost <= least) return subset;
    if (!is_physical(design_, at_, terms, theta) || !has_bracketed_gain(terms)) return subset;
    subset.evidence = calc_evidence(joint_, per_effort * cross_validate(folds_, total_, columns)) - cost;
    return subset;
  }

  // Ratio of mean squares at which a term repays its prior cost and gains kOdds nats, as a supported term must. Each
  // term of the pool doubles the number of subsets, so weak ones are left out.
  double calc_worth(const TermRow& row) const {
    return std::exp(-2.0 * (row.cost + kOdds) / std::max(1.0, joint_.effective));
  }

  // True if the estimates of a gain from the effort column and from the torque column agree: both on the same side of
  // one, and close.
  bool has_bracketed_gain(const Terms& terms) const {
    if (!has_term(joint_, terms, &TermRow::scales_effort)) return true;
    const double k =
        1.0 - get_parameter(joint_, terms, solve(total_, list_own(joint_, terms)), &TermRow::scales_effort);
    Terms other;
    for (size_t term : terms) other.push_back(joint_.terms[term].row->scales_effort ? term + 1 : term);
    std::sort(other.begin(), other.end());
    const double g = get_parameter(joint_, other, solve(total_, list_own(joint_, other)), &TermRow::scales_model);
    const double other_k = 1.0 / std::max(1e-3, 1.0 + g), middle = 0.5 * (k + other_k);
    return (k - 1.0) * (other_k - 1.0) > 0.0 && std::abs(k - other_k) < kBracket * std::abs(middle - 1.0);
  }

  bool is_barred(const TermRow& row) const { return has(joint_.barred, &row); }

  // Terms that may be in a subset. Of terms with several shapes, the shape that fits best beside the usual terms.
  // Hysteresis and gears that are hard to drive backwards only if they repay their cost beside all of these, because
  // friction explains much of them.
  Terms list_pool() const {
    Terms pool, base;
    for (size_t t = 0; t < joint_.terms.size(); ++t) {
      const TermRow& row = *joint_.terms[t].row;
      if (is_barred(row) || row.scanned || row.scales_model || row.only_beside_all ||
          (row.scales_effort && !joint_.loaded))
        continue;
      pool.push_back(t);
      if (row.usual || row.is_constant()) base.push_back(t);
    }
    Terms all = base;
    for (const TermRow& row : list_term_rows()) {
      if (is_barred(row) || !row.scanned || row.only_beside_all || (row.late && timing_ == Timing::kAsRecorded))
        continue;
      add_best(row, base, 1e300, &pool, &all);
    }
    const double without = cross_validate(folds_, total_, list_own(joint_, all));
    for (const TermRow& row : list_term_rows()) {
      if (row.whole || !row.only_beside_all || is_barred(row)) continue;
      const double least = row.memory ? std::min(without, calc_pre_sliding(row, all)) : without;
      add_best(row, all, least * calc_worth(row), &pool, &all);
    }
    return pool;
  }

  // Mean square if dry friction acts through the memory term only, as in pre-sliding. True hysteresis beside an
  // instantaneous level must leave less.
  double calc_pre_sliding(const TermRow& memory, const Terms& all) const {
    Terms beside;
    for (size_t t : all) {
      if (!joint_.terms[t].row->level) beside.push_back(t);
    }
    double least = 1e300;
    for (size_t t = 0; t < joint_.terms.size(); ++t) {
      if (joint_.terms[t].row != &memory) continue;
      Terms with = beside;
      with.push_back(t);
      least = std::min(least, cross_validate(folds_, total_, list_own(joint_, with)));
    }
    return least;
  }

  // Adds the joint's term of this row with the smallest mean square beside the given terms, if that is below `least`.
  void add_best(const TermRow& row, const Terms& beside, double least, Terms* pool, Terms* all) const {
    size_t chosen = joint_.terms.size();
    for (size_t t = 0; t < joint_.terms.size(); ++t) {
      if (joint_.terms[t].row != &row || (row.least_shape > 0.0 && joint_.terms[t].shape <= row.least_shape)) continue;
      Terms with = beside;
      with.push_back(t);
      const double cross = cross_validate(folds_, total_, list_own(joint_, with));
      if (cross < least) {
        least = cross;
        chosen = t;
      }
    }
    if (chosen < joint_.terms.size()) {
      pool->push_back(chosen);
      all->push_back(chosen);
    }
  }

  const TorqueDesign& design_;
  const size_t at_;
  const JointDesign& joint_;
  const Timing timing_;
  std::vector<Gram> folds_;
  Gram total_;
};

}  // namespace

// Rules: a Stribeck excess needs a friction level. Hysteresis also needs one, because pre-sliding looks like it. A
// spring has its own constant. A lag and a delay have the same signature. A backdriving loss 2 mu with a gain of 1 + mu
// equals load-dependent friction mu, so the two exclude each other.
bool is_sensible(const JointDesign& joint, const std::vector<size_t>& terms) {
  const auto count = [&](const auto& is) {
    return std::count_if(terms.begin(), terms.end(), [&](size_t t) { return is(*joint.terms[t].row); });
  };
  const bool needs_level = has_term(joint, terms, &TermRow::excess) || has_term(joint, terms, &TermRow::memory);
  if (needs_level && count([](const TermRow& r) { return r.is_dry(); }) == 0) return false;
  if (has_term(joint, terms, &TermRow::backwards) && has_term(joint, terms, &TermRow::scales_effort)) return false;
  return count([](const TermRow& r) { return r.effect->family == EffectFamily::kTiming; }) < 2 &&
         count([](const TermRow& r) { return r.constant >= 0; }) < 2;
}

std::vector<Subset> list_subsets(const TorqueDesign& design, size_t joint, const Eigen::VectorXd& whole,
                                 Timing timing) {
  return SubsetSearch(design, joint, whole, timing).run();
}

// Probability of each term, and how much its first parameter differs between subsets (Bayesian model averaging).
void average(const std::vector<Subset>& subsets, std::vector<double>* inclusion, std::vector<double>* std) {
  std::vector<double> mean(inclusion->size(), 0.0), square(mean);
  double all = 0.0;
  for (const Subset& subset : subsets) {
    const double weight = std::exp(subset.evidence - subsets[0].evidence);
    all += weight;
    for (size_t i = 0; i < subset.terms.size(); ++i) {
      const size_t term = subset.terms[i];
      (*inclusion)[term] += weight;
      mean[term] += weight * subset.first[i];
      square[term] += weight * subset.first[i] * subset.first[i];
    }
  }
  for (size_t t = 0; t < mean.size(); ++t) {
    const double weight = (*inclusion)[t];
    if (weight > 0.0) (*std)[t] = std::sqrt(std::max(0.0, square[t] / weight - mean[t] * mean[t] / (weight * weight)));
    (*inclusion)[t] = weight / all;
  }
}

}  // namespace hrp::diagnosis
