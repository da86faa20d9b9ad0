// SPDX-License-Identifier: BSD-3-Clause
// Gears that give or have play, told by the simulation of their joint alone.
//
// The missing torque along the recorded motion hardly shows them: a link behind its gear moves by a few mrad otherwise
// than its encoder, and the torque follows from the second derivative of that. A servo's simulation does: the rotor runs
// free within the gap, and swings against the link.
#pragma once

#include <optional>

#include "diagnosis/evidence/joint_alone.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/search/trial.h"

namespace hrp::diagnosis {

struct LooseGear {
  Hypothesis joint;         // the joint's effects, the transmission in the place of its rigid rotor
  size_t at = 0;            // of the transmission among them
  std::vector<double> std;  // of its parameters, from recording to recording
  double left = 1.0;        // of the squares that the rigid gear leaves on recordings it was not fitted to
  double share = 0.0;       // of what nothing at this joint leaves there
  bool named = false;       // else it only helps to predict
  std::optional<Effect> rival;  // another transmission that does nearly as well
  const Effect& law() const { return joint[at]; }
};

// Of `joints` with a rigid rotor in `model` that their servo's simulation predicts badly. A gear is loose where that takes
// away a good part of what the joint leaves in training and in held-out recordings, and something in every one of them.
// Best first: the next ones may be seen only because the first one's link is not where its encoder says.
std::vector<LooseGear> find_loose_gears(const Problem& problem, const Hypothesis& model, const std::vector<int>& joints);

// One after the other, each beside those before. Their joints' effects take the place of the model's.
std::vector<LooseGear> find_all_loose_gears(const Problem& problem, Hypothesis* model);

// Puts them into a model where held-out recordings of the whole robot are predicted better with them, and tells of those
// that are named.
std::vector<Finding> loosen_gears(const Problem& problem, const Problem& whole, Trial* model,
                                  const std::function<void(const std::string&)>& progress);

}  // namespace hrp::diagnosis
