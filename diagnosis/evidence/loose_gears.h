// SPDX-License-Identifier: BSD-3-Clause
// Finds gears with elasticity or free play by simulation of one joint alone.
//
// The missing torque hardly shows such gears unless they are soft (soft_joints.h). The link differs from its encoder by
// a few mrad only, and the torque depends on the second derivative of this difference. The servo simulation shows them:
// the rotor moves freely in the gap and oscillates against the link.
#pragma once

#include <optional>

#include "diagnosis/evidence/joint_alone.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/search/trial.h"

namespace hrp::diagnosis {

// Motion that tells an elastic gear from one with play.
constexpr const char* kHeldLink = "slow reversals against a held link, with a second encoder at the link";

// A joint whose simulation fits better with an elastic or loose transmission.
struct LooseGear {
  Hypothesis joint;             // the joint's effects with the transmission in place of the rigid rotor
  size_t at = 0;                // index of the transmission in `joint`
  std::vector<double> std;      // of its parameters, from the spread between recordings
  double left = 1.0;            // held-out squared residual relative to the rigid gear
  double share = 0.0;           // share of the joint's held-out squared residual that the gear removes
  bool named = false;           // if false, it only improves the prediction
  bool drops_carried = false;   // it fits without the model's effects at the links that the joint carries
  std::optional<Effect> rival;  // another transmission with nearly the same fit
  const Effect& law() const { return joint[at]; }
};

// Whether a transmission can be what it says. An elastic gear swings: its damping is below the critical one of the
// rotor on its spring, 2 sqrt(k J). A spring beside a larger damper only creeps under its load. So does what an error
// of a neighbour leaves, and it improves the prediction, but no gear is named by it.
bool is_gear(const Effect& law);

// Judges the joints in `joints` whose rigid rotor leaves more than twice the noise, and more of the motion than two
// integrators differ by. A gear is loose if it removes enough of the squared residual in training and in held-out
// recordings, and some of it in every recording. Sorted by `left`. Judge the later ones again beside the first: its
// link is not where its encoder says, which affects neighbours.
std::vector<LooseGear> find_loose_gears(const Problem& problem, const Hypothesis& model,
                                        const std::vector<int>& joints);

// Accepts the best gear, judges the other joints again beside it, and repeats. Replaces the effects of these joints in
// `model`.
std::vector<LooseGear> find_all_loose_gears(const Problem& problem, Hypothesis* model);

// Puts the loose gears into the model if they improve the held-out prediction of the whole robot. Returns findings for
// the gears that are `named`.
std::vector<Finding> loosen_gears(const Problem& problem, const Problem& whole, Trial* model,
                                  const std::function<void(const std::string&)>& progress);

}  // namespace hrp::diagnosis
