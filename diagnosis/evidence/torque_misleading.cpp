// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque_misleading.h"

#include <algorithm>

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {
namespace {

constexpr int kMostRows = 3;        // that one joint loses
constexpr double kMisleads = 0.95;  // of a joint's held-out mean square: less is the chance of which motions were held out

struct Suspect {
  const TermRow* row = nullptr;  // null: none
  double held = 0.0;             // without it
};

// The joint's term without which its held-out recordings are predicted best, all others fitted again.
Suspect find_misleading(const TorqueDesign& design, const Choice& choice, size_t i) {
  Suspect worst{nullptr, kMisleads * choice.fit.held[i]};
  for (size_t t = 0; t < choice.model.own[i].size(); ++t) {
    TorqueModel rest = choice.model;
    rest.own[i].erase(rest.own[i].begin() + static_cast<long>(t));
    const double held = fit_torque(design, rest).held[i];
    if (held < worst.held) worst = {design.joints[i].terms[choice.model.own[i][t]].row, held};
  }
  return worst;
}

// Bars one more row at each joint that a term misleads; false: at none.
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

// Where the new choice predicts no better, its last row is allowed again; false: nowhere.
bool allow_again(const Choice& before, const Choice& after, const std::vector<size_t>& barred, TorqueDesign* design) {
  bool any = false;
  for (size_t i = 0; i < barred.size(); ++i) {
    std::vector<const TermRow*>& own = design->joints[i].barred;
    if (own.size() == barred[i] || after.fit.held[i] < kMisleads * before.fit.held[i]) continue;
    own.pop_back(), any = true;
  }
  return any;
}

bool is_better(const TorqueDesign& design, const Choice& after, const Choice& before) {
  double change = 0.0;
  for (size_t i = 0; i < design.joints.size(); ++i)
    change += (after.fit.held[i] - before.fit.held[i]) / std::max(1e-300, design.joints[i].spread * design.joints[i].spread);
  return change < 0.0;
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
    if (is_better(*design, with, *choice)) *choice = with;
    else for (size_t i = 0; i < barred.size(); ++i) design->joints[i].barred.resize(barred[i]);
    if (undone) return;
  }
}

}  // namespace hrp::diagnosis
