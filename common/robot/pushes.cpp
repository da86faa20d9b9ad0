// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/pushes.h"

#include <limits>

#include "common/base/check.h"
#include "common/base/diagnostics.h"
#include "common/robot/hand.h"
#include "common/robot/movers.h"

namespace hrp {
namespace {

constexpr double kTick = 1e-9;  // [s] times are sums of steps

bool acts(double time, double start, double duration) {
  return time >= start - kTick && time < start + duration - kTick;
}

// The moving link of a link or frame, and the frame's pose in it; -1 when the robot has no such name.
int find_link(const TreeSpec& tree, const std::string& name, Transform* X_LF) {
  const int frame = tree.find_frame(name);
  if (frame < 0) return tree.find_link(name);
  *X_LF = tree.frames[static_cast<size_t>(frame)].X_LF;
  return tree.frames[static_cast<size_t>(frame)].link;
}

int find_link(const TreeSpec& tree, const Scenario& scenario, const std::string& key, const std::string& name,
              Transform* X_LF) {
  const int link = find_link(tree, name, X_LF);
  if (link >= 0) return link;
  throw InputError(scenario.make_diagnostic(key + ".link", "the robot has no link '" + name + "'"));
}

// A hand acts with the state at the beginning of a step. On a free mass m that is stable for 2 c dt + k dt^2 < 4 m; a
// point away from the centre of mass feels less than its link's mass, hence a quarter of that.
void check_hand(const HandSpec& hand, const std::string& key, double mass, const Scenario& scenario) {
  const double dt = scenario.time_step;
  const double needed = dt * (2.0 * hand.damping_W.maxCoeff() + dt * hand.stiffness_W.maxCoeff());
  if (needed <= mass) return;
  throw InputError(scenario.make_diagnostic(
      key, "is too stiff for a link of " + std::to_string(mass) + " kg and a step of " + std::to_string(dt) +
               " s: 2 damping dt + stiffness dt^2 is " + std::to_string(needed) + " kg"));
}

}  // namespace

Pushes::Pushes(const RobotDescription& robot, const Scenario& scenario, const State& start)
    : model_(robot.tree), data_(model_) {
  for (const PushSpec& spec : scenario.pushes) {
    if (names_mover(scenario, spec.link)) continue;
    Transform X_LF;
    Push push{find_link(robot.tree, scenario, "pushes." + spec.name, spec.link, &X_LF), spec};
    push.spec.p_LQ = X_LF * spec.p_LQ;
    pushes_.push_back(push);
  }
  if (!scenario.hands.empty()) add_hands(scenario, start);
  active_.reserve(pushes_.size() + hands_.size());
}

void Pushes::add_hands(const Scenario& scenario, const State& start) {
  update_kinematics(model_, start, &data_);
  for (const HandSpec& spec : scenario.hands) {
    Transform X_LF;
    const std::string key = "hands." + spec.name;
    Hand hand{find_link(model_.spec(), scenario, key, spec.link, &X_LF), spec, {}};
    check_hand(spec, key, model_.spec().links[static_cast<size_t>(hand.link)].inertia.mass, scenario);
    hand.spec.p_LQ = X_LF * spec.p_LQ;
    hand.p_WH0 = get_pose(data_, hand.link) * hand.spec.p_LQ;
    hands_.push_back(hand);
  }
}

void Pushes::set_live(const PushForces& forces) {
  live_.clear();
  for (const PushForce& force : forces) {
    Transform X_LF;
    const int link = find_link(model_.spec(), force.link, &X_LF);
    HRP_CHECK(link >= 0, "no link " << force.link);
    live_.push_back({link, {"", force.link, X_LF * force.p_LQ, force.force_W}});
  }
}

void Pushes::add(const std::string& name, int link, const Vector3d& p_LQ, const Vector3d& arm_W,
                 const Vector3d& force_W) {
  acting_.push_back({name, model_.spec().links[static_cast<size_t>(link)].name, p_LQ, force_W});
  ExternalWrench wrench;
  wrench.link = link;
  wrench.F_W << arm_W.cross(force_W), force_W;
  active_.push_back(wrench);
}

const ExternalWrenches& Pushes::find(double time, const State& state) {
  active_.clear();
  acting_.clear();
  bool posed = false;
  const auto pose = [&](int link) {
    if (!posed) update_kinematics(model_, state, &data_);
    posed = true;
    return get_pose(data_, link);
  };
  for (const Push& push : pushes_) {
    if (!acts(time, push.spec.start, push.spec.duration)) continue;
    add(push, pose(push.link));
  }
  for (const Push& push : live_) add(push, pose(push.link));
  for (const Hand& hand : hands_) {
    const HandSpec& spec = hand.spec;
    const double never = std::numeric_limits<double>::infinity();
    if (!acts(time, spec.start, spec.duration > 0.0 ? spec.duration : never)) continue;
    const Transform X_WL = pose(hand.link);
    const Vector3d p_WQ = X_WL * spec.p_LQ, v_WQ = calc_point_velocity(data_, hand.link, p_WQ).tail<3>();
    const HandPlace place = calc_hand_place(spec, time - spec.start);
    add(spec.name, hand.link, spec.p_LQ, p_WQ - X_WL.p,
        calc_hand_force(spec, hand.p_WH0 + place.p - p_WQ, place.v - v_WQ));
  }
  return active_;
}

}  // namespace hrp
