// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/conventions/turned_legs.h"

#include <algorithm>
#include <map>
#include <optional>

#include "common/multibody/kinematics.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/checks/imu_over_legs.h"
#include "diagnosis/floating/conventions/frame_search.h"
#include "diagnosis/floating/conventions/sides.h"
#include "diagnosis/floating/log/contacts.h"
#include "diagnosis/measurement/joint_zeros.h"

namespace hrp::diagnosis::floating {
namespace {

// What soles that give and feet that settle move against each other, although all is right.
constexpr double kAngle = kFarMore * kCalibrated, kPlace = 0.005;  // [rad], [m]

// What does not move against each other: two feet that stand, or one and the world. In the world, the base's pose is
// recorded, or its attitude: then flat feet keep theirs.
enum class Against { kFeet, kWorld };

// A moment at which two feet stand, and since when: neither was lifted between moments of the same `stand`.
struct Moment {
  const Clip* clip = nullptr;
  size_t k = 0, a = 0;      // sample, foot
  std::optional<size_t> b;  // the other foot; none: the world
  long stand = 0;
};

using Pair = std::pair<size_t, std::optional<size_t>>;  // as a and b of a moment

// An IMU on the base that has an attitude; -1: none.
int find_attitude_of_base(const LeggedLog& log) {
  for (size_t i = 0; i < log.imus.size(); ++i) {
    if (log.imus[i].attitude && log.imus[i].link == 0) return static_cast<int>(i);
  }
  return -1;
}

std::vector<Pair> list_pairs(const LeggedLog& log, Against against) {
  std::vector<Pair> out;
  const bool attitude = find_attitude_of_base(log) >= 0;
  for (size_t a = 0; a < log.feet.size(); ++a) {
    if (against == Against::kWorld && (log.base_pose || (attitude && log.feet[a].flat)))
      out.emplace_back(a, std::nullopt);
    for (size_t b = a + 1; against == Against::kFeet && b < log.feet.size(); ++b) {
      if (log.feet[a].flat == log.feet[b].flat) out.emplace_back(a, b);
    }
  }
  return out;
}

std::vector<Moment> list_moments(const LeggedLog& log, const Contacts& contacts, Against against) {
  std::vector<Moment> out;
  const std::vector<Pair> pairs = list_pairs(log, against);
  size_t samples = 0;
  for (const Clip& c : log.clips) samples += c.size();
  const size_t stride = std::max<size_t>(1, samples * pairs.size() / kMostMoments);
  long stand = 0;
  for (const auto& [a, b] : pairs) {
    for (size_t c = 0; c < log.clips.size(); ++c) {
      if (c == 0 || log.clips[c].recording != log.clips[c - 1].recording) ++stand;
      for (size_t k = 0; k < log.clips[c].size(); ++k) {
        const bool both = contacts.loaded[c][a][k] && (!b || contacts.loaded[c][*b][k]);
        if (!both) ++stand;
        if (both && k % stride == 0) out.push_back({&log.clips[c], k, a, b, stand});
      }
    }
  }
  return out;
}

Matrix3d find_attitude(const LeggedLog& log, const Clip& clip, size_t k) {
  if (log.base_pose) return get_quaternion(clip.base_attitude, k).toRotationMatrix();
  const auto i = static_cast<size_t>(find_attitude_of_base(log));
  return get_quaternion(clip.imus[i].attitude, k).toRotationMatrix() * log.imus[i].R_LI.transpose();
}

// Of a moment: pose of the second foot's sole, or of the world, in the first one's axes; of balls, what does not depend
// on how they roll. `turned`: a joint with the other sign, -1: none.
Transform find_pose(const LeggedLog& log, const Model& model, const Moment& m, int turned, State* state, Data* data) {
  for (int j = 0; j < model.num_joints(); ++j) {
    const Track& t = m.clip->position[static_cast<size_t>(j)];
    state->q(j) = t.empty() ? 0.0 : t.value[m.k] * (j == turned ? -1.0 : 1.0);
  }
  update_kinematics(model, *state, data);
  const Foot& a = log.feet[m.a];
  const Transform X_BA = get_pose(*data, a.link);
  const Vector3d p_BA = X_BA * a.p_LC;
  if (!m.b) {
    const Matrix3d R_WB = find_attitude(log, *m.clip, m.k);
    const Vector3d p_WA =
        log.base_pose ? get_values(m.clip->base_position, m.k) + R_WB * p_BA : Vector3d(Vector3d::Zero());
    return {a.flat ? Matrix3d(R_WB * X_BA.R) : Matrix3d::Identity(), p_WA};
  }
  const Foot& b = log.feet[*m.b];
  const Transform X_BC = get_pose(*data, b.link);
  const Vector3d p_AC_B = X_BC * b.p_LC - p_BA;
  if (!a.flat) return {Matrix3d::Identity(), Vector3d(p_AC_B.norm(), 0, 0)};
  return {X_BA.R.transpose() * X_BC.R, X_BA.R.transpose() * p_AC_B};
}

// [1] By moment: how far the feet are from where they are on average while they stand.
std::vector<double> list_moved(const LeggedLog& log, const std::vector<Moment>& moments, int turned) {
  const Model model(log.tree);
  State state = make_state(model);
  Data data(model);
  std::vector<Transform> poses;
  std::map<long, std::vector<size_t>> stands;
  for (size_t i = 0; i < moments.size(); ++i) {
    poses.push_back(find_pose(log, model, moments[i], turned, &state, &data));
    stands[moments[i].stand].push_back(i);
  }
  std::vector<double> moved(moments.size(), 0.0);
  for (const auto& [stand, members] : stands) {
    std::vector<Vector6d> from_first;
    Vector6d mean = Vector6d::Zero();
    for (size_t i : members) {
      const Eigen::AngleAxisd turn(Matrix3d(poses[members[0]].R.transpose() * poses[i].R));
      Vector6d x;
      x << turn.angle() * turn.axis() / kAngle, (poses[i].p - poses[members[0]].p) / kPlace;
      from_first.push_back(x);
      mean += x / static_cast<double>(members.size());
    }
    for (size_t i = 0; i < members.size(); ++i) moved[members[i]] = (from_first[i] - mean).norm();
  }
  return moved;
}

// The joint whose other sign leaves least, or -1: by odds against the model's sign and against every other joint's.
int find_turned_joint(const LeggedLog& log, const Contacts& contacts, Against against, double* left) {
  const std::vector<Moment> moments = list_moments(log, contacts, against);
  if (!is_enough(Purpose::kForClocks, moments.size())) return -1;
  std::vector<Instant> at;
  for (const Moment& m : moments) at.push_back({m.clip, m.k});
  const std::vector<double> nominal = list_moved(log, moments, -1);
  const double before = find_square(nominal);
  std::map<double, std::pair<int, std::vector<double>>> trials;
  for (int j : list_leg_joints(log)) {
    if (!log.has_position[static_cast<size_t>(j)]) continue;
    std::vector<double> moved = list_moved(log, moments, j);
    const double square = find_square(moved);
    trials[square] = {j, std::move(moved)};
  }
  if (trials.empty() || trials.begin()->first > kPart * before) return -1;
  const auto& [joint, least] = trials.begin()->second;
  if (calc_odds(at, least, nominal) < kOdds) return -1;
  for (auto other = std::next(trials.begin()); other != trials.end(); ++other) {
    if (other->first < kPart * before && calc_odds(at, least, other->second.second) < kOdds) return -1;
  }
  *left *= trials.begin()->first / before;
  return joint;
}

// One or none.
std::vector<int> find_turned(const Experiment& e, double* left) {
  const LeggedLog log = make_legged_log(e, Half::kEven);
  if (log.feet.empty() || log.clips.empty()) return {};
  const Contacts contacts = find_contacts(log);
  int joint = find_turned_joint(log, contacts, Against::kFeet, left);
  if (joint < 0) joint = find_turned_joint(log, contacts, Against::kWorld, left);
  return joint < 0 ? std::vector<int>{} : std::vector<int>{joint};
}

}  // namespace

TurnedJoints find_turned_legs(const Experiment& e) { return turn_joints(e, find_turned, convert_turned_legs); }

Experiment convert_turned_legs(Experiment e, const TurnedJoints& turned) {
  std::vector<JointZero> zeros;
  for (int joint : turned.joints) zeros.push_back({joint, 0.0, 0.0, true});
  return convert_zeros(std::move(e), zeros);
}

std::string describe_turned_legs(const Experiment& e, const TurnedJoints& turned) {
  return describe(
      e, turned,
      "counted the other way than the model's axis. With the logged sign, feet that stand move against each other",
      "that");
}

}  // namespace hrp::diagnosis::floating
