// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/conventions/turned_efforts.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/data/mean.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/conventions/frame_search.h"
#include "diagnosis/floating/equations/equations.h"
#include "diagnosis/floating/equations/leg_forces.h"
#include "diagnosis/floating/equations/leg_friction.h"
#include "diagnosis/measurement/joint_zeros.h"

namespace hrp::diagnosis::floating {
namespace {

// The balance of the body by legs, and the joints whose torques are in it.
struct Balance {
  std::vector<ChannelRows> rows;
  std::vector<int> joints, gains;  // columns of their gains
};

Balance make_balance(const Experiment& e) {
  Balance out;
  const LeggedLog log = make_legged_log(e, Half::kEven);
  const std::vector<char> tell = list_legs_that_tell(log);
  const bool felt = std::any_of(log.feet.begin(), log.feet.end(), [](const Foot& f) { return f.sensor >= 0; });
  if (log.clips.empty() || felt || tell.empty()) return out;
  const ColumnLayout layout(log);
  for (size_t j = 0; j < tell.size(); ++j) {
    if (tell[j] && log.has_effort[j]) {
      out.joints.push_back(static_cast<int>(j));
      out.gains.push_back(layout.joint(static_cast<int>(j), kGainColumn));
    }
  }
  const RowTable table = make_equations(log, find_contacts(log));
  for (const ChannelRows& c : table.channels()) {
    if (c.info.equation.is_balance_by_legs() && c.rows() > 0) out.rows.push_back(c);
  }
  leave_out_leg_friction(layout, &out.rows);
  return out;
}

// [1] By row, over what drives hide: what the six equations leave if the efforts of these gains are turned.
std::vector<double> list_left(const Balance& b, const std::vector<int>& turned) {
  std::vector<double> squares(b.rows[0].rows(), 0.0);
  for (const ChannelRows& c : b.rows) {
    if (!(c.info.error > 0)) continue;  // an axis that no leg acts along
    std::vector<int> columns;
    for (const int gain : turned) columns.push_back(c.find_column(gain));
    for (size_t i = 0; i < squares.size(); ++i) {
      double y = c.y[i];
      for (const int column : columns) y += 2 * c.row(i)[column];
      squares[i] += std::pow(y / c.info.error, 2);
    }
  }
  for (double& x : squares) x = std::sqrt(x);
  return squares;
}

// The joints whose other sign leaves least, one or all: by odds against the log's signs and against every other
// joint's.
std::vector<int> find_turned(const Experiment& e, double* left) {
  const Balance b = make_balance(e);
  if (b.rows.empty()) return {};
  const std::vector<double> nominal = list_left(b, {});
  const double before = std::pow(calc_rms(nominal), 2);
  std::map<double, std::pair<std::vector<int>, std::vector<double>>> trials;
  const auto add = [&](const std::vector<int>& joints, const std::vector<int>& gains) {
    std::vector<double> of_these = list_left(b, gains);
    const double square = std::pow(calc_rms(of_these), 2);
    trials[square] = {joints, std::move(of_these)};
  };
  for (size_t i = 0; i < b.joints.size(); ++i) add({b.joints[i]}, {b.gains[i]});
  add(b.joints, b.gains);
  const auto& [square, best] = *trials.begin();
  if (square > kPart * before || calc_odds_by_block(b.rows[0].block, best.second, nominal) < kOdds) return {};
  for (auto other = std::next(trials.begin()); other != trials.end() && other->first < kPart * before; ++other) {
    if (calc_odds_by_block(b.rows[0].block, best.second, other->second.second) < kOdds) return {};
  }
  *left *= square / before;
  return best.first;
}

}  // namespace

TurnedJoints find_turned_efforts(const Experiment& e) { return turn_joints(e, find_turned, convert_turned_efforts); }

Experiment convert_turned_efforts(Experiment e, const TurnedJoints& turned) {
  for (const int joint : turned.joints) e = turn_effort(std::move(e), joint);
  return e;
}

std::string describe_turned_efforts(const Experiment& e, const TurnedJoints& turned) {
  return describe(e, turned,
                  "the effort counts the other way than the model's axis. With the logged sign, the torques of "
                  "standing legs do not carry the body",
                  "what is missing");
}

}  // namespace hrp::diagnosis::floating
