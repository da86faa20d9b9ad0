// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/intervals.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/samples.h"

namespace hrp::diagnosis {
namespace {

// Dry friction of two real drives that swing through half a turn, the hip of an exoskeleton and the second joint of a
// double pendulum: it differs between windows of 30 degrees by 0.18 and 0.23 of its mean (standard deviation, without
// the noise).
constexpr double kTexture = 0.2;
constexpr double kTextureWindow = M_PI / 6.0;  // [rad]

using Rows = std::vector<long>;

// Divides the samples by recording (`by` = 0), or by quartiles of another quantity.
std::vector<Rows> divide(const TorqueSamples& all, long by) {
  std::vector<double> values(all.of.col(by).data(), all.of.col(by).data() + all.of.rows());
  std::sort(values.begin(), values.end());
  std::vector<double> limits;                              // a part ends where the quantity exceeds it
  constexpr auto count = static_cast<size_t>(kStretches);  // of parts by each quantity except recordings
  for (size_t part = 1; part < count && by > 0; ++part) limits.push_back(values[part * values.size() / count]);
  if (by == 0) {
    values.erase(std::unique(values.begin(), values.end()), values.end());
    limits = values;
    limits.pop_back();
  }
  std::vector<Rows> parts(limits.size() + 1);
  for (long k = 0; k < all.of.rows(); ++k) {
    size_t part = 0;
    while (part < limits.size() && all.of(k, by) > limits[part]) ++part;
    parts[part].push_back(k);
  }
  return parts;
}

// Fits each parameter alone to each part, with the others fixed, because a part of the speeds or positions hardly
// determines several at once. `left`: residual of the model. `most`: largest variance so far, by column.
void add_between(const TorqueSamples& all, const Eigen::VectorXd& left, const std::vector<Rows>& parts,
                 double correlated, Eigen::VectorXd* most) {
  for (long c = 0; c < most->size(); ++c) {
    std::vector<double> values, variances;
    for (const Rows& part : parts) {
      double xx = 0.0, xy = 0.0, yy = 0.0;
      for (long k : part) {
        xx += all.x(k, c) * all.x(k, c);
        xy += all.x(k, c) * left[k];
        yy += left[k] * left[k];
      }
      if (!(xx > 0.0) || static_cast<double>(part.size()) < static_cast<double>(kFewestToAgree) * correlated) continue;
      values.push_back(xy / xx);
      variances.push_back(correlated * yy / static_cast<double>(part.size()) / xx);
    }
    if (values.size() < kFewestToAgree) continue;
    const double another = 1.0 + 1.0 / static_cast<double>(values.size());
    (*most)[c] = std::max((*most)[c], another * calc_variance_between(values, variances));
  }
}

// Change of the parameters with time, where it is significant: drives warm up.
struct Drift {
  Eigen::VectorXd size;  // by column, from the middle of a recording to its ends
  Eigen::VectorXd left;  // residual of the model with this change
};

Drift find_drift(const TorqueSamples& all, const Eigen::VectorXd& theta, const Eigen::VectorXd& left,
                 double correlated) {
  const long width = all.x.cols(), n = all.x.rows();
  Eigen::MatrixXd x(n, 2 * width);
  x << all.x, (all.of.col(1).array() - 0.5).matrix().asDiagonal() * all.x;
  const Eigen::MatrixXd inverse = invert_gram(x);
  const Eigen::VectorXd with = inverse * (x.transpose() * all.y);
  const double square = (all.y - x * with).squaredNorm() / std::max(1.0, static_cast<double>(n - 2 * width));
  Drift drift{Eigen::VectorXd::Zero(width), left};
  for (long c = 0; c < width; ++c) {
    const double slope = with[width + c], std = std::sqrt(square * correlated * inverse(width + c, width + c));
    if (!(std::abs(slope) > kNinetyFive * std)) continue;
    drift.size[c] = 0.5 * std::abs(slope);
    drift.left -= slope * x.col(width + c) + (with[c] - theta[c]) * x.col(c);
  }
  return drift;
}

// Variance by column from the unseen part of a turn. Gears, seals and brushes have uneven friction over a turn. Zero if
// the joint made a whole turn or is prismatic.
Eigen::VectorXd calc_unseen(const TorqueDesign& design, const std::vector<size_t>& own, size_t i,
                            const TorqueSamples& all, const Eigen::VectorXd& theta) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(theta.size());
  const JointDesign& joint = design.joints[i];
  if (design.data->experiment->robot.tree.joint(joint.joint).kind != JointKind::kRevolute) return out;
  const double travel = all.of.col(3).maxCoeff() - all.of.col(3).minCoeff();
  long at = 0;
  for (size_t term : own) {
    if (joint.terms[term].row->is_dry()) out[at] = std::pow(calc_unseen_std(theta[at], travel), 2);
    at += joint.terms[term].columns();
  }
  return out;
}

bool is_fitted(const TorqueDesign& design, const TorqueModel& model, size_t term) {
  return std::any_of(model.whole.begin(), model.whole.end(), [&](size_t t) {
    return design.whole[t].row == design.whole[term].row && design.whole[t].place == design.whole[term].place;
  });
}

// True if the term is a link's mass that the model takes as known.
bool is_known_mass(const TorqueDesign& design, const TorqueModel& model, size_t term) {
  return design.whole[term].row->factor && !is_fitted(design, model, term);
}

// Standard deviation [1, m] to which the model knows the mass of a link, or its centre of mass in each direction, if it
// does not fit them; 0: the term is neither.
double get_known_to(const TorqueDesign& design, const TorqueModel& model, size_t term) {
  if (is_known_mass(design, model, term)) return kKnown;
  const Term& centre = design.whole[term];
  if (centre.row->effect->id != EffectId::kComError || is_fitted(design, model, term)) return 0.0;
  return kKnown * design.data->experiment->robot.tree.links[static_cast<size_t>(centre.place)].inertia.p_LLcm_L.norm();
}

// Of all columns in `all`, fitted to these rows alone.
Eigen::VectorXd calc_spread(const TorqueDesign& design, const std::vector<size_t>& own, size_t joint,
                            const TorqueSamples& all, double gain_std) {
  Eigen::VectorXd between = Eigen::VectorXd::Zero(all.x.cols());
  const Eigen::VectorXd theta = invert_gram(all.x) * (all.x.transpose() * all.y), left = all.y - all.x * theta;
  const double correlated = calc_correlation_time(left);
  // The drift is a bound, not a random error: a stated value may be that of a cold drive. It is added below, so the
  // differences between parts must not contain it as well.
  const Drift drift = find_drift(all, theta, left, correlated);
  for (long by = 0; by < kQuantitiesOfParts; ++by) add_between(all, drift.left, divide(all, by), correlated, &between);
  between += calc_considered_variance(sum_considered(all.x, all.effort, all.effort_rate),
                                      design.data->experiment->sample_time, gain_std);
  between += calc_unseen(design, own, joint, all, theta);
  return between.cwiseSqrt() + drift.size / kNinetyFive;
}

}  // namespace

ConsideredSums sum_considered(const Eigen::MatrixXd& x, const Eigen::VectorXd& effort,
                              const Eigen::VectorXd& effort_rate) {
  Eigen::MatrixXd moved(x.rows(), 2);
  moved << effort, effort_rate;
  return {x.transpose() * x, x.transpose() * moved};
}

Eigen::VectorXd calc_considered_variance(const ConsideredSums& sums, double sample_time, double gain_std) {
  Eigen::MatrixXd moved = sums.moved;
  // Where in a sampling step an effort and a position were read, a log does not say.
  moved.col(0) *= gain_std;
  moved.col(1) *= kHalf * sample_time;
  return (invert_sums(sums.xx) * moved).rowwise().squaredNorm();
}

Eigen::VectorXd calc_considered_std(const TorqueDesign& design, const TorqueModel& model, const TorqueFit& fit) {
  const Slots slots = list_slots(design, model);
  const size_t joints = design.joints.size();
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(slots.size, slots.size);
  // By slot: each joint's rows times its effort; then all rows times the columns of each link's mass.
  Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(slots.size, static_cast<long>(joints + design.whole.size()));
  for (size_t i = 0; i < joints; ++i) {
    const JointDesign& joint = design.joints[i];
    const UsedColumns use = list_used_columns(design, model, slots, i);
    const double weight = calc_row_weight(joint, fit.cross[i]);
    for (size_t a = 0; a < use.columns.size(); ++a) {
      for (size_t b = 0; b < use.columns.size(); ++b)
        sums(use.slots[a], use.slots[b]) += weight * joint.total.get(use.columns[a], use.columns[b]);
      for (size_t t = 0; t < joint.terms.size(); ++t) {
        if (joint.terms[t].row->scales_effort)
          moved(use.slots[a], static_cast<long>(i)) += weight * joint.total.get(use.columns[a], joint.first[t]);
      }
      for (size_t t = 0; t < design.whole.size(); ++t) {
        if (is_known_mass(design, model, t))
          moved(use.slots[a], static_cast<long>(joints + t)) +=
              weight * joint.total.get(use.columns[a], list_whole_columns(design, joint, t)[0]);
      }
    }
  }
  return kKnown * (invert_sums(sums) * moved).rowwise().norm();
}

Eigen::VectorXd calc_unsure_mass_std(const TorqueDesign& design, const TorqueModel& model, const TorqueFit& fit) {
  const Slots slots = list_slots(design, model);
  if (slots.size == 0) return {};
  std::vector<std::pair<size_t, double>> known;  // terms of the whole robot, and to what they are known
  long size = slots.size;
  for (size_t t = 0; t < design.whole.size(); ++t) {
    const double to = get_known_to(design, model, t);
    if (to > 0.0) {
      known.emplace_back(t, to);
      size += design.whole[t].columns();
    }
  }
  Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(size, size);
  for (size_t i = 0; i < design.joints.size(); ++i) {
    const JointDesign& joint = design.joints[i];
    UsedColumns use = list_used_columns(design, model, slots, i);
    long at = slots.size;
    for (const auto& [term, to] : known) {
      for (long c : list_whole_columns(design, joint, term)) {
        use.columns.push_back(c);
        use.slots.push_back(at++);
      }
    }
    const double weight = calc_row_weight(joint, fit.cross[i]) * joint.effective / std::max(1.0, joint.total.n);
    for (size_t a = 0; a < use.columns.size(); ++a) {
      for (size_t b = 0; b < use.columns.size(); ++b)
        precision(use.slots[a], use.slots[b]) += weight * joint.total.get(use.columns[a], use.columns[b]);
    }
  }
  const Eigen::VectorXd exact = invert_sums(precision.topLeftCorner(slots.size, slots.size)).diagonal();
  long at = slots.size;
  for (const auto& [term, to] : known) {
    for (int c = 0; c < design.whole[term].columns(); ++c, ++at) precision(at, at) += 1.0 / (to * to);
  }
  return (invert_sums(precision).diagonal().head(slots.size) - exact).cwiseMax(0.0).cwiseSqrt();
}

bool is_loss(const EffectInfo& effect) {
  return effect.family == EffectFamily::kDryFriction || effect.family == EffectFamily::kSpeedLoss;
}

Eigen::Vector4d take_place_widths(const Eigen::Vector4d& x, const Eigen::Matrix4d& covariance,
                                  const Eigen::Vector4d& width) {
  Eigen::Vector4d out = width;
  for (long k = 1; k < 4 && x[0] != 0.0; ++k) {
    const double place = x[k] / x[0], both = std::sqrt(covariance(0, 0) * covariance(k, k));
    const double together = both > 0.0 ? std::clamp(covariance(0, k) / both, -1.0, 1.0) * width[0] * width[k] : 0.0;
    if (width[k] > 0.0)
      out[k] =
          std::sqrt(std::max(0.0, width[k] * width[k] + place * place * width[0] * width[0] - 2.0 * place * together));
  }
  return out;
}

double calc_unseen_std(double level, double travel) {
  const double turn = 2.0 * M_PI, seen = std::clamp(travel, kTextureWindow, turn);
  return std::sqrt(kTextureWindow / seen * (1.0 - std::min(travel / turn, 1.0))) * kTexture * std::abs(level);
}

Eigen::VectorXd calc_spread_between(const TorqueDesign& design, const TorqueModel& model, const TorqueFit& fit,
                                    size_t joint, double gain_std) {
  TorqueSamples all = list_torque_samples(design, model, joint);
  if (all.x.rows() == 0 || all.x.cols() == 0) return Eigen::VectorXd::Zero(all.x.cols());
  Eigen::VectorXd spread = calc_spread(design, model.own[joint], joint, all, gain_std);
  const Slots slots = list_slots(design, model);
  long own = all.x.cols();
  for (size_t term : model.whole) own -= design.whole[term].columns();
  long at = own, kept = own;  // columns of masses go, the others close up
  for (size_t t = 0; t < model.whole.size(); ++t) {
    const long count = design.whole[model.whole[t]].columns();
    if (design.whole[model.whole[t]].row->is_of_mass()) {
      all.y -= all.x.middleCols(at, count) * fit.theta.segment(slots.whole[t], count);
    } else {
      all.x.middleCols(kept, count) = all.x.middleCols(at, count).eval();
      kept += count;
    }
    at += count;
  }
  if (kept == at || own == 0) return spread;
  all.x.conservativeResize(Eigen::NoChange, kept);
  spread.head(own) = spread.head(own).cwiseMin(calc_spread(design, model.own[joint], joint, all, gain_std).head(own));
  return spread;
}

}  // namespace hrp::diagnosis
