// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/drive_model.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/search/significance.h"
#include "diagnosis/search/nearby.h"

namespace hrp::diagnosis {
namespace {

constexpr double kStill = 0.02;  // [rad/s] slower samples have no clear direction of friction
constexpr double kEarns = 0.97;  // of the error that an effect must leave at most to be taken in
constexpr double kWound = 0.01;  // [rad] displacement before slipping that is tried first: gears with play and rubber
constexpr double kExcess = 0.05;  // share that breaking away must take more than sliding to be a law of its own
constexpr size_t kRounds = 5, kTried = 3;

size_t find(const Hypothesis& effects, EffectId id, const Place& place) {
  size_t i = 0;
  while (i < effects.size() && (effects[i].id != id || effects[i].place != place)) ++i;
  return i;
}

bool has(const Hypothesis& effects, EffectId id, const Place& place) { return find(effects, id, place) < effects.size(); }

// Least squares with no negative coefficient: the most negative one is dropped until none is left.
Eigen::Vector3d solve_positive(const Eigen::Matrix3d& gram, const Eigen::Vector3d& projection) {
  bool use[3] = {true, true, true};
  for (int round = 0; round < 3; ++round) {
    Eigen::Matrix3d G = gram;
    Eigen::Vector3d b = projection;
    for (int i = 0; i < 3; ++i) {
      if (use[i]) continue;
      G.row(i).setZero(), G.col(i).setZero();
      G(i, i) = 1.0, b(i) = 0.0;
    }
    G.diagonal().array() *= 1.0 + 1e-9;
    const Eigen::Vector3d x = G.ldlt().solve(b);
    Eigen::Index worst = 0;
    if (x.minCoeff(&worst) >= 0.0) return x;
    use[worst] = false;
  }
  return Eigen::Vector3d::Zero();
}

}  // namespace

DriveSelector::DriveSelector(const Problem& problem, int joint, const std::vector<int>& held)
    : problem_(problem), joint_(joint), held_(held) {
  problem_.jobs = 1;
  problem_.options.max_step = 2.0 * problem.options.max_step;
  // One joint alone is simulated as it is, and then effects of its link can be told as well.
  if (problem_.experiment->num_joints() == 1)
    problem_.view = {};
  else
    problem_.view = {true, &problem_.nominal_paths, joint_};
  double sum = 0.0, count = 0.0;
  for (int r : problem_.train) {
    const JointPath& path = problem_.nominal_paths[static_cast<size_t>(r)][static_cast<size_t>(joint_)];
    for (size_t k = 0; k < path.q.size(); ++k) {
      sum += path.q[k], count += 1.0;
    }
  }
  middle_ = sum / std::max(1.0, count);
  for (int r : problem_.train) {
    for (double q : problem_.nominal_paths[static_cast<size_t>(r)][static_cast<size_t>(joint_)].q)
      swing_ = std::max(swing_, std::abs(q - middle_));
  }
}

double DriveSelector::calc_nominal_rms() const {
  double least = 1e300;
  for (size_t r = 0; r < problem_.smooth.size(); ++r) {
    least = std::min(least, calc_score(problem_, {}, {static_cast<int>(r)}).rms());
  }
  return least;
}

// Effort that drove the joint: recorded, else what the servo law says; 0 where nothing drives it.
double DriveSelector::find_effort(int recording, size_t k) const {
  const Experiment& e = *problem_.experiment;
  const SmoothRecording& smooth = problem_.smooth[static_cast<size_t>(recording)];
  const auto j = static_cast<size_t>(joint_);
  if (!e.robot.tree.joint(joint_).actuated) return 0.0;
  if (!smooth.effort[j].empty()) return smooth.effort[j][k];
  const JointColumns& columns = e.recordings[static_cast<size_t>(recording)].joints[j];
  if (columns.command.empty()) return 0.0;
  const auto it = e.scenario.servo_joints.find(e.robot.tree.joint(joint_).name);
  const ServoGains& gains = it == e.scenario.servo_joints.end() ? e.scenario.servo_default : it->second;
  const double rate = columns.command_rate.empty() ? 0.0 : columns.command_rate[k];
  const double u = gains.kp * (columns.command[k] - smooth.joints[j].q[k]) + gains.kd * (rate - smooth.joints[j].qd[k]);
  return std::max(-gains.effort_limit, std::min(gains.effort_limit, u));
}

// Viscous and dry friction and rotor inertia from the efforts that the recorded motion takes (Gautier and Khalil's
// inverse dynamic identification in its simplest form): what the simulation starts from.
Hypothesis DriveSelector::make_start() const {
  Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
  Eigen::Vector3d projection = Eigen::Vector3d::Zero();
  for (int r : problem_.train) {
    const JointPath& path = problem_.nominal_paths[static_cast<size_t>(r)][static_cast<size_t>(joint_)];
    for (size_t k = problem_.smooth[static_cast<size_t>(r)].start; k < path.q.size(); ++k) {
      if (std::abs(path.qd[k]) < kStill) continue;
      const Eigen::Vector3d row(path.qd[k], path.qd[k] > 0.0 ? 1.0 : -1.0, path.qdd[k]);
      const double missing = find_effort(r, k) - path.load[k] - path.inertia[k] * path.qdd[k];
      gram += row * row.transpose(), projection += row * missing;
    }
  }
  const Eigen::Vector3d x = solve_positive(gram, projection);
  return {{EffectId::kViscous, joint_, {x[0]}},
          {EffectId::kCoulomb, joint_, {x[1], 0.0, kWound}},
          {EffectId::kRotorInertia, joint_, {x[2]}}};
}

DriveSelector::Fit DriveSelector::try_fit(const Hypothesis& start, int iterations) const {
  Fit out;
  out.effects = start;
  FitOptions options;
  options.max_iterations = iterations;
  options.tolerance = 1e-3;
  const FitResult result = fit(problem_, start, problem_.train, options);
  if (!result.ok) return out;
  out.effects = result.hypothesis;
  out.train = result.train.chi2;
  const Linear linear = linearise(problem_, out.effects, list_slots(out.effects), problem_.train);
  const Score held = calc_score(problem_, out.effects, held_);
  if (!linear.ok || !held.ok) return out;
  std::vector<long> columns;
  for (long i = 0; i < linear.width.size(); ++i) columns.push_back(i);
  out.cross = cross_validate(sum_folds(linear), columns, linear.width);
  out.held = held.chi2;
  out.ok = true;
  return out;
}

// Effects that may be added, at values where they do nothing.
std::vector<Effect> DriveSelector::list_candidates(const Hypothesis& model) const {
  using E = EffectId;
  const Experiment& e = *problem_.experiment;
  const bool driven = e.robot.tree.joint(joint_).actuated, commanded = driven && e.scenario.drive != "effort";
  const auto dry = std::find_if(model.begin(), model.end(), [](const Effect& effect) { return is_dry(effect.id); });
  const double stick = dry == model.end() ? kWound : dry->p.back();
  std::vector<Effect> list{{E::kRotorInertia, joint_, {0.0}},
                           {E::kSpring, joint_, {0.0, middle_}},
                           {E::kSpring, joint_, {0.0, middle_ + 3.0}},
                           {E::kSpring, joint_, {0.0, middle_ - 3.0}}};
  if (dry == model.end()) list.push_back({E::kCoulomb, joint_, {0.0, 0.0, stick}});
  if (!has(model, E::kStribeck, at_joint(joint_))) list.push_back({E::kViscous, joint_, {0.0}});
  if (driven) {
    list.push_back({E::kLoadFriction, joint_, {0.0, stick}});
    list.push_back({E::kTorqueConstant, joint_, {1.0}});
    list.push_back({E::kLag, joint_, {0.0}});
  }
  if (commanded) list.push_back({E::kDelay, joint_, {0.0}});
  const JointColumns& columns =
      e.recordings[static_cast<size_t>(problem_.train[0])].joints[static_cast<size_t>(joint_)];
  for (Quantity q : {Quantity::kPosition, Quantity::kVelocity}) {
    const Place place = at_signal(joint_ * kQuantities + static_cast<int>(q));
    if (!columns.has(q)) continue;
    list.push_back({E::kSensorDelay, place, {0.0}});
    list.push_back({E::kSensorScale, place, {1.0}});
    list.push_back({E::kSensorBias, place, {0.0}});
  }
  if (e.num_joints() == 1) {
    list.push_back({E::kMassError, 1, {1.0}});
    list.push_back({E::kComError, 1, {0.0, 0.0, 0.0}});
    list.push_back({E::kJointOffset, joint_, {0.0}});
  }
  list.erase(std::remove_if(list.begin(), list.end(), [&](const Effect& c) { return has(model, c.id, c.place); }),
             list.end());
  return list;
}

// Models whose readings are no smooth function of what they add. Saturation is not among them: at its limit a simulated
// joint is drawn to the recorded one, so that any low limit would seem to predict well.
std::vector<Hypothesis> DriveSelector::list_variants(const Hypothesis& model) const {
  std::vector<Hypothesis> variants;
  const size_t dry = find(model, EffectId::kCoulomb, at_joint(joint_)), viscous = find(model, EffectId::kViscous, at_joint(joint_));
  if (dry < model.size() && model[dry].p[0] > 0.0) {
    for (double speed : {0.03, 0.15, 0.6}) {
      Hypothesis variant = model;
      const double v = viscous < model.size() ? model[viscous].p[0] : 0.0;
      variant[dry] = {
          EffectId::kStribeck, joint_, {0.9 * model[dry].p[0], 1.3 * model[dry].p[0], speed, v, model[dry].p[2]}};
      if (viscous < model.size()) variant.erase(variant.begin() + static_cast<long>(viscous));
      variants.push_back(variant);
    }
  }
  return variants;
}

// Candidates by the error that they should leave in stretches they were not fitted to, best first.
std::vector<std::pair<double, Effect>> DriveSelector::probe(const Hypothesis& model) const {
  const std::vector<Effect> candidates = list_candidates(model);
  std::vector<std::pair<double, Effect>> list;
  // Each at a time beside the model: some would not get along with each other.
  const Linear linear = linearise(problem_, model, list_slots(model), problem_.train);
  if (!linear.ok) return list;
  for (const Effect& candidate : candidates) {
    const Linear both = extend(problem_, linear, model, candidate);
    if (!both.ok) continue;
    std::vector<long> columns;
    for (long i = 0; i < both.width.size(); ++i) columns.push_back(i);
    list.push_back({cross_validate(sum_folds(both), columns, both.width), candidate});
  }
  std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return list;
}

// What no drive can have is not taken in, however well it predicts.
bool DriveSelector::is_nonsense(const Hypothesis& effects) const {
  return std::any_of(effects.begin(), effects.end(),
                     [this](const Effect& effect) { return !find_nonsense(effect).empty(); });
}

double DriveSelector::Fit::merit() const { return ok ? std::sqrt(cross) * std::sqrt(held) : 1e300; }

void DriveSelector::grow(Fit* model) const {
  for (size_t round = 0; round < kRounds; ++round) {
    std::vector<Hypothesis> starts;
    for (const auto& candidate : probe(model->effects)) {
      if (starts.size() >= kTried || candidate.first > 0.995 * model->cross) break;
      starts.push_back(model->effects);
      starts.back().push_back(candidate.second);
    }
    if (round == 0) {
      for (const Hypothesis& variant : list_variants(model->effects)) starts.push_back(variant);
    }
    Fit best = *model;
    for (const Hypothesis& start : starts) {
      const Fit trial = try_fit(start, 6);
      if (trial.ok && trial.merit() < best.merit() && !is_nonsense(trial.effects)) best = trial;
    }
    if (!(best.merit() < kEarns * model->merit())) break;
    best.effects = try_nearby(problem_, best.effects);
    const Fit again = try_fit(best.effects, 6);
    *model = again.ok && again.merit() < best.merit() ? again : best;
  }
}

// Models with one effect less; and with friction that does not fall with speed where it does.
std::vector<Hypothesis> DriveSelector::list_simpler(const Hypothesis& model) const {
  std::vector<Hypothesis> list;
  for (size_t i = 0; i < model.size(); ++i) {
    list.push_back(model);
    list.back().erase(list.back().begin() + static_cast<long>(i));
    if (model[i].id == EffectId::kStribeck) list.push_back(leave_out(model, i));
  }
  return list;
}

// The model without an effect; without friction that falls with speed there is still dry and viscous friction.
Hypothesis DriveSelector::leave_out(const Hypothesis& model, size_t effect) const {
  Hypothesis rest = model;
  rest.erase(rest.begin() + static_cast<long>(effect));
  if (model[effect].id != EffectId::kStribeck) return rest;
  const std::vector<double>& p = model[effect].p;
  rest.push_back({EffectId::kCoulomb, joint_, {p[0], 0.0, p[4]}});
  rest.push_back({EffectId::kViscous, joint_, {p[3]}});
  return rest;
}

// Takes out what the recordings that nothing was fitted to do not ask for.
void DriveSelector::prune(Fit* model) const {
  Hypothesis* effects = &model->effects;
  const auto is_absent = [](const Effect& e) {
    return e.id != EffectId::kStribeck && e.id != EffectId::kComError && e.p[0] == 0.0;
  };
  effects->erase(std::remove_if(effects->begin(), effects->end(), is_absent), effects->end());
  for (bool changed = true; changed && !model->effects.empty();) {
    changed = false;
    Fit best;
    for (const Hypothesis& simpler : list_simpler(model->effects)) {
      const Fit trial = try_fit(simpler, 5);
      if (!trial.ok || trial.held > 1.003 * model->held || trial.cross > 1.02 * model->cross) continue;
      if (!best.ok || trial.held < best.held) best = trial;
    }
    if (best.ok) *model = best, changed = true;
  }
  for (size_t i = 0; i < model->effects.size(); ++i) {
    const std::vector<double>& p = model->effects[i].p;
    if (model->effects[i].id != EffectId::kStribeck || p[1] > (1.0 + kExcess) * p[0]) continue;
    const Fit trial = try_fit(leave_out(model->effects, i), 8);
    if (trial.ok) *model = trial;
  }
  // Once more with the other parameters where they belong.
  const Fit again = try_fit(try_nearby(problem_, model->effects), 6);
  if (again.ok && again.merit() < model->merit()) *model = again;
}

DriveModel DriveSelector::select() {
  Hypothesis start = make_start();
  start = try_nearby(problem_, start);
  const Fit plain = try_fit(start, 0);
  Fit model = try_fit(start, 10);
  if (!model.ok) model = try_fit({{EffectId::kViscous, joint_, {0.1 * start[0].p[0] + 1e-3}}}, 10);
  const Fit empty = try_fit({}, 1);
  if (!model.ok) model = empty;
  if (model.ok) {
    grow(&model);
    prune(&model);
  }
  // Least squares of efforts, where following the readings more closely predicts the held-out ones less well.
  if (plain.ok && plain.held < model.held) model = plain;
  DriveModel out;
  out.effects = model.effects;
  return out;
}

}  // namespace hrp::diagnosis
