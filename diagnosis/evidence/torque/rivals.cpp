// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/rivals.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/has.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/common_causes.h"
#include "diagnosis/model/last_link.h"
#include "diagnosis/model/tree.h"

namespace hrp::diagnosis {
namespace {

class RivalSearch {
 public:
  RivalSearch(const TorqueDesign& design, const Gap& gap, size_t judge, const GradedTerm& g)
      : design_(design),
        model_(gap.model),
        fit_(gap.fit),
        rest_(gap.rest),
        alone_(gap.alone),
        slots_(list_slots(design, gap.model)),
        i_(judge),
        g_(g) {}

  std::vector<Rival> run() {
    compare_own();
    if (g_.term.whole() && (g_.term.row->needs_drive || g_.term.row->load)) add_common_causes();
    compare_whole();
    if (add_constant()) {
      compare_own();
      compare_whole();
      add_less_inertia();
    }
    if (g_.term.row->scales_effort) {
      add_equal_mass();
      compare_masses();
    }
    if (g_.term.row->pulls) add_loads();
    if (!g_.term.whole() && is_rotor(g_.term)) add_own_inertia();
    add_turned_link();
    return rivals_;
  }

 private:
  // A spring's rest is a constant torque, and its stiffness another torque over position. What else has that stiffness,
  // such as less inertia in a free swing, has its place only beside a constant: that is added to the rest. False if
  // there is none to add.
  bool add_constant() {
    if (g_.term.whole() || g_.term.row->constant < 0 || g_.term.row->is_constant()) return false;
    const std::vector<Term>& terms = design_.joints[i_].terms;
    const auto constant = std::find_if(terms.begin(), terms.end(), [](const Term& t) { return t.row->is_constant(); });
    if (constant == terms.end()) return false;
    const size_t term = static_cast<size_t>(constant - terms.begin());
    if (has(rest_.own[i_], term)) return false;
    add_own_term(i_, term, &rest_);
    beside_ = constant->row->cost;
    return true;
  }

  // A link that swings freely swings faster with a spring and with less inertia alike: its acceleration is in
  // proportion to its angle. Less inertia is a rotor below zero.
  void add_less_inertia() {
    const TreeSpec& tree = design_.data->experiment->robot.tree;
    const int joint = g_.term.place;
    if (tree.joint(joint).actuated || !is_last(tree, joint + 1)) return;
    const std::vector<Term>& terms = design_.joints[i_].terms;
    const auto rotor = std::find_if(terms.begin(), terms.end(), &is_rotor);
    if (rotor == terms.end() || has(rest_.own[i_], static_cast<size_t>(rotor - terms.begin()))) return;
    const OwnTerm less = fit_own(static_cast<size_t>(rotor - terms.begin()), rest_);
    if (!(less.value[0] < 0.0) || !fills(*rotor, less.fit, less.value)) return;
    if (-less.value[0] < calc_own_inertia(tree, joint))
      rivals_.push_back({*rotor, less.value, {}, less.model, {static_cast<int>(i_), less.at}});
    else
      add_moved_mass(joint, less.value[0]);
  }

  // A link that swings freely shows its inertia over its moment alone. What turns with it may be a released drive, but
  // as well the link itself has more inertia, or its mass is farther from the axis.
  void add_own_inertia() {
    const TreeSpec& tree = design_.data->experiment->robot.tree;
    const int joint = g_.term.place;
    if (tree.joint(joint).kind != JointKind::kRevolute || tree.joint(joint).actuated || !is_last(tree, joint + 1))
      return;
    if (calc_own_inertia(tree, joint) > 0.0) rivals_.push_back({g_.term, g_.parameters, g_.width, {}, {}});
    add_moved_mass(joint, g_.parameters[0]);
  }

  // The mass of a link may be nearer to the axis or farther from it: at x, inertia over moment, (I + m x^2) / (m x), is
  // that with `more` [kg m^2] of inertia. A small mass at the end of a link has no inertia of its own to lose.
  void add_moved_mass(int joint, double more) {
    const TreeSpec& tree = design_.data->experiment->robot.tree;
    const std::optional<LastLink> last = find_last_link(tree, joint);
    if (!last) return;
    const double mass = tree.links[static_cast<size_t>(joint) + 1].inertia.mass, own = calc_own_inertia(tree, joint);
    const double half = 0.5 * (last->length + (own + more) / (mass * last->length)), root = half * half - own / mass;
    if (!(half > 0.0) || root < 0.0) return;
    const double change = half + std::sqrt(root) - last->length;
    const double width = std::abs(change * g_.width[0] / g_.parameters[0]);
    rivals_.push_back({{&find_term_row(&TermRow::within_reach), joint + 1},
                       change * last->out,
                       width * last->out.cwiseAbs(),
                       {},
                       {}});
  }

  bool has_level() const {
    const auto is_level = [&](size_t term) { return design_.joints[i_].terms[term].row->level; };
    return std::any_of(rest_.own[i_].begin(), rest_.own[i_].end(), is_level);
  }

  bool is_listed(const Term& term) const {
    return std::any_of(rivals_.begin(), rivals_.end(),
                       [&](const Rival& r) { return r.term.row == term.row && r.term.place == term.place; });
  }

  // If a drive carries one link alone from the base, its gain and the link's mass scale the same torque in every
  // motion. The mass is then a rival, whatever its evidence, and the first: a report lists a few.
  void add_equal_mass() {
    const TreeSpec& tree = design_.data->experiment->robot.tree;
    const std::string& joint = tree.joint(g_.term.place).name;
    for (size_t link = 1; link < tree.links.size(); ++link) {
      const LinkSpec& own = tree.links[link];
      if (own.joint.name != joint || own.parent != 0 || !is_last(tree, static_cast<int>(link))) continue;
      const auto there = std::find_if(rivals_.begin(), rivals_.end(), [&](const Rival& r) {
        return r.term.row->factor && r.term.place == static_cast<int>(link);
      });
      if (there != rivals_.end()) {
        std::rotate(rivals_.begin(), there, there + 1);
        continue;
      }
      const double k = 1.0 - g_.parameters[0];
      if (!(k > 0.0)) continue;
      const Term mass{&find_term_row(&TermRow::factor), static_cast<int>(link)};
      rivals_.insert(rivals_.begin(), {mass, Eigen::VectorXd::Constant(1, 1.0 / k - 1.0), g_.width / (k * k), {}, {}});
    }
  }

  // Another zero of a joint turns the last link about its axis, and with it the centre of mass: to the first order, as
  // far as terms go, the same motion of the same weight. Each is a rival of the other, whatever the evidence of the
  // centre's other coordinates; of a centre of mass only if it may lie as far from the axis as the model's.
  void add_turned_link() {
    const bool is_zero = g_.term.row->effect->id == EffectId::kJointOffset;
    if (!is_zero && g_.term.row->effect->id != EffectId::kComError) return;
    const int joint = is_zero ? g_.term.place : g_.term.place - 1;
    const std::optional<LastLink> last = find_last_link(design_.data->experiment->robot.tree, joint);
    if (!last) return;
    const Eigen::VectorXd &p = g_.parameters, &width = g_.width;
    if (is_zero)
      add_unlisted(EffectId::kComError, joint + 1, -p[0] * last->length * last->turn,
                   width[0] * last->length * last->turn.cwiseAbs());
    else if (std::abs(p.dot(last->out)) < kNinetyFive * last->out.cwiseProduct(width).norm())
      add_unlisted(EffectId::kJointOffset, joint, Eigen::VectorXd::Constant(1, -p.dot(last->turn) / last->length),
                   Eigen::VectorXd::Constant(1, last->turn.cwiseProduct(width).norm() / last->length));
  }

  void add_unlisted(EffectId id, int place, const Eigen::VectorXd& value, const Eigen::VectorXd& width) {
    for (const Term& other : design_.whole) {
      const auto is_it = [&](const Term& t) { return t.row == other.row && t.place == place; };
      if (other.row->effect->id == id && is_it(other) && !is_listed(other) && is_whole_physical(design_, other, value))
        rivals_.push_back({other, value, width, {}, {}});
    }
  }

  // An unknown load makes every drive before it look weak. Therefore each change of one mass competes with all gains
  // together. The comparison uses the likelihood without prior costs, because the prior favours wrong gains over wrong
  // masses.
  void compare_masses() {
    TorqueModel rest = rest_;
    double costs = calc_term_cost(*g_.term.row, g_.parameters);
    for (size_t i = 0; i < rest.own.size(); ++i) costs += drop_gains(i, &rest.own[i]);
    for (size_t term = 0; term < design_.whole.size(); ++term) {
      const Term& other = design_.whole[term];
      if (!other.row->is_of_mass() || is_listed(other) || !is_beyond(other, i_) || has(rest.whole, term)) continue;
      TorqueModel model = rest;
      model.whole.push_back(term);
      const TorqueFit fit = fit_torque(design_, model);
      const Eigen::VectorXd p = fit.theta.segment(list_slots(design_, model).whole.back(), other.columns());
      if (fit.evidence + calc_term_cost(*other.row, p) - costs > fit_.evidence - kSame &&
          is_whole_physical(design_, other, p))
        add_whole(other, p, model);
    }
  }

  // A force that points down may be a weight.
  void add_loads() {
    for (const Choice& with : list_loads_instead(design_, model_, g_.place.at, 1)) {
      const Term& other = design_.whole[with.model.whole.back()];
      if (with.fit.evidence < fit_.evidence - kOdds || is_listed(other)) continue;
      add_whole(other, with.fit.theta.segment(list_slots(design_, with.model).whole.back(), other.columns()),
                with.model);
    }
  }

  void add_common_causes() {
    for (Rival& cause : list_common_causes(design_, {model_, fit_, rest_, alone_}, g_)) {
      if (!is_listed(cause.term)) rivals_.push_back(std::move(cause));
    }
  }

  // Adds a term of the whole robot, unless nothing of it shows in these recordings.
  void add_whole(const Term& other, const Eigen::VectorXd& p, const TorqueModel& model) {
    const Eigen::VectorXd seen = drop_unseen(design_, other, p);
    if (!seen.isZero(0.0)) rivals_.push_back({other, seen, {}, model, {-1, model.whole.size() - 1}});
  }

  // Removes the gain of a joint from its terms. Returns its prior cost [nats].
  double drop_gains(size_t i, std::vector<size_t>* terms) const {
    double costs = 0.0;
    std::vector<size_t> left;
    for (size_t at = 0; at < model_.own[i].size(); ++at) {
      const size_t term = model_.own[i][at];
      if (!has(*terms, term)) continue;
      if (design_.joints[i].terms[term].row->scales_effort)
        costs += calc_term_cost(*design_.joints[i].terms[term].row, fit_.theta.segment(slots_.own[i][at], 1));
      else
        left.push_back(term);
    }
    *terms = left;
    return costs;
  }

  // Evidence [nats] by which rivals of the term are compared. A spring is torque over position. So is what masses and
  // zeros leave that nobody knows to more than a share: no error counts below that.
  double weigh(const TorqueFit& fit) const {
    return g_.term.row->constant > 0 ? calc_blurred_evidence(design_, fit) : fit.evidence;
  }

  // True if `other` fits nearly as well in the place of the term: it recovers most of the term's gain, or has nearly
  // the same likelihood, such as a cart's mass and the rotor that drives it. `p`: parameters of `other`.
  bool fills(const Term& other, const TorqueFit& with, const Eigen::VectorXd& p) const {
    const bool of_one_mass = other.row->is_of_mass() && g_.term.row->is_of_mass() && other.place == g_.term.place;
    // Prior costs of factor sizes count, except between two descriptions of the same mass.
    const double costs =
        beside_ + (of_one_mass ? calc_term_cost(*other.row, p) - calc_term_cost(*g_.term.row, g_.parameters)
                               : other.row->cost - g_.term.row->cost);
    // other terms of the whole robot gain evidence at other joints as well
    const bool here = !other.whole() || design_.joints.size() == 1 || of_one_mass;
    if (here && weigh(with) + costs > weigh(fit_) - kSame) return true;
    if (here && judges_held(other, with)) return true;
    // A term that not every drive has and that the recordings hardly need: others do nearly as well, prior costs aside.
    const double weak = g_.term.row->usual ? 0.0 : kWholeGain - g_.gain;
    if (weak > 0.0 && weigh(with) + costs > weigh(fit_) - kSame - weak) return true;
    return weigh(with) > weigh(fit_) - kOdds && weigh(with) - weigh(alone_) > 0.5 * (weigh(fit_) - weigh(alone_));
  }

  // Two laws of one family, whatever their odds in training: recordings that were not fitted are the independent judge.
  // Where much is left that no law describes, odds change with the filter, and the held-out error may prefer the other
  // law.
  bool judges_held(const Term& other, const TorqueFit& with) const {
    return design_.joints[i_].has_held && is_same_family(other, g_.term) && with.held[i_] <= fit_.held[i_] &&
           with.evidence - alone_.evidence > kOdds;
  }

  // True if the place of a term moves with the joint, so that its effect appears there.
  bool is_beyond(const Term& other, size_t i) const {
    const TermRow& row = *other.row;
    if (row.place == PlaceKind::kNone || row.late) return true;
    if (row.place == PlaceKind::kJoint) return is_shown(design_, other, design_.joints[i]);
    return is_above(design_.data->experiment->robot.tree, design_.joints[i].joint + 1, other.place);
  }

  // Compares with the terms of the judge joint.
  void compare_own() {
    const std::vector<size_t>& have = model_.own[i_];
    for (size_t term = 0; term < design_.joints[i_].terms.size(); ++term) {
      const Term& other = design_.joints[i_].terms[term];
      if (has(have, term) || has(rest_.own[i_], term) || is_listed(other) || other.row->contains(*g_.term.row) ||
          other.row->effect == g_.term.row->effect)
        continue;
      // The pre-sliding of dry friction resembles hysteresis but is no other effect.
      if (other.row->memory && g_.term.row->is_dry()) continue;
      if (other.row->excess && !g_.term.row->is_dry() && !has_level()) continue;  // no law without its level
      // A gain by the model's torque scales the same regressor as a wrong mass, so it would always compete with it.
      const bool of_drive = g_.place.joint >= 0;
      if (other.row->scales_model && of_drive) continue;
      if (other.row->scales_effort && (!of_drive || !design_.joints[i_].loaded)) continue;
      if (add_own(term, rest_) || !is_same_family(other, g_.term)) continue;
      // Small terms that fit the one law may have no physical value beside the other: it is tried without each of them.
      for (size_t at = 0; at < rest_.own[i_].size(); ++at) {
        TorqueModel rest = rest_;
        rest.own[i_].erase(rest.own[i_].begin() + static_cast<long>(at));
        if (add_own(term, rest)) break;
      }
    }
  }

  // A term of the judge joint beside others: at `at` in its list.
  struct OwnTerm {
    TorqueModel model;
    TorqueFit fit;
    size_t at = 0;
    Eigen::VectorXd value, own;  // of the term, and of all terms of the joint
  };

  OwnTerm fit_own(size_t term, TorqueModel model) const {
    const size_t at = add_own_term(i_, term, &model);
    OwnTerm out{model, fit_torque(design_, model), at, {}, {}};
    const Slots slots = list_slots(design_, model);
    out.value = out.fit.theta.segment(slots.own[i_][out.at], design_.joints[i_].terms[term].columns());
    out.own = out.fit.theta.segment(slots.own[i_][0], count_columns(i_, model.own[i_]));
    return out;
  }

  // Adds the joint's term beside `model` to the rivals, if it fills the place and all values are physical.
  bool add_own(size_t term, const TorqueModel& model) {
    const Term& other = design_.joints[i_].terms[term];
    const OwnTerm with = fit_own(term, model);
    if (!fills(other, with.fit, with.value) || !is_physical(design_, i_, with.model.own[i_], with.own)) return false;
    rivals_.push_back({other, with.value, {}, with.model, {static_cast<int>(i_), with.at}});
    return true;
  }

  long count_columns(size_t i, const std::vector<size_t>& terms) const {
    long count = 0;
    for (size_t term : terms) count += design_.joints[i].terms[term].columns();
    return count;
  }

  // Compares with the terms of the whole robot.
  void compare_whole() {
    for (size_t term = 0; term < design_.whole.size(); ++term) {
      const Term& other = design_.whole[term];
      const std::vector<size_t>& have = model_.whole;
      if (has(have, term) || is_listed(other)) continue;
      if (other.row == g_.term.row && other.place == g_.term.place) continue;  // of another shape
      if (g_.place.joint >= 0 && (!is_beyond(other, static_cast<size_t>(g_.place.joint)) || !may_fill(term))) continue;
      TorqueModel model = rest_;
      model.whole.push_back(term);
      const TorqueFit fit = fit_torque(design_, model);
      const Eigen::VectorXd p = fit.theta.segment(list_slots(design_, model).whole.back(), other.columns());
      if (!fills(other, fit, p) || is_needed_beside(term, fit)) continue;
      if (is_whole_physical(design_, other, p)) add_whole(other, p, model);
    }
  }

  // A term of the whole robot may gain evidence at other joints only. The joint's own term is needed if it still adds
  // evidence beside the other. `without`: fit with the other term alone.
  bool is_needed_beside(size_t whole_term, const TorqueFit& without) const {
    if (g_.place.joint < 0) return false;
    TorqueModel both = model_;
    both.whole.push_back(whole_term);
    return weigh(fit_torque(design_, both)) - weigh(without) > kOdds;
  }

  // Fast filter: true if a term of the whole robot fills most of the gap in the joint's own rows. Most do not.
  bool may_fill(size_t whole_term) const {
    const size_t i = static_cast<size_t>(g_.place.joint);
    const JointDesign& joint = design_.joints[i];
    const std::vector<size_t>& rest = rest_.own[i];
    Columns columns;
    for (size_t term : rest) {
      for (long c : list_columns(joint, term)) columns.push_back(c);
    }
    for (size_t term : model_.whole) {
      for (long c : list_whole_columns(design_, joint, term)) columns.push_back(c);
    }
    for (long c : list_whole_columns(design_, joint, whole_term)) columns.push_back(c);
    const double per_effort = calc_per_effort(joint, rest, solve(joint.total, columns));
    const double cross = cross_validate(joint.train, joint.total, columns) * per_effort;
    return 0.5 * joint.effective * std::log(std::max(1e-300, alone_.cross[i] / std::max(1e-300, cross))) >
           0.5 * (g_.gain - kOdds);
  }

  const TorqueDesign& design_;
  const TorqueModel& model_;
  const TorqueFit& fit_;
  TorqueModel rest_;     // without the term
  double beside_ = 0.0;  // [nats] prior cost of a constant that was added to it
  const TorqueFit& alone_;
  const Slots slots_;  // of model_
  const size_t i_;
  const GradedTerm& g_;
  std::vector<Rival> rivals_;
};

}  // namespace

std::vector<Rival> list_rivals(const TorqueDesign& design, const Gap& gap, size_t judge, const GradedTerm& g) {
  return RivalSearch(design, gap, judge, g).run();
}

double calc_own_inertia(const TreeSpec& tree, int joint) {
  const LinkSpec& own = tree.links[static_cast<size_t>(joint) + 1];
  const Vector3d axis = own.joint.axis_F.normalized();
  return axis.dot(own.inertia.I_LLcm_L * axis);
}

bool is_rotor(const Term& term) { return term.effect().id == EffectId::kRotorInertia; }

bool is_viscous(const Term& term) { return term.effect().id == EffectId::kViscous; }

}  // namespace hrp::diagnosis
