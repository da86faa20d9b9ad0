// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/motions.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace hrp::diagnosis {
namespace {

constexpr double kRest = 0.3;  // [s] at rest at both ends
constexpr double kFade = 1.0;  // [s] in which a motion fades, and in which it grows at least
// A motion grows over a third of its time, at most this long [s]. A drive may be weaker than stated, and poor
// recordings do not tell. Then a joint leaves its command after the first second: less is no recording that shows it.
constexpr double kGrow = 2.0;

// Replaces the distributions of <random>, which differ between libraries.
class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() - engine_.min()) /
                     static_cast<double>(engine_.max() - engine_.min());
  }

 private:
  std::mt19937 engine_;
};

// Smooth step from 0 to 1 within one second, with zero first and second derivatives at both ends.
double rise(double t) {
  const double s = std::clamp(t, 0.0, 1.0);
  return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
}

using Curve = std::function<double(double)>;  // -1 to 1 as a function of time [s]

// One sine in each of six equal bands of log f, up to `quickest` [Hz]. If all were drawn from the whole range, some
// joints would get slow ones only: their inertia would not show, and all that a quick neighbour does to them would look
// like an effect of their own.
Curve make_sines(double quickest, Draw& draw) {
  struct Term {
    double a, w, p;
  };
  constexpr int kBands = 6;      // of frequencies
  constexpr double kLow = 0.12;  // [Hz]
  std::vector<Term> terms;
  double total = 0.0;
  for (int i = 0; i < kBands; ++i) {
    const double width = std::log(quickest / kLow) / kBands, f = kLow * std::exp(width * (i + draw.uniform(0.0, 1.0)));
    terms.push_back({draw.uniform(0.3, 1.0) / std::sqrt(f / kLow), 2.0 * M_PI * f, draw.uniform(0.0, 2.0 * M_PI)});
    total += terms.back().a;
  }
  return [terms, total](double t) {
    double q = 0.0;
    for (const Term& term : terms) q += term.a * std::sin(term.w * t + term.p);
    return q / total;
  };
}

struct Leg {
  double begin, length, from, to;
};

Curve follow(const std::vector<Leg>& legs, bool even) {
  return [legs, even](double t) {
    double q = 0.0;
    for (const Leg& leg : legs) {
      if (t < leg.begin) break;
      const double s = std::clamp((t - leg.begin) / leg.length, 0.0, 1.0);
      // Constant speed, except for a tenth of the way at each end.
      constexpr double b = 0.1;
      const double ramp = s < b         ? s * s / (2.0 * b)
                          : s > 1.0 - b ? 1.0 - b - (1.0 - s) * (1.0 - s) / (2.0 * b)
                                        : s - b / 2.0;
      q = leg.from + (leg.to - leg.from) * (even ? ramp / (1.0 - b) : rise(s));
    }
    return q;
  };
}

// Moves from end to end and back, slowly and fast, with stops in between.
Curve make_two_speeds(Draw& draw, double seconds) {
  std::vector<Leg> legs;
  double t = draw.uniform(0.0, 0.4), at = 0.0, side = draw.uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
  for (int i = 0; t < seconds; ++i) {
    const double length = i % 4 < 2 ? draw.uniform(1.3, 2.0) : draw.uniform(0.35, 0.5),
                 to = side * draw.uniform(0.7, 1.0);
    legs.push_back({t, length, at, to});
    at = to;
    side = -side;
    t += length + draw.uniform(0.1, 0.35);
  }
  return follow(legs, true);
}

// Quick moves over parts of the range, with pauses in which vibrations decay.
Curve make_targets(Draw& draw, double seconds, double shortest, double longest, double pause) {
  std::vector<Leg> legs;
  double t = draw.uniform(0.0, 0.4), at = 0.0;
  while (t < seconds) {
    const double length = draw.uniform(shortest, longest), to = draw.uniform(-1.0, 1.0);
    legs.push_back({t, length, at, to});
    at = to;
    t += length + pause * draw.uniform(0.4, 1.0);
  }
  return follow(legs, false);
}

// From low to high frequency, with decreasing amplitude to limit the speed.
Curve make_chirp(Draw& draw, double seconds) {
  const double low = draw.uniform(0.15, 0.3), high = draw.uniform(4.0, 7.0), k = std::log(high / low) / seconds,
               p = draw.uniform(0.0, 2.0 * M_PI);
  return [=](double t) {
    const double f = low * std::exp(k * t), phase = 2.0 * M_PI * low * (std::exp(k * t) - 1.0) / k;
    return std::sin(phase + p) * std::min(1.0, std::pow(low / f, 0.8) * 1.2);
  };
}

// So slow that joints with friction stick visibly, with reversals of many sizes.
Curve make_creep(Draw& draw) {
  const double f = draw.uniform(0.1, 0.2), g = draw.uniform(0.45, 0.7), p = draw.uniform(0.0, 2.0 * M_PI);
  return [=](double t) { return 0.75 * std::sin(2.0 * M_PI * f * t + p) + 0.25 * std::sin(2.0 * M_PI * g * t); };
}

// A slow sweep plus a fast small motion.
Curve make_ripple(Draw& draw) {
  const double f = draw.uniform(0.1, 0.18), g = draw.uniform(2.5, 5.0), p = draw.uniform(0.0, 2.0 * M_PI);
  return [=](double t) { return 0.9 * std::sin(2.0 * M_PI * f * t + p) + 0.1 * std::sin(2.0 * M_PI * g * t); };
}

Curve make_curve(const MotionPlan& plan, Draw& draw) {
  const double seconds = plan.seconds;
  switch (plan.family) {
    case Family::kTwoSpeeds: return make_two_speeds(draw, seconds);
    case Family::kSteps: return make_targets(draw, seconds, 0.2, 0.4, 0.6);
    case Family::kChirp: return make_chirp(draw, seconds);
    case Family::kPostures: return make_targets(draw, seconds, 0.7, 1.1, 1.2);
    case Family::kCreep: return make_creep(draw);
    case Family::kRipple: return make_ripple(draw);
    default: return make_sines(plan.quickest, draw);
  }
}

// Motion around the middle of the free range, from the start position and back to it.
void fill(const Curve& curve, const JointLimits& limits, const MotionPlan& plan, double size, std::vector<double>* q) {
  const double middle = 0.5 * (limits.lower + limits.upper), half = 0.5 * (limits.upper - limits.lower);
  const double end = static_cast<double>(q->size() - 1) * plan.period,
               grows = std::clamp((end - 2.0 * kRest) / 3.0, kFade, kGrow);
  for (size_t k = 0; k < q->size(); ++k) {
    const double t = static_cast<double>(k) * plan.period;
    const double share = rise((t - kRest) / grows) * rise((end - kRest - t) / kFade);
    (*q)[k] = limits.start + share * size * (middle - limits.start + half * curve(t));
  }
}

double find_largest(const std::vector<double>& values) {
  double most = 0.0;
  for (double v : values) most = std::max(most, std::abs(v));
  return most;
}

}  // namespace

const char* get_family_word(Family family) {
  static const char* const words[] = {"multisine", "two_speeds", "steps", "chirp", "postures", "creep", "ripple",
                                      "sway",      "lean",       "squat", "stir",  "swing",    "turn",  "walk"};
  return words[static_cast<size_t>(family)];
}

const char* get_family_sentence(Family family) {
  static const char* const sentences[] = {
      "Several sine waves at once.",
      "From end to end, slowly and fast, with stops in between.",
      "Quick moves with pauses.",
      "A sine wave that gets faster and smaller.",
      "Moves between postures that are held for a second.",
      "Very slow motion with turns.",
      "A slow sweep with a small quick motion on it.",
      "The feet stand, the body sways sideways.",
      "The feet stand, the body moves forward and back.",
      "The feet stand, the knees bend.",
      "The feet stand, the body moves and turns about all axes, and the limbs that stand on nothing swing.",
      "The feet and the body stand, the limbs that stand on nothing swing.",
      "The feet stand, the body turns left and right and tilts.",
      "A few steps forward and back: keep a metre free around the robot, and hold it by a slack rope."};
  return sentences[static_cast<size_t>(family)];
}

double get_size(const MotionPlan& plan, size_t joint) {
  return joint < plan.shares.size() ? plan.size * plan.shares[joint] : plan.size;
}

std::vector<double> calc_rates(const std::vector<double>& q, double period) {
  std::vector<double> v(q.size(), 0.0);
  for (size_t k = 1; k + 1 < q.size(); ++k) v[k] = (q[k + 1] - q[k - 1]) / (2.0 * period);
  return v;
}

void follow_leaders(const Limits& limits, std::vector<std::vector<double>>* columns, bool rates) {
  for (size_t j = 0; j < limits.joints.size(); ++j) {
    const MimicSpec& mimic = limits.joints[j].mimic;
    if (mimic.joint < 0) continue;
    const std::vector<double> leader = (*columns)[static_cast<size_t>(mimic.joint)];
    std::vector<double>& own = (*columns)[j];
    own.resize(leader.size());
    for (size_t k = 0; k < leader.size(); ++k) own[k] = mimic.multiplier * leader[k] + (rates ? 0.0 : mimic.offset);
  }
}

Commands make_motion(const MotionPlan& plan, const Limits& limits) {
  Commands out;
  const size_t rows = static_cast<size_t>(std::lround(plan.seconds / plan.period)) + 1;
  for (size_t k = 0; k < rows; ++k) out.time.push_back(static_cast<double>(k) * plan.period);
  Draw draw(plan.seed * 7919u + static_cast<unsigned>(plan.family));
  for (size_t j = 0; j < limits.joints.size(); ++j) {
    const JointLimits& joint = limits.joints[j];
    const Curve curve = make_curve(plan, draw);
    std::vector<double> q(rows, joint.start);
    if (plan.moves[j]) fill(curve, joint, plan, get_size(plan, j), &q);
    std::vector<double> v = calc_rates(q, plan.period);
    const double excess = find_largest(v) / joint.speed;
    if (excess > 1.0) {
      for (double& x : q) x = joint.start + (x - joint.start) / excess;
      v = calc_rates(q, plan.period);
    }
    out.position.push_back(std::move(q));
    out.velocity.push_back(std::move(v));
  }
  follow_leaders(limits, &out.position, false);
  follow_leaders(limits, &out.velocity, true);
  return out;
}

}  // namespace hrp::diagnosis
