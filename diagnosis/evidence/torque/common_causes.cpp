// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/common_causes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/has.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/intervals.h"

namespace hrp::diagnosis {
namespace {

using Terms = std::vector<size_t>;

class Search {
 public:
  Search(const TorqueDesign& design, const Gap& gap, const GradedTerm& g) : design_(design), gap_(gap), g_(g) {}

  std::vector<Rival> run() {
    TorqueModel lighter = gap_.rest;
    const auto is_mass = [&](size_t t) { return design_.whole[t].row->is_of_mass(); };
    lighter.whole.erase(std::remove_if(lighter.whole.begin(), lighter.whole.end(), is_mass), lighter.whole.end());
    const bool several = g_.term.row->is_of_mass() && lighter.whole.size() < gap_.rest.whole.size();
    std::vector<Rival> rivals = list_gains(gap_.rest);
    if (!several) return rivals;
    if (rivals.empty()) rivals = list_gains(lighter);
    for (size_t load = 0; load < design_.whole.size(); ++load) {
      if (!design_.whole[load].row->load || has(gap_.model.whole, load) || !is_wrong_link(load)) continue;
      if (std::optional<Rival> rival = try_load(load, lighter)) rivals.push_back(std::move(*rival));
    }
    return rivals;
  }

 private:
  double sum_likelihood(const TorqueFit& fit) const {
    double sum = 0.0;
    for (size_t i = 0; i < design_.joints.size(); ++i) sum += calc_blurred_evidence(design_.joints[i], fit.cross[i]);
    return sum;
  }

  // Without prior costs: one log of currents is as likely as one wrong mass.
  std::vector<Rival> list_gains(TorqueModel model) const {
    const std::vector<Terms> usual = list_usual_terms(design_);
    std::vector<std::pair<size_t, size_t>> gains;  // joint of the design, term
    for (size_t i = 0; i < design_.joints.size(); ++i) {
      const bool shown = std::any_of(gap_.model.whole.begin(), gap_.model.whole.end(), [&](size_t t) {
        return !has(model.whole, t) && is_shown(design_, design_.whole[t], design_.joints[i]);
      });
      const std::optional<size_t> gain = shown ? exchange_gain(i, usual[i], &model.own[i]) : std::nullopt;
      if (gain) gains.emplace_back(i, *gain);
    }
    const TorqueFit fit = fit_torque(design_, model);
    if (gains.empty() || sum_likelihood(fit) < sum_likelihood(gap_.fit) - kSame) return {};
    std::vector<Rival> rivals;
    const Slots slots = list_slots(design_, model);
    for (const auto& [i, gain] : gains) {
      const Terms& own = model.own[i];
      const size_t at = static_cast<size_t>(std::find(own.begin(), own.end(), gain) - own.begin());
      const Eigen::VectorXd value = fit.theta.segment(slots.own[i][at], 1);
      // Of a joint where little of the torque shows, the gain may be anything.
      if (!(std::abs(std::log(std::max(1e-300, 1.0 + value[0]))) < kFactor)) continue;
      rivals.push_back({design_.joints[i].terms[gain], value, {}, model, {static_cast<int>(i), at}});
    }
    return rivals;
  }

  // Takes the gain by the model's torque, in place of that by the effort: what is left is then in the unit of the log,
  // as without a gain. Which of friction and rotor show beside a mass depends on the mass.
  std::optional<size_t> exchange_gain(size_t i, const Terms& usual, Terms* own) const {
    const std::vector<Term>& terms = design_.joints[i].terms;
    const auto is_gain = [&](size_t t) { return terms[t].row->scales_effort || terms[t].row->scales_model; };
    own->erase(std::remove_if(own->begin(), own->end(), is_gain), own->end());
    const auto gain = std::find_if(terms.begin(), terms.end(), [](const Term& t) { return t.row->scales_model; });
    if (gain == terms.end()) return std::nullopt;
    const size_t term = static_cast<size_t>(gain - terms.begin());
    insert(term, own);
    for (size_t other : usual) insert(other, own);
    return term;
  }

  static void insert(size_t term, Terms* own) {
    if (!has(*own, term)) own->insert(std::upper_bound(own->begin(), own->end(), term), term);
  }

  bool is_wrong_link(size_t load) const {
    return std::any_of(gap_.model.whole.begin(), gap_.model.whole.end(), [&](size_t t) {
      return design_.whole[t].row->is_of_mass() && design_.whole[t].place == design_.whole[load].place;
    });
  }

  // A load that is no point has more inertia than one: that of its link's centre of mass, moved, is the rest. Both
  // together are one load, with the sum of both moments.
  std::optional<Rival> try_load(size_t load, TorqueModel model) const {
    const Term& term = design_.whole[load];
    model.whole.push_back(load);
    for (size_t t = 0; t < design_.whole.size(); ++t) {
      if (design_.whole[t].row->effect->id == EffectId::kComError && design_.whole[t].place == term.place)
        model.whole.push_back(t);
    }
    const size_t at =
        static_cast<size_t>(std::find(model.whole.begin(), model.whole.end(), load) - model.whole.begin());
    const TorqueFit fit = fit_torque(design_, model, true);
    const Slots slots = list_slots(design_, model);
    const Eigen::VectorXd known = calc_considered_std(design_, model, fit);
    const double link = design_.data->experiment->robot.tree.links[static_cast<size_t>(term.place)].inertia.mass;
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(4, slots.size);
    sum.middleCols(slots.whole[at], 4).setIdentity();
    double more = 0.0;  // [nats] prior cost of what is counted as a part of the load
    if (at + 1 < model.whole.size()) {
      sum.block(1, slots.whole[at + 1], 3, 3) = link * Matrix3d::Identity();
      more = design_.whole[model.whole[at + 1]].row->cost;
    }
    const Eigen::VectorXd p = drop_unseen(design_, term, sum * fit.theta);
    const double gain = calc_blurred_evidence(design_, fit) + more - calc_blurred_evidence(design_, gap_.fit);
    if (gain < -kSame || !is_whole_physical(design_, term, p)) return std::nullopt;
    const Eigen::VectorXd variance = (sum * fit.covariance * sum.transpose()).diagonal().cwiseMax(0.0) +
                                     known.segment(slots.whole[at], 4).cwiseAbs2();
    return Rival{term, p, (p.array() != 0.0).select(variance.cwiseSqrt(), 0.0), model, {-1, at}};
  }

  const TorqueDesign& design_;
  const Gap& gap_;
  const GradedTerm& g_;
};

}  // namespace

std::vector<Rival> list_common_causes(const TorqueDesign& design, const Gap& gap, const GradedTerm& g) {
  return Search(design, gap, g).run();
}

bool is_shown(const TorqueDesign& design, const Term& whole, const JointDesign& joint) {
  for (size_t t = 0; t < design.whole.size(); ++t) {
    if (design.whole[t].row != whole.row || design.whole[t].place != whole.place) continue;
    for (long c : list_whole_columns(design, joint, t)) {
      if (joint.total.get(c, c) > 0.0) return true;
    }
  }
  return false;
}

}  // namespace hrp::diagnosis
