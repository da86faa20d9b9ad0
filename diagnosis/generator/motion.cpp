// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/motion.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

namespace hrp::cases {
namespace {

constexpr double kTwoPi = 6.28318530717958647692;

// Position [rad] and velocity [rad/s] at a time [s].
struct Point {
  double q = 0, v = 0;
};
using Curve = std::function<Point(double)>;

// Rises from 0 to 1 within one second, twice differentiable at both ends, so that a motion begins at rest.
Point fade_in(double t) {
  const double s = std::clamp(t, 0.0, 1.0);
  return {s * s * s * (10 - 15 * s + 6 * s * s), s < 1 && s > 0 ? 30 * s * s * (1 - s) * (1 - s) : 0};
}

Curve faded(Curve inner) {
  return [inner](double t) {
    const Point a = fade_in(t), b = inner(t);
    return Point{a.q * b.q, a.v * b.q + a.q * b.v};
  };
}

Curve sum_of_sines(double amplitude, double low, double high, int count, Prng& r) {
  struct Term {
    double a, w, p;
  };
  std::vector<Term> terms;
  double total = 0;
  for (int i = 0; i < count; ++i) {
    const double f = r.log_uniform(low, high);
    terms.push_back({r.uniform(0.3, 1) / std::sqrt(f / low), kTwoPi * f, r.uniform(0, kTwoPi)});
    total += terms.back().a;
  }
  for (Term& term : terms) term.a *= amplitude / total;
  return faded([terms](double t) {
    Point out;
    for (const Term& term : terms) {
      out.q += term.a * std::sin(term.w * t + term.p);
      out.v += term.a * term.w * std::cos(term.w * t + term.p);
    }
    return out;
  });
}

// Goes to random targets; between two the quintic rest-to-rest curve of the given duration, then a pause.
Curve targets(double amplitude, double move_low, double move_high, double pause, Prng& r) {
  struct Leg {
    double start, duration, from, to;
  };
  auto legs = std::make_shared<std::vector<Leg>>();
  double t = 0.3 * r.uniform(0, 1), at = 0;
  while (t < 20) {
    const double duration = r.uniform(move_low, move_high), to = amplitude * r.uniform(-1, 1);
    legs->push_back({t, duration, at, to});
    at = to;
    t += duration + pause * r.uniform(0.3, 1);
  }
  return [legs](double t) {
    Point out;
    for (const Leg& leg : *legs) {
      if (t < leg.start) break;
      const Point s = fade_in((t - leg.start) / leg.duration);
      out = {leg.from + (leg.to - leg.from) * s.q, (leg.to - leg.from) * s.v / leg.duration};
    }
    return out;
  };
}

// Rounded triangles: long stretches of nearly constant velocity, slow reversals.
Curve slow_triangle(double amplitude, Prng& r) {
  const double f = r.uniform(0.12, 0.35), phase = r.uniform(0, kTwoPi);
  return faded([=](double t) {
    Point out;
    for (int k = 1; k <= 5; k += 2) {
      const double a = amplitude * 0.81 * ((k / 2) % 2 ? -1.0 : 1.0) / (k * k), w = kTwoPi * f * k;
      out.q += a * std::sin(w * t + k * phase);
      out.v += a * w * std::cos(w * t + k * phase);
    }
    return out;
  });
}

std::vector<Curve> arm_curves(const RobotPlan& robot, const std::string& kind, Prng& r) {
  std::vector<Curve> curves;
  for (int j = 0; j < joint_count(robot); ++j) {
    const double amplitude = r.uniform(0.4, 0.75);
    if (kind == "trapezoid")
      curves.push_back(targets(amplitude, 0.5, 1.1, 0.5, r));
    else if (kind == "step")
      curves.push_back(targets(0.6 * amplitude, 0.25, 0.45, 0.9, r));
    else if (kind == "slow")
      curves.push_back(slow_triangle(amplitude, r));
    else
      curves.push_back(sum_of_sines(amplitude, 0.12, 2.2, 5, r));
  }
  return curves;
}

Curve scaled(const Curve& inner, double factor) {
  return [=](double t) {
    const Point p = inner(t);
    return Point{factor * p.q, factor * p.v};
  };
}

void add_to(std::vector<Curve>& curves, const RobotPlan& robot, int j, const Curve& curve) {
  const Curve before = curves[static_cast<std::size_t>(j)], added = scaled(curve, joint(robot, j).sense);
  curves[static_cast<std::size_t>(j)] = [before, added](double t) {
    const Point a = before(t), b = added(t);
    return Point{a.q + b.q, a.v + b.v};
  };
}

// Adds a curve to the joints whose role ends so, on both sides; `mirror` turns the right side's sign.
void add_both(std::vector<Curve>& curves, const RobotPlan& robot, const std::string& suffix, const Curve& curve,
              bool mirror) {
  for (const char* side : {"left_", "right_"}) {
    const int j = find_role(robot, side + suffix);
    if (j >= 0) add_to(curves, robot, j, mirror && side[0] == 'r' ? scaled(curve, -1) : curve);
  }
}

// Knee angle follows the curve, hip and ankle keep foot level below the hip (all relative to the start pose).
void add_squat(std::vector<Curve>& curves, const RobotPlan& robot, const Curve& knee) {
  const JointPlan& left = joint(robot, find_role(robot, "left_knee"));
  const double start = left.sense * left.start;
  const char* names[] = {"hip_pitch", "knee", "ankle_pitch"};
  for (std::size_t i = 0; i < 3; ++i) {
    add_both(
        curves, robot, names[i],
        [&robot, knee, start, i](double t) {
          const Point k = knee(t);
          const double h = 1e-5, at = start + k.q;
          const double slope = (level_leg(robot, at + h)[i] - level_leg(robot, at - h)[i]) / (2 * h);
          return Point{level_leg(robot, at)[i] - level_leg(robot, start)[i], slope * k.v};
        },
        false);
  }
}

void add_limbs(std::vector<Curve>& curves, const RobotPlan& robot, double size, Prng& r) {
  add_both(curves, robot, "shoulder", sum_of_sines(0.5 * size, 0.2, 1.2, 3, r), r.chance(0.5));
  add_both(curves, robot, "elbow", sum_of_sines(0.4 * size, 0.2, 1.2, 3, r), false);
  const int waist = find_role(robot, "waist");
  if (waist >= 0) add_to(curves, robot, waist, sum_of_sines(0.06 * size, 0.2, 1.0, 3, r));
  for (int j = 0; j < joint_count(robot); ++j) {
    if (joint(robot, j).role == "arm") add_to(curves, robot, j, sum_of_sines(0.3 * size, 0.2, 1.2, 3, r));
  }
}

bool has_ankle_rolls(const RobotPlan& robot) { return find_role(robot, "left_ankle_roll") >= 0; }

std::vector<Curve> biped_curves(const RobotPlan& robot, const std::string& kind, Prng& r) {
  std::vector<Curve> curves(static_cast<std::size_t>(joint_count(robot)), [](double) { return Point{}; });
  if (kind == "release") return curves;
  if (kind == "squat") add_squat(curves, robot, sum_of_sines(0.2, 0.15, 0.6, 3, r));
  const bool rolls = has_ankle_rolls(robot);  // else soles stand on their edges as soon as hips roll
  if (kind == "spread") add_both(curves, robot, "hip_roll", sum_of_sines(0.035, 0.15, 0.8, 3, r), true);
  if (kind == "limbs") add_limbs(curves, robot, 1.0, r);
  if (rolls && (kind == "sway" || kind == "squat")) {
    const Curve roll = sum_of_sines(kind == "sway" ? 0.05 : 0.03, 0.15, 0.7, 3, r);
    add_both(curves, robot, "hip_roll", roll, false);
    add_both(curves, robot, "ankle_roll", scaled(roll, -1), false);
  }
  if (kind == "sway" || kind == "limbs") {
    add_both(curves, robot, "ankle_pitch", sum_of_sines(0.02, 0.15, 0.8, 3, r), false);
    add_limbs(curves, robot, 0.4, r);
  }
  return curves;
}

}  // namespace

Commands Commands::sample(const std::vector<double>& at) const {
  Commands out;
  out.time = at;
  for (std::size_t j = 0; j < position.size(); ++j) {
    out.position.emplace_back(at.size());
    out.velocity.emplace_back(at.size());
    for (std::size_t k = 0; k < at.size(); ++k)
      find(static_cast<int>(j), at[k], out.position[j][k], out.velocity[j][k]);
  }
  return out;
}

void Commands::find(int joint, double t, double& position_out, double& velocity_out) const {
  const auto& q = position[static_cast<std::size_t>(joint)];
  const auto& v = velocity[static_cast<std::size_t>(joint)];
  if (t < time.front() || t >= time.back()) {
    position_out = t < time.front() ? q.front() : q.back();
    velocity_out = t == time.back() ? v.back() : 0;
    return;
  }
  const std::size_t k = static_cast<std::size_t>(std::upper_bound(time.begin(), time.end(), t) - time.begin()) - 1;
  const double h = time[k + 1] - time[k], s = (t - time[k]) / h, s2 = s * s, s3 = s2 * s;
  position_out = (2 * s3 - 3 * s2 + 1) * q[k] + (s3 - 2 * s2 + s) * h * v[k] + (3 * s2 - 2 * s3) * q[k + 1] +
                 (s3 - s2) * h * v[k + 1];
  velocity_out = (6 * s2 - 6 * s) / h * (q[k] - q[k + 1]) + (3 * s2 - 4 * s + 1) * v[k] + (3 * s2 - 2 * s) * v[k + 1];
}

Commands make_commands(const RobotPlan& robot, const std::string& kind, const std::vector<double>& time, Prng& random) {
  const std::vector<Curve> curves =
      robot.floating ? biped_curves(robot, kind, random) : arm_curves(robot, kind, random);
  Commands out;
  out.time = time;
  for (int j = 0; j < joint_count(robot); ++j) {
    std::vector<double> q, v;
    for (double t : time) {
      const Point p = curves[static_cast<std::size_t>(j)](t);
      q.push_back(joint(robot, j).start + p.q);
      v.push_back(p.v);
    }
    out.position.push_back(std::move(q));
    out.velocity.push_back(std::move(v));
  }
  return out;
}

std::vector<std::string> draw_motion_kinds(const RobotPlan& robot, Prng& random) {
  if (robot.floating) {
    const std::string last = random.chance(0.5) ? "limbs" : "squat";
    const bool spreads = random.chance(0.5) && has_ankle_rolls(robot);
    return {"sway", "squat", spreads ? "spread" : "release", "sway", last};
  }
  std::vector<std::string> kinds{"multisine", "multisine", "trapezoid", "slow", "step"};
  random.shuffle(kinds);
  return kinds;
}

}  // namespace hrp::cases
