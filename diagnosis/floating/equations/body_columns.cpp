// SPDX-License-Identifier: BSD-3-Clause
// Columns of links, drives, encoders and forces from outside.
#include <algorithm>
#include <cmath>

#include "common/multibody/kinematics.h"
#include "diagnosis/estimate/slopes.h"
#include "diagnosis/floating/equations/body_rows.h"

namespace hrp::diagnosis::floating {
namespace {

// Adds a force along a world axis at a point of a link, as a sensor would not feel it.
void pull(const BodySample& at, int link, const Vector3d& p, int axis, double size, int column, BodyRows* rows) {
  if (size == 0) return;
  const Vector3d direction_B = at.motion.find_attitude(at.k).transpose().col(axis);
  rows->put_wrench({link, p, size * direction_B, Vector3d::Zero()}, -1, column);
}

void add_pull_on_link(const BodySample& at, const ColumnLayout& layout, int link, BodyRows* rows) {
  const Vector3d place = at.motion.find_place(at.k);
  const Vector3d p = get_pose(at.motion.data(), link) * at.log.tree.links[static_cast<size_t>(link)].inertia.p_LLcm_L;
  for (int a = 0; a < 3; ++a) pull(at, link, p, a, 1, layout.pull(link, kPullColumn + a), rows);
  const std::pair<int, int> by_place[] = {
      {0, 0}, {0, 1}, {1, 1}, {2, 0}, {2, 1}};  // axes of the force and of the place
  for (int i = 0; i < 5; ++i) {
    const auto [axis, along] = by_place[i];
    const int column = layout.pull(link, kPullByPlaceColumn + i);
    pull(at, link, p, axis, place(along), column, rows);
    if (i == 1) pull(at, link, p, along, place(axis), column, rows);
  }
}

// Which of the five columns of a foot count at a sample of the clip: it is loaded, about to lift, just lifted, about to
// land, just landed.
// `near`: samples.
bool is_in_phase(const std::vector<char>& loaded, long i, long near, int which) {
  const auto n = static_cast<long>(loaded.size());
  const auto is = [&](long at) { return loaded[static_cast<size_t>(std::clamp(at, 0L, n - 1))] != 0; };
  const bool now = is(i), changed = now != is(i - near), will = now != is(i + near);
  const bool of[] = {now, now && will, !now && changed, !now && will, now && changed};
  return of[which];
}

// The same, 0 to 1, smoothed as all signals are; near is what the kernel reaches.
double calc_phase(const BodySample& at, const std::vector<char>& loaded, int which) {
  const auto reach = static_cast<long>(at.clip.edge), n = static_cast<long>(loaded.size()), k = static_cast<long>(at.k);
  double sum = 0, total = 0;
  for (long i = std::max(0L, k - reach); i <= std::min(n - 1, k + reach); ++i) {
    const double w = std::exp(-0.5 * std::pow(static_cast<double>(i - k) * at.clip.step / at.clip.sigma, 2));
    sum += is_in_phase(loaded, i, reach, which) ? w : 0;
    total += w;
  }
  return sum / total;
}

}  // namespace

void add_link_columns(BodyEquations* equations, BodyRows* rows) {
  BodyMotion& motion = rows->at().motion;
  if (!equations->regressor) equations->regressor = std::make_unique<Regressor>(motion.model());
  calc_regressor(motion.model(), motion.vdot(), &motion.data(), equations->regressor.get());
  const Regressor& Y = *equations->regressor;
  for (int l = 0; l < equations->layout.links; ++l) {
    for (int p = 0; p < kInertialParameters; ++p) {
      const long at = kInertialParameters * l + p;
      const int column = equations->layout.link(l, p);
      for (int i = 0; i < 6 && equations->channels.balances; ++i) rows->put(i, Y.Y_BI(i, at), column);
      if (equations->channels.weighs) rows->put(kWeightRow, rows->normal().dot(Y.Y_BI.block<3, 1>(3, at)), column);
      for (int j = 0; j < l; ++j) {
        if (Y.Y_JI(j, at) != 0) rows->put(kJointRow + j, Y.Y_JI(j, at), column);
      }
    }
  }
}

void add_pull_columns(const BodyEquations& equations, BodyRows* rows) {
  const BodySample& at = rows->at();
  for (int link : equations.channels.pulled) add_pull_on_link(at, equations.layout, link, rows);
  for (int f = 0; f < equations.layout.feet; ++f) {
    const Foot& foot = at.log.feet[static_cast<size_t>(f)];
    const std::vector<char>& loaded = equations.contacts.loaded[at.clip_index][static_cast<size_t>(f)];
    const Vector3d p = get_pose(at.motion.data(), foot.link) * foot.p_LC;
    for (int c = 0; c < kHolds; ++c) {
      pull(at, foot.link, p, 2, calc_phase(at, loaded, c), equations.layout.foot(f, kHoldColumn + c), rows);
    }
  }
}

void add_drive_columns(const BodyEquations& equations, BodyRows* rows) {
  const BodySample& at = rows->at();
  for (int j = 0; j < equations.layout.joints; ++j) {
    const auto i = static_cast<size_t>(j);
    if (!rows->uses_joint(j)) continue;
    const Track& q = at.clip.position[i];
    const bool moves = !q.empty();
    const double v = moves ? q.rate[at.k] : 0, a = moves ? q.second[at.k] : 0,
                 way = moves ? equations.ways[i][at.k] : 0;
    const double effort = rows->nominal().measured(kJointRow + j);
    double rate = 0;
    if (at.log.has_effort[i]) {
      rate = at.clip.effort[i].rate[at.k];
    } else if (at.log.has_law[i]) {
      calc_servo_law(at, i, &rate);
      rows->put(kJointRow + j, rate, equations.layout.joint(j, kDelayColumn));
    }
    const double by_column[] = {v, way, way * std::abs(effort), a, -effort, moves ? q.value[at.k] : 0, 1.0, rate};
    for (int c = 0; c < kOffsetColumn; ++c) rows->put(kJointRow + j, by_column[c], equations.layout.joint(j, c));
  }
}

void add_turn_columns(const JointTurn& turn, BodyRows* rows) {
  const Eigen::VectorXd slope = rows->calc_slope(kSlopeStep);
  for (const auto& [column, factor] : turn.columns) rows->put_all(factor * slope, column);
}

void add_servo_rows(const BodyEquations& equations, const BodySample& at) {
  const std::vector<Track>& efforts = at.clip.logged.empty() ? at.clip.effort : at.clip.logged;
  for (int j = 0; j < equations.layout.joints; ++j) {
    const auto i = static_cast<size_t>(j);
    const int channel = equations.channels.servo[i];
    if (channel < 0) continue;
    double rate = 0;
    const double logged = efforts[i].value[at.k], law = calc_servo_law(at, i, &rate);
    equations.table.begin_row(channel, logged - law, logged);
    equations.table.add(channel, equations.layout.joint(j, kDelayColumn), -rate);
    equations.table.add(channel, equations.layout.joint(j, kEffortScaleColumn), law);
  }
}

}  // namespace hrp::diagnosis::floating
