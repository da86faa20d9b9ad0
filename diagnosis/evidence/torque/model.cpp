// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/model.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

constexpr double kFactorSpread = 0.15;  // standard deviation of ln(factor) for torque constants and masses

// Factor of the joint's torque constant in the model, from the effort column or from the torque column; 1 without one.
double find_gain(const JointDesign& joint, const std::vector<size_t>& terms, const Eigen::VectorXd& theta) {
  long at = 0;
  for (size_t term : terms) {
    if (joint.terms[term].row->scales_effort) return 1.0 - theta[at];
    if (joint.terms[term].row->scales_model) return 1.0 / std::max(1e-3, 1.0 + theta[at]);
    at += joint.terms[term].columns();
  }
  return 1.0;
}

bool scales_effort(const JointDesign& joint, const std::vector<size_t>& terms) {
  return std::any_of(terms.begin(), terms.end(), [&](size_t t) { return joint.terms[t].row->scales_effort; });
}

Eigen::VectorXd pick_slots(const Eigen::VectorXd& theta, const UsedColumns& use) {
  Eigen::VectorXd own(static_cast<long>(use.slots.size()));
  for (long i = 0; i < own.size(); ++i) own[i] = theta[use.slots[static_cast<size_t>(i)]];
  return own;
}

void add_joined(const Gram& gram, const UsedColumns& use, double weight, Gram* out) {
  for (size_t a = 0; a < use.columns.size(); ++a) {
    out->b[use.slots[a]] += weight * gram.b[use.columns[a]];
    for (size_t b = 0; b < use.columns.size(); ++b) {
      if (use.slots[a] >= use.slots[b])
        out->G(use.slots[a], use.slots[b]) += weight * gram.get(use.columns[a], use.columns[b]);
    }
  }
  out->c += weight * gram.c;
  out->n += gram.n;
}

class Fitter {
 public:
  Fitter(const TorqueDesign& design, const TorqueModel& model)
      : design_(design), model_(model), slots_(list_slots(design, model)) {
    for (size_t i = 0; i < design.joints.size(); ++i) uses_.push_back(list_used_columns(design, model, slots_, i));
    for (long c = 0; c < slots_.size; ++c) all_.push_back(c);
  }

  TorqueFit fit(bool with_covariance) {
    TorqueFit out;
    out.theta = Eigen::VectorXd::Zero(slots_.size);
    out.cross.assign(design_.joints.size(), 0.0);
    if (with_covariance) out.covariance = Eigen::MatrixXd::Zero(slots_.size, slots_.size);
    if (model_.whole.empty())
      fit_apart(&out);
    else
      fit_together(&out);
    judge(&out);
    return out;
  }

 private:
  void fit_apart(TorqueFit* out) const {
    for (size_t i = 0; i < design_.joints.size(); ++i) {
      const JointDesign& joint = design_.joints[i];
      const Eigen::VectorXd theta = solve(joint.total, uses_[i].columns);
      out->cross[i] = cross_validate(joint.train, joint.total, uses_[i].columns);
      for (long a = 0; a < theta.size(); ++a) out->theta[uses_[i].slots[static_cast<size_t>(a)]] = theta[a];
      if (out->covariance.size() == 0) continue;
      const Eigen::MatrixXd P = calc_covariance(joint.train, joint.total, uses_[i].columns, theta);
      for (long a = 0; a < theta.size(); ++a) {
        for (long b = 0; b < theta.size(); ++b)
          out->covariance(uses_[i].slots[static_cast<size_t>(a)], uses_[i].slots[static_cast<size_t>(b)]) = P(a, b);
      }
    }
  }

  // Weights each joint's rows by the inverse of its mean square. This is found with the whole robot's terms fitted to
  // that joint alone.
  void fit_together(TorqueFit* out) const {
    std::vector<double> weights;
    for (size_t i = 0; i < design_.joints.size(); ++i) {
      const JointDesign& joint = design_.joints[i];
      const double cross = cross_validate(joint.train, joint.total, uses_[i].columns);
      weights.push_back(calc_row_weight(joint, cross));
    }
    const size_t count = design_.joints[0].train.size();
    std::vector<Gram> folds(count, Gram(slots_.size));
    for (size_t f = 0; f < count; ++f) {
      for (size_t i = 0; i < design_.joints.size(); ++i)
        add_joined(design_.joints[i].train[f], uses_[i], weights[i], &folds[f]);
    }
    const Gram total = sum(folds, slots_.size);
    out->theta = solve(total, all_);
    if (out->covariance.size() > 0) out->covariance = calc_covariance(folds, total, all_, out->theta);
    std::vector<double> n(design_.joints.size(), 0.0);
    for (size_t f = 0; f < count; ++f) {
      Gram rest = total;
      rest.add(folds[f], -1.0);
      const Eigen::VectorXd theta = solve(rest, all_);
      for (size_t i = 0; i < design_.joints.size(); ++i) {
        const Gram& fold = design_.joints[i].train[f];
        out->cross[i] += calc_rest(fold, uses_[i].columns, pick_slots(theta, uses_[i]));
        n[i] += fold.n;
      }
    }
    for (size_t i = 0; i < n.size(); ++i) out->cross[i] /= std::max(1.0, n[i]);
  }

  void judge(TorqueFit* out) const {
    for (size_t i = 0; i < design_.joints.size(); ++i) {
      const JointDesign& joint = design_.joints[i];
      const Eigen::VectorXd theta = pick_slots(out->theta, uses_[i]);
      const double per_effort = calc_per_effort(joint, model_.own[i], theta);
      out->cross[i] *= per_effort;
      double rest = 0.0, n = 0.0;
      out->each_held.emplace_back();
      for (const Gram& held : joint.held) {
        const double own = per_effort * calc_rest(held, uses_[i].columns, theta);
        out->each_held.back().push_back(own / std::max(1.0, held.n));
        rest += own;
        n += held.n;
      }
      out->held.push_back(rest / std::max(1.0, n));
      out->evidence += calc_evidence(joint, out->cross[i]);
      for (size_t term : model_.own[i]) out->evidence -= joint.terms[term].row->cost;
      out->evidence -= calc_gain_cost(joint, model_.own[i], theta);
    }
    for (size_t t = 0; t < model_.whole.size(); ++t) {
      const Term& term = design_.whole[model_.whole[t]];
      const Eigen::VectorXd p = out->theta.segment(slots_.whole[t], term.columns());
      out->evidence -= calc_term_cost(*term.row, p);
      if (term.row->pulls) out->evidence -= calc_direction_cost(p, design_.data->experiment->scenario.gravity_W);
    }
  }

  const TorqueDesign& design_;
  const TorqueModel& model_;
  const Slots slots_;
  std::vector<UsedColumns> uses_;
  Columns all_;
};

}  // namespace

size_t add_own_term(size_t joint, size_t term, TorqueModel* model) {
  std::vector<size_t>& own = model->own[joint];
  const auto at = own.insert(std::upper_bound(own.begin(), own.end(), term), term);  // begin() moves with it
  return static_cast<size_t>(at - own.begin());
}

double calc_evidence(const JointDesign& joint, double cross) {
  const double floor = kFloor * joint.spread * joint.spread;
  return -0.5 * joint.effective * std::log(std::max({cross, floor, 1e-300}));
}

double calc_blurred_evidence(const JointDesign& joint, double cross) {
  return calc_evidence(joint, cross + std::pow(kKnown * joint.spread, 2));
}

double calc_blurred_evidence(const TorqueDesign& design, const TorqueFit& fit) {
  double evidence = fit.evidence;
  for (size_t i = 0; i < design.joints.size(); ++i)
    evidence += calc_blurred_evidence(design.joints[i], fit.cross[i]) - calc_evidence(design.joints[i], fit.cross[i]);
  return evidence;
}

double calc_factor_cost(double factor) { return 0.5 * std::pow(std::log(std::max(1e-3, factor)) / kFactorSpread, 2); }

double calc_mass_cost(double factor) {
  constexpr double kFreedom = 10.0;  // degrees of freedom of Student's t: a mass may be far off for a reason
  const double x = std::log(std::max(1e-3, factor)) / kFactorSpread;
  return 0.5 * (kFreedom + 1.0) * std::log1p(x * x / kFreedom);
}

double calc_term_cost(const TermRow& row, const Eigen::VectorXd& p) {
  if (row.factor) return row.cost + calc_mass_cost(1.0 + p[0]);
  return row.cost + (row.scales_effort ? calc_factor_cost(1.0 - p[0]) : 0.0);
}

double calc_direction_cost(const Vector3d& force_W, const Vector3d& gravity_W) {
  const double size = force_W.norm() * gravity_W.norm();
  if (!(size > 0.0)) return 0.0;
  const double narrowest = 1.0 - std::cos(kKnown);
  return std::log(2.0 / std::max(narrowest, 1.0 - force_W.dot(gravity_W) / size));
}

double calc_held_left(const TorqueDesign& design, const TorqueFit& fit) {
  double left = 0.0;
  for (size_t i = 0; i < design.joints.size(); ++i) left += fit.held[i] * design.joints[i].weigh_squares();
  return left;
}

double calc_per_effort(const JointDesign& joint, const std::vector<size_t>& terms, const Eigen::VectorXd& theta) {
  if (!scales_effort(joint, terms)) return 1.0;
  const double k = std::clamp(find_gain(joint, terms, theta), 1e-3, 1.0);
  return 1.0 / (k * k);
}

double calc_gain_cost(const JointDesign& joint, const std::vector<size_t>& terms, const Eigen::VectorXd& theta) {
  return calc_factor_cost(find_gain(joint, terms, theta));
}

Slots list_slots(const TorqueDesign& design, const TorqueModel& model) {
  Slots slots;
  for (size_t i = 0; i < design.joints.size(); ++i) {
    slots.own.emplace_back();
    for (size_t term : model.own[i]) {
      slots.own.back().push_back(slots.size);
      slots.size += design.joints[i].terms[term].columns();
    }
  }
  for (size_t term : model.whole) {
    slots.whole.push_back(slots.size);
    slots.size += design.whole[term].columns();
  }
  return slots;
}

UsedColumns list_used_columns(const TorqueDesign& design, const TorqueModel& model, const Slots& slots, size_t i) {
  const JointDesign& joint = design.joints[i];
  UsedColumns use;
  for (size_t t = 0; t < model.own[i].size(); ++t) {
    long slot = slots.own[i][t];
    for (long c : list_columns(joint, model.own[i][t])) {
      use.columns.push_back(c);
      use.slots.push_back(slot++);
    }
  }
  for (size_t t = 0; t < model.whole.size(); ++t) {
    long slot = slots.whole[t];
    for (long c : list_whole_columns(design, joint, model.whole[t])) {
      use.columns.push_back(c);
      use.slots.push_back(slot++);
    }
  }
  return use;
}

double calc_row_weight(const JointDesign& joint, double left) {
  return 1.0 / std::max({left, kFloor * joint.spread * joint.spread, 1e-300});
}

TorqueFit fit_torque(const TorqueDesign& design, const TorqueModel& model, bool with_covariance) {
  return Fitter(design, model).fit(with_covariance);
}

}  // namespace hrp::diagnosis
