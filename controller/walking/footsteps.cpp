// SPDX-License-Identifier: BSD-3-Clause
#include "controller/walking/footsteps.h"

#include <algorithm>
#include <cmath>

#include "common/base/diagnostics.h"
#include "common/base/format.h"

namespace hrp::walking {
namespace {

const char* get_name(Side side) { return side == kLeft ? "left" : "right"; }

[[noreturn]] void refuse(size_t number, Side side, const std::string& reason) {
  refuse_input({"", "controller.walk"}, "step " + std::to_string(number) + " (" + get_name(side) + "): " + reason);
}

Vector2d rotate(double yaw, const Vector2d& v) { return Eigen::Rotation2Dd(yaw) * v; }

Foothold place(const Foothold& from, double x, double y, double theta) {
  Foothold hold;
  hold.p.head<2>() = from.xy() + rotate(from.yaw, {x, y});
  hold.p.z() = from.p.z();
  hold.yaw = from.yaw + theta;
  return hold;
}

// What the legs can do, seen from the supporting foot.
void check(const WalkSpec& spec, size_t number, Side side, const Foothold& support, const Foothold& hold,
           const ConstraintPlane& plane) {
  const double sign = side == kLeft ? 1.0 : -1.0;
  const Vector2d d = rotate(-support.yaw, hold.xy() - support.xy());
  const double width = sign * d.y(), turn = std::remainder(hold.yaw - support.yaw, 2.0 * M_PI);
  const double rise = hold.p.z() - support.p.z() - plane.calc_height(hold.xy() - support.xy());
  if (!d.allFinite() || !std::isfinite(turn) || !std::isfinite(rise)) refuse(number, side, "a number is not finite");
  if (std::abs(d.x()) > spec.max_length) {
    refuse(number, side, format("too long: %.3f m from the supporting foot, at most %.3f m", d.x(), spec.max_length));
  }
  if (width < spec.min_width) {
    refuse(number, side,
           format("crossing legs: the foot would stand %.3f m to its own side of the other, at least %.3f m", width,
                  spec.min_width));
  }
  if (width > spec.max_width) refuse(number, side, format("too wide: %.3f m, at most %.3f m", width, spec.max_width));
  if (std::abs(turn) > spec.max_turn) {
    refuse(number, side, format("turns too far: %.3f rad, at most %.3f rad", turn, spec.max_turn));
  }
  if (std::abs(rise) > spec.max_rise) {
    refuse(number, side, format("too high: %.3f m, at most %.3f m", rise, spec.max_rise));
  }
}

Foothold find_middle(const Stance& stance) {
  Foothold middle;
  middle.p = 0.5 * (stance.feet[kLeft].p + stance.feet[kRight].p);
  middle.yaw =
      stance.feet[kRight].yaw + 0.5 * std::remainder(stance.feet[kLeft].yaw - stance.feet[kRight].yaw, 2.0 * M_PI);
  return middle;
}

Foothold find_listed(const FootstepSpec& step, size_t number, Side side, const Stance& now, const Foothold& origin) {
  const Foothold& support = now.feet[other(side)];
  Foothold hold;
  if (step.frame == "support")
    hold = place(support, step.x, step.y, step.theta);
  else if (step.frame == "swing")
    hold = place(now.feet[side], step.x, step.y, step.theta);
  else if (step.frame == "start")
    hold = place(origin, step.x, step.y, step.theta);
  else
    refuse(number, side, "unknown frame '" + step.frame + "', expected support, swing or start");
  return hold;
}

Side find_side(const std::string& word, size_t number, Side fallback) {
  if (word.empty()) return fallback;
  if (word == "left") return kLeft;
  if (word == "right") return kRight;
  refuse(number, fallback, "unknown side '" + word + "', expected left or right");
}

class Planner {
 public:
  Planner(const WalkSpec& spec, const Stance& start, const ConstraintPlane& plane)
      : spec_(spec), plane_(plane), now_(start), origin_(find_middle(start)) {}

  void add(Side side, Foothold hold, double rise) {
    const size_t number = steps_.size() + 1;
    if (!steps_.empty() && steps_.back().side == side) {
      refuse(number, side, "the same foot twice in a row: it carries the robot");
    }
    const Foothold& support = now_.feet[other(side)];
    hold.p.z() = support.p.z() + plane_.calc_height(hold.xy() - support.xy()) + rise;
    check(spec_, number, side, support, hold, plane_);
    now_.feet[side] = hold;
    steps_.push_back({side, hold});
  }

  void add_listed() {
    Side side = spec_.first == "left" ? kLeft : kRight;
    for (const FootstepSpec& step : spec_.footsteps) {
      const size_t number = steps_.size() + 1;
      side = find_side(step.side, number, side);
      add(side, find_listed(step, number, side, now_, origin_), step.z);
      side = other(side);
    }
  }

  // The path's point moves by (length, side, turn) a step; feet stand half a stance beside it.
  void add_made() {
    const double half = 0.5 * (rotate(-origin_.yaw, now_.feet[kLeft].xy() - now_.feet[kRight].xy())).y();
    Side side = spec_.first == "left" ? kLeft : kRight;
    Foothold path = origin_;
    for (int n = 0; n <= spec_.count; ++n) {
      if (n < spec_.count) path = place(path, spec_.length, spec_.side, spec_.turn);
      add(side, place(path, 0.0, side == kLeft ? half : -half, 0.0), 0.0);
      side = other(side);
    }
  }

  std::vector<Footstep> take() { return std::move(steps_); }

 private:
  const WalkSpec& spec_;
  ConstraintPlane plane_;
  Stance now_;
  Foothold origin_;
  std::vector<Footstep> steps_;
};

}  // namespace

std::vector<Footstep> make_footsteps(const WalkSpec& spec, const Stance& start, const ConstraintPlane& plane) {
  Planner planner(spec, start, plane);
  if (!spec.footsteps.empty())
    planner.add_listed();
  else if (spec.count > 0)
    planner.add_made();
  return planner.take();
}

Vector2d limit_to_reach(const WalkSpec& spec, Side side, const Foothold& support, const Vector2d& goal) {
  const double sign = side == kLeft ? 1.0 : -1.0;
  Vector2d d = rotate(-support.yaw, goal - support.xy());
  d.x() = std::min(std::max(d.x(), -spec.max_length), spec.max_length);
  d.y() = sign * std::min(std::max(sign * d.y(), spec.min_width), spec.max_width);
  return support.xy() + rotate(support.yaw, d);
}

}  // namespace hrp::walking
