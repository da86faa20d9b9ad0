// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/fall_watch.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "common/base/has.h"

namespace hrp {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kFallenTilt = 60 * kDegree, kTouchingTilt = 30 * kDegree, kDueTilt = 15 * kDegree;
constexpr double kFallenHeight = 0.2, kTouchingHeight = 0.5, kDueHeight = 0.8;  // shares of the height at the start

}  // namespace

FallWatch::FallWatch(const RobotDescription& robot, const Scenario& scenario, const std::string& name)
    : watching_(robot.tree.floating_base && scenario.floating_base &&
                (scenario.ground.present || !scenario.obstacles.empty())),
      name_(name),
      ground_(make_ground_plane(scenario.ground)) {
  for (const LinkSpec& link : robot.tree.links) names_.push_back(link.name);
  feet_.assign(names_.size(), 0);
  touched_ = feet_;
  for (const CollisionShape& shape : robot.shapes) {
    if (shape.sole) feet_[static_cast<size_t>(shape.link)] = 1;
  }
}

void FallWatch::reset(const Eigen::Quaterniond& R_WB, const Vector3d& p_WB) {
  up_B_ = R_WB.conjugate() * ground_.n_W;
  start_height_ = ground_.n_W.dot(p_WB) - ground_.offset;
  fallen_ = false;
  stands_ = ground_.present;
  std::fill(touched_.begin(), touched_.end(), 0);
}

bool FallWatch::is_due(const Eigen::Quaterniond& R_WB, const Vector3d& p_WB) {
  if (!watching_) return false;
  height_ = ground_.n_W.dot(p_WB) - ground_.offset;
  base_z_ = p_WB.z();
  cosine_ = ground_.n_W.dot(R_WB * up_B_);
  if (ground_.present && is_upright()) return false;  // without a plane, forces tell the height
  tilt_ = std::acos(std::clamp(cosine_, -1.0, 1.0));
  return true;
}

bool FallWatch::is_upright() const { return cosine_ > std::cos(kDueTilt) && height_ > kDueHeight * start_height_; }

void FallWatch::update_foothold(const ContactForces& forces) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const PairForce& pair : forces) {
    if (!is_ground_pair(pair, ground_)) continue;
    if (pair.points.empty()) lowest = std::min(lowest, pair.p_WR.z());
    for (const PointForce& point : pair.points) lowest = std::min(lowest, point.p_WC.z());
  }
  if (std::isfinite(lowest)) foothold_z_ = lowest;
  height_ = base_z_ - foothold_z_;
  if (stands_ || !std::isfinite(lowest)) return;
  start_height_ = height_;
  stands_ = true;
}

bool FallWatch::has_fallen() const {
  if (tilt_ > kFallenTilt || height_ < kFallenHeight * start_height_) return true;
  const bool touches = has(touched_, 1);
  return touches && (tilt_ > kTouchingTilt || height_ < kTouchingHeight * start_height_);
}

std::optional<FallEvent> FallWatch::update(const ContactForces& forces) {
  if (!ground_.present) update_foothold(forces);
  if (!stands_ || is_upright()) return std::nullopt;
  FallEvent event;
  std::string newest;
  for (const PairForce& pair : forces) {
    if (!is_ground_pair(pair, ground_) || pair.body_a < 0 || is_foot(pair.body_a)) continue;
    if (!(pair.total.tail<3>().squaredNorm() > 0.0)) continue;
    const auto link = static_cast<size_t>(pair.body_a);
    event.links.push_back(names_[link]);
    if (touched_[link] == 0) newest += (newest.empty() ? "" : ", ") + names_[link];
    touched_[link] = 1;
  }
  event.fall = !fallen_ && has_fallen();
  if (!event.fall && newest.empty()) return std::nullopt;
  fallen_ = fallen_ || event.fall;
  event.tilt = tilt_;
  event.height = height_;
  event.text = describe(event, newest);
  return event;
}

std::string FallWatch::describe(const FallEvent& event, const std::string& newest) const {
  char pose[120];
  std::snprintf(pose, sizeof pose, "base tilted by %.0f deg, %.2f m above the ground (%.2f m at the start)",
                event.tilt / kDegree, event.height, start_height_);
  if (!event.fall)
    return (name_.empty() ? "" : name_ + ": ") + newest +
           (newest.find(',') == std::string::npos ? " touches" : " touch") + " the ground; " + pose;
  std::string text = (name_.empty() ? "the robot" : "robot '" + name_ + "'") + " has fallen: " + pose;
  for (size_t i = 0; i < event.links.size(); ++i) text += (i == 0 ? "; on the ground: " : ", ") + event.links[i];
  return text;
}

}  // namespace hrp
