// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque_misleading.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {
namespace {

constexpr int kMostRows = 3;        // most barred rows of a joint

struct Suspect {
  const TermRow* row = nullptr;  // null: no term misleads
  double held = 0.0;             // [(N m)^2] held-out mean square without it
};

// The joint's term whose removal improves the held-out prediction most, with all other terms fitted again.
Suspect find_misleading(const TorqueDesign& design, const Choice& choice, size_t i) {
  Suspect worst{nullptr, (1.0 - kMinor) * choice.fit.held[i]};
  // Smoothing leaves as much even with a perfect model: below it, no term misleads.
  if (worst.held < std::pow(kTrace * design.joints[i].spread, 2)) return worst;
  for (size_t t = 0; t < choice.model.own[i].size(); ++t) {
    TorqueModel rest = choice.model;
    rest.own[i].erase(rest.own[i].begin() + static_cast<long>(t));
    const double held = fit_torque(design, rest).held[i];
    if (held < worst.held) worst = {design.joints[i].terms[choice.model.own[i][t]].row, held};
  }
  return worst;
}

// Bars one more row at each joint with a misleading term. Returns false if there is none.
bool bar_rows(int jobs, const Choice& choice, TorqueDesign* design) {
  std::vector<Suspect> suspects(design->joints.size());
  parallel_for(jobs, static_cast<int>(suspects.size()), [&](int i) {
    suspects[static_cast<size_t>(i)] = find_misleading(*design, choice, static_cast<size_t>(i));
  });
  bool any = false;
  for (size_t i = 0; i < suspects.size(); ++i) {
    if (suspects[i].row) design->joints[i].barred.push_back(suspects[i].row), any = true;
  }
  return any;
}

// Allows the last barred row again at joints where the new choice predicts no better. Returns false if there is none.
bool allow_again(const Choice& before, const Choice& after, const std::vector<size_t>& barred, TorqueDesign* design) {
  bool any = false;
  for (size_t i = 0; i < barred.size(); ++i) {
    std::vector<const TermRow*>& own = design->joints[i].barred;
    if (own.size() == barred[i] || after.fit.held[i] < (1.0 - kMinor) * before.fit.held[i]) continue;
    own.pop_back(), any = true;
  }
  return any;
}

// Score [nats] of a choice: its evidence on the training recordings plus its log-likelihood on the held-out recordings.
// Their independent samples are taken as dense as those of training.
double calc_score(const TorqueDesign& design, const Choice& choice) {
  double score = choice.fit.evidence;
  for (size_t i = 0; i < design.joints.size(); ++i) {
    const JointDesign& joint = design.joints[i];
    double held = 0.0;
    for (const Gram& recording : joint.held) held += recording.n;
    const double independent = joint.effective * held / std::max(1.0, joint.total.n);
    const double floor = kFloor * joint.spread * joint.spread;
    score -= 0.5 * independent * std::log(std::max({choice.fit.held[i], floor, 1e-300}));
  }
  return score;
}

}  // namespace

void drop_misleading_terms(int jobs, Timing timing, TorqueDesign* design, Choice* choice) {
  for (int pass = 0; design->has_held && pass < kMostRows; ++pass) {
    std::vector<size_t> barred;
    for (const JointDesign& joint : design->joints) barred.push_back(joint.barred.size());
    if (!bar_rows(jobs, *choice, design)) return;
    Choice with = choose_torque_model(*design, jobs, timing);
    const bool undone = allow_again(*choice, with, barred, design);
    if (undone) with = choose_torque_model(*design, jobs, timing);
    if (calc_score(*design, with) > calc_score(*design, *choice)) *choice = with;
    else for (size_t i = 0; i < barred.size(); ++i) design->joints[i].barred.resize(barred[i]);
    if (undone) return;
  }
}

}  // namespace hrp::diagnosis
