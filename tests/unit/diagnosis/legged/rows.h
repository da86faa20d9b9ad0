// SPDX-License-Identifier: BSD-3-Clause
// Rows of equations, as recordings give them: from even and from odd samples.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/fit/row_table.h"

namespace hrp::diagnosis::floating {

const ChannelInfo kWeight{EquationKind::kWeight, "/wrench/l/force", "N", "link", "pelvis"};
const ChannelInfo kBalance{{EquationKind::kForce, 2}, "/wrench/l/force", "N", "link", "pelvis"};
inline ChannelInfo make_joint_channel(const std::string& joint) {
  return {EquationKind::kJoint, "/joint_states/" + joint + "/effort", "N m", "joint", joint};
}

// Builds both halves. The first two thirds of the cells are fitted, the last one is held out, as a recording of its
// own.
class RowHalves {
 public:
  using Channels = std::vector<std::pair<ChannelInfo, std::vector<int>>>;  // with the columns of each
  RowHalves(int columns, int cells, const Channels& channels) : cells_(cells), even_(columns), odd_(columns) {
    for (RowTable* half : {&even_, &odd_}) {
      for (const auto& [info, own] : channels) half->add_channel(info, own);
    }
  }
  int cells() const { return cells_; }

  // Adds cell i of 40 ms to both halves; twelve cells are a block. Calls add(half, sign), with sign 1 for the even half
  // and -1 for the odd one.
  template <class Add>
  void add_cell(int i, double roughness, const Add& add) {
    const bool train = 3 * i < 2 * cells_;
    for (RowTable* half : {&even_, &odd_}) {
      half->begin_cell({0.04 * i, train ? 0 : 1, i / 12, 0, train, 1, roughness});
      add(half, half == &even_ ? 1 : -1);
      half->end_cell();
    }
  }

  std::vector<ChannelRows> merge() {
    even_.finish();
    odd_.finish();
    return merge_halves(even_, odd_);
  }

 private:
  int cells_;
  RowTable even_, odd_;
};

// Cells that are a little rougher or calmer than each other, in no order.
inline double get_mixed_roughness(int i) { return 1.0 + 0.001 * (i % 7); }

// An effect at a joint, of which a report would tell the first coefficient.
inline Candidate make_candidate(EffectId effect, const char* joint, std::vector<Terms> terms) {
  static std::map<EffectId, CandidateLaw> laws;
  CandidateLaw& law = laws[effect];
  law.effect = effect;
  law.make_estimates = [](const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
    return std::vector<Estimate>{{"value", "1", {x(0)}, {std(0)}, false}};
  };
  Candidate c;
  c.law = &law;
  c.where = {{"joint", joint}};
  c.terms = std::move(terms);
  return c;
}

// One joint's rows, calm and rough. The first column explains large errors of the rough rows. The second explains small
// ones of the calm rows; in rough rows its halves oppose each other.
std::vector<ChannelRows> make_calm_and_rough();

}  // namespace hrp::diagnosis::floating
