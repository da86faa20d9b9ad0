// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/leg_zeros.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/robust.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/checks/sole_check.h"
#include "diagnosis/floating/equations/joint_turns.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/report/words.h"
#include "diagnosis/model/made.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr const char* kMotion = "the leg against its stops, or bent at one joint after the other";

using Tilt = TiltByRecording::mapped_type;

// Of one foot: its tilt, and how a zero of each joint would tilt it.
struct Sole {
  TiltByRecording tilt;
  std::map<int, TiltByRecording> slope;  // by joint
};

// A joint's zero that the tilts ask for.
struct Zero {
  int joint = -1;
  double value = 0, std = 0;  // [rad]
  double share = 0;           // of the squares of the tilt about its axis that goes away with it
  Tilt axis{0, 0};            // about which it tilts the sole
  // Several joints of each leg are asked, so at three standard errors.
  bool is_sure() const { return std::abs(value) > std::max(kMountingError, kUnlikely * std); }
};

Sole read_sole(const std::vector<ChannelRows>& channels, const ColumnLayout& layout, const std::string& foot) {
  Sole out{list_tilts(channels, foot), {}};
  for (const ChannelRows& c : channels) {
    if (c.info.name != foot || !c.info.equation.is(EquationKind::kTilt)) continue;
    for (size_t k = 0; k < c.columns.size(); ++k) {
      const int joint = (c.columns[k] - layout.joint(0, 0)) / kJointColumns;
      if (c.columns[k] < layout.joint(0, 0) || joint >= layout.joints ||
          c.columns[k] != layout.joint(joint, kOffsetColumn))
        continue;
      std::map<int, std::vector<double>> slopes;
      for (size_t i = 0; i < c.rows(); ++i) slopes[c.recording[i]].push_back(c.row(i)[k]);
      for (const auto& [recording, s] : slopes)
        out.slope[joint].try_emplace(recording, Tilt::Zero()).first->second(c.info.equation.axis) = find_median(s);
    }
  }
  return out;
}

// Recordings are the errors: within one, an attitude that drifts is the same for all rows.
Zero fit_zero(int joint, const TiltByRecording& tilt, const TiltByRecording& slope) {
  Zero out;
  out.joint = joint;
  std::vector<double> each;
  for (const auto& [r, y] : tilt) each.push_back(slope.at(r).dot(y) / std::max(1e-12, slope.at(r).squaredNorm()));
  const auto n = static_cast<double>(each.size());
  for (double v : each) out.value += v / n;
  double spread = 0, square = 0;
  for (double v : each) {
    spread += std::pow(v - out.value, 2);
    square += v * v;
  }
  for (const auto& [r, y] : tilt) out.axis += slope.at(r) / n;
  out.std = std::sqrt(spread / (n - 1) / n) * find_widening(each.size());
  out.share = 1 - spread / std::max(1e-300, square);
  return out;
}

// Of a sole less the mean of the others.
TiltByRecording subtract_others(const std::vector<Sole>& soles, size_t own) {
  TiltByRecording out;
  for (const auto& [r, tilt] : soles[own].tilt) {
    Tilt sum = Tilt::Zero();
    double count = 0;
    for (size_t f = 0; f < soles.size(); ++f) {
      if (f != own && soles[f].tilt.count(r) > 0) {
        sum += soles[f].tilt.at(r);
        count += 1;
      }
    }
    if (count > 0) out[r] = tilt - sum / count;
  }
  return out;
}

// Joints of the leg that tilt its sole by at least half of their own turn and whose zero takes half of its tilt about
// their axis, best first. The other soles have to say the same: what tilts all of them is no zero of a leg.
std::vector<Zero> list_zeros(const LeggedLog& log, const std::vector<Sole>& soles, size_t foot) {
  std::vector<Zero> out;
  const TiltByRecording against = subtract_others(soles, foot);
  if (against.size() < 2) return out;
  for (const auto& [joint, slope] : soles[foot].slope) {
    if (!is_above(log.tree, joint + 1, log.feet[foot].link)) continue;
    const Zero own = fit_zero(joint, soles[foot].tilt, slope), other = fit_zero(joint, against, slope);
    const double ratio = other.value / own.value;
    if (own.axis.norm() > kHalf && own.is_sure() && own.share > kHalf && ratio > 0.5 && ratio < 2) out.push_back(own);
  }
  std::sort(out.begin(), out.end(), [](const Zero& a, const Zero& b) { return a.share > b.share; });
  return out;
}

// The first joint and those that tilt the sole about the same axis leave the list: one finding.
void add_first(const LeggedLog& log, const Foot& foot, std::vector<Zero>* zeros, CheckResult* out) {
  const EffectInfo& effect = get_laws().joint_offset.info();
  const auto where = [&](const Zero& z) { return Where{{"joint", log.tree.joint(z.joint).name}}; };
  const auto value = [&](const Zero& z) { return std::vector<Estimate>{make_value(effect, z.value, z.std)}; };
  const Zero first = zeros->front();
  Finding f = make_finding(effect, where(first), value(first));
  std::vector<Zero> rest;
  for (auto z = zeros->begin() + 1; z != zeros->end(); ++z) {
    const bool same = std::abs(z->axis.normalized().dot(first.axis.normalized())) > kMostly;
    if (same) f.alternatives.push_back(make_alternative(effect, where(*z), value(*z), kMotion));
    if (!same) rest.push_back(*z);
  }
  f.grade = Grade::kAmbiguous;
  f.probability = 0.8;
  f.share = first.share;
  f.weight = 0.3;
  f.statement = foot.name + format(
                                ": while it stands, the encoders have its sole askew by %.0f +- %.0f mrad in the mean "
                                "of the recordings, more than the other soles. A zero of one of the leg's joints does "
                                "that. A sole that is worn or mounted askew does, too.",
                                1e3 * std::abs(first.value) * first.axis.norm(),
                                1e3 * kNinetyFive * first.std * first.axis.norm());
  out->findings.push_back(std::move(f));
  *zeros = std::move(rest);
}

}  // namespace

void check_leg_zeros(const LeggedLog& log, const std::vector<ChannelRows>& channels, const ColumnLayout& layout,
                     CheckResult* out) {
  std::vector<Sole> soles;
  for (const Foot& foot : log.feet) soles.push_back(read_sole(channels, layout, foot.name));
  for (size_t f = 0; f < soles.size(); ++f) {
    std::vector<Zero> zeros = list_zeros(log, soles, f);
    while (!zeros.empty()) add_first(log, log.feet[f], &zeros, out);
  }
}

}  // namespace hrp::diagnosis::floating
