// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/load_share.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/base/rounding.h"
#include "common/multibody/kinematics.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis::floating {
namespace {

struct Pair {
  size_t foot = 0, sensor = 0;
};

// The two feet with a sensor of vertical force each; empty otherwise.
std::vector<Pair> find_pair(const LeggedLog& log) {
  std::vector<Pair> pair;
  for (size_t f = 0; f < log.feet.size(); ++f) {
    const int s = log.feet[f].sensor;
    if (s >= 0 && log.sensors[static_cast<size_t>(s)].axis[2]) pair.push_back({f, static_cast<size_t>(s)});
  }
  return pair.size() == 2 && log.feet.size() == 2 ? pair : std::vector<Pair>{};
}

Vector3d get_middle(const LeggedLog& log, BodyMotion* motion, size_t foot) {
  return get_pose(motion->data(), log.feet[foot].link) * log.feet[foot].p_LC;
}

// Every share of a clip whose feet are known, away from its ends.
void add_shares(const LeggedLog& log, const Clip& clip, const std::vector<Pair>& pair, std::vector<LoadShare>* out) {
  BodyMotion motion(log, clip);
  Eigen::VectorXd tau(motion.model().nv());
  for (size_t k = clip.edge; k + clip.edge < clip.size(); k += 2) {
    motion.update(k);
    calc_inverse_dynamics(motion.model(), motion.vdot(), nullptr, &motion.data(), &tau);
    const double first = calc_vertical_force(log, clip, pair[0].sensor, k),
                 second = calc_vertical_force(log, clip, pair[1].sensor, k);
    const Vector3d p_1 = get_middle(log, &motion, pair[0].foot), p_2 = get_middle(log, &motion, pair[1].foot);
    const Vector3d up = motion.find_up(k), apart = p_1 - p_2 - up * up.dot(p_1 - p_2);
    const Vector3d zmp = calc_zero_moment_point(tau.head<3>(), tau.segment<3>(3), up, p_2);
    if (!(first + second > 0) || !zmp.allFinite()) continue;
    out->push_back({first / (first + second), std::clamp((zmp - p_2).dot(apart) / apart.squaredNorm(), 0.0, 1.0)});
  }
}

// How the feet's share of the load agrees with the zero-moment point.
struct Agreement {
  double correlation = 0, rest = 0,
         more = 0;  // rest: root mean square of the difference; more: of the first foot, on average
};

Agreement find_agreement(const std::vector<LoadShare>& shares) {
  double mean_m = 0, mean_r = 0;
  const double n = static_cast<double>(shares.size());
  for (const LoadShare& s : shares) {
    mean_m += s.measured / n;
    mean_r += s.required / n;
  }
  double mm = 0, rr = 0, mr = 0, rest = 0;
  for (const LoadShare& s : shares) {
    const double m = s.measured - mean_m, r = s.required - mean_r;
    mm += m * m;
    rr += r * r;
    mr += m * r;
    rest += std::pow(s.measured - s.required, 2) / n;
  }
  return {mr / std::sqrt(std::max(1e-300, mm * rr)), std::sqrt(rest), mean_m - mean_r};
}

std::string describe_shares(const LeggedLog& log, const std::vector<Pair>& pair,
                            const std::map<size_t, std::vector<LoadShare>>& by_recording,
                            const std::vector<LoadShare>& all) {
  const auto [correlation, rest, more] = find_agreement(all);
  std::string text = "load share: the forces of " + log.feet[pair[0].foot].name + " and " +
                     log.feet[pair[1].foot].name + " follow the zero-moment point with a correlation of " +
                     number(correlation, 2) + ", to " + number(rest, 2) + " of the load";
  std::string each;
  for (const auto& [recording, shares] : by_recording) {
    if (shares.size() < kFewestToSay || by_recording.size() < 2) continue;
    const Agreement own = find_agreement(shares);
    each += (each.empty() ? "" : ", ") + log.experiment->recordings[recording].spec.name + " " +
            number(own.correlation, 2) + " and " + number(own.rest, 2);
  }
  if (!each.empty()) text += " (" + each + ")";
  // Encoders and sizes of feet are no better known.
  if (std::abs(more) < kMinor) return text;
  return text + "; " + log.feet[pair[more > 0 ? 0 : 1].foot].name + " carries " + number(std::abs(more), 2) +
         " more than that: a force sensor's scale or zero, or a centre of mass beside where the model has it";
}

}  // namespace

Vector3d calc_zero_moment_point(const Vector3d& moment_B, const Vector3d& force_B, const Vector3d& up_B,
                                const Vector3d& p_B) {
  const Vector3d about_p = moment_B - p_B.cross(force_B);
  return p_B + up_B.cross(about_p) / up_B.dot(force_B);
}

std::vector<std::string> compare_loads(const LeggedLog& log) {
  std::vector<std::string> notes;
  const std::vector<Pair> pair = find_pair(log);
  if (pair.empty() || !log.tree.floating_base) return notes;
  std::vector<LoadShare> shares;
  std::map<size_t, std::vector<LoadShare>> by_recording;
  for (const Clip& clip : log.clips) add_shares(log, clip, pair, &by_recording[clip.recording]);
  for (const auto& [recording, own] : by_recording) shares.insert(shares.end(), own.begin(), own.end());
  if (shares.size() >= kFewestToSay) notes.push_back(describe_shares(log, pair, by_recording, shares));
  return notes;
}

}  // namespace hrp::diagnosis::floating
