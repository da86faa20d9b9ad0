// SPDX-License-Identifier: BSD-3-Clause
// The eighteen motions, and the fourteen of [M14].
#include <random>

#include "diagnosis/identification/motions.h"

namespace hrp::identification {
namespace {

const char* const kSides[2] = {"R", "L"};

Waves both(double a1, double f1, double a2, double f2, double phase) {
  return {{a1, f1, phase}, {a2, f2, 2.0 * phase + 0.5}};
}

// What makes every motion tell stiffness apart from damping on all four axes: the feet turn against their soles, slowly
// and quickly, right and left against each other, so that the robot as a whole hardly moves.
void add_foot_waves(int number, double amplitude, MotionPlan* plan) {
  const double shift = 0.7 * number;
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? 1.0 : -1.0;
    plan->foot[side][0] = both(sign * 0.8 * amplitude, 0.31 + 0.017 * number, sign * 0.4 * amplitude, 1.13, shift);
    plan->foot[side][1] =
        both(sign * 0.8 * amplitude, 0.23 + 0.013 * number, sign * 0.4 * amplitude, 0.97, shift + 1.0);
  }
  // Pelvis and chest turn left and right, one radian in all: tells the accelerometer's bias from offsets of the bush,
  // the better the longer they stay turned (hence the third harmonic). The waist ends at 0.785 rad.
  const double sign = number % 2 == 0 ? 1.0 : -1.0, once = 1.0 / plan->duration;
  plan->upper["WAIST_Y"] = {{0.84 * sign, once, 0.0}, {0.17 * sign, 3.0 * once, 0.0}};
  plan->turn = {{0.28 * sign, once, 0.0}, {0.056 * sign, 3.0 * once, 0.0}};
}

void add_tilts(std::vector<MotionPlan>* plans) {
  const char* const stances[] = {"regular", "sideways", "forward"};
  for (int i = 0; i < 6; ++i) {
    MotionPlan plan;
    plan.name = "tilt" + std::to_string(i + 1);
    plan.meaning =
        std::string("chest tilts at 0.1 Hz, ") + stances[i / 2] + " stance" + (i % 2 ? ", with vertical sway" : "");
    plan.width = i / 2 == 1 ? 0.05 : 0.0;
    plan.stride = i / 2 == 2 ? 0.04 : 0.0;
    plan.lean[0] = {{i / 2 == 2 ? 0.01 : 0.02, 0.1, 0.4 * i}};
    plan.lean[1] = {{0.03, 0.1, 1.3 + 0.3 * i}};
    plan.pelvis[0] = {{0.006, 0.1, 0.5 * i}};
    plan.pelvis[1] = {{i / 2 == 2 ? 0.008 : 0.012, 0.1, 1.0 + 0.5 * i}};
    if (i % 2) plan.pelvis[2] = {{0.015, 0.3, 0.0}};
    add_foot_waves(i, i / 2 == 2 ? 0.017 : 0.02, &plan);
    plans->push_back(plan);
  }
}

// Pushed on the trunk by a hand, both feet down.
void add_pushed_sways(std::vector<MotionPlan>* plans) {
  const char* const meanings[] = {"hand sways forward and back", "hand sways sideways", "hand sways around"};
  for (int i = 0; i < 3; ++i) {
    MotionPlan plan;
    plan.name = "sway" + std::to_string(i + 1);
    plan.meaning = meanings[i];
    if (i != 1) plan.push[0] = {{i == 2 ? 2.5 : 4.0, 0.17 + 0.01 * i, 0.3 * i}, {1.5, 0.81, 0.0}};
    if (i != 0) plan.push[1] = {{i == 1 ? 12.0 : 8.0, 0.21 + 0.02 * i, 0.0}, {i == 2 ? 3.0 : 5.0, 0.71, 0.4}};
    add_foot_waves(6 + i, i == 1 ? 0.02 : 0.017, &plan);
    plans->push_back(plan);
  }
}

// On one foot the rubber does not hold this robot (K < m g h): the hand does, and sways it. The pelvis keeps its
// heading: the other leg would not reach.
void add_held_sways(std::vector<MotionPlan>* plans) {
  for (int i = 3; i < 5; ++i) {
    MotionPlan plan;
    plan.name = "sway" + std::to_string(i + 1);
    plan.lifted = i == 3 ? 1 : 0;
    plan.meaning = i == 3 ? "hand holds and sways, right foot alone" : "hand holds and sways, left foot alone";
    add_foot_waves(6 + i, 0.02, &plan);
    plan.turn.clear();
    for (Waves& waves : plan.foot[plan.lifted]) waves.clear();
    plan.hand[0] = {{0.012, 0.17 + 0.01 * i, 0.3 * i}, {0.003, 0.81, 0.0}};
    plan.hand[1] = {{0.015, 0.21 + 0.02 * i, 0.0}, {0.004, 0.71, 0.4}};
    plans->push_back(plan);
  }
}

void add_rest(std::vector<MotionPlan>* plans) {
  for (int i = 0; i < 2; ++i) {
    MotionPlan plan;
    plan.name = "sweep" + std::to_string(i + 1);
    plan.meaning = "random sweep of the upper body";
    std::mt19937_64 random(static_cast<unsigned long long>(i) + 7);
    const auto draw = [&] { return draw_share(&random); };
    add_foot_waves(11 + i, 0.018, &plan);
    for (const char* joint : {"R_SHOULDER_P", "L_SHOULDER_P", "R_ELBOW", "L_ELBOW", "NECK_Y", "WAIST_P"}) {
      const double size = std::string(joint) == "WAIST_P" ? 0.015 : 0.2;
      plan.upper[joint] = {{size * (0.5 + 0.5 * draw()), 0.1 + 0.2 * draw(), 6.0 * draw()},
                           {0.3 * size * draw(), 0.3 + 0.4 * draw(), 6.0 * draw()}};
    }
    plans->push_back(plan);
  }
  MotionPlan squat;
  squat.name = "squat";
  squat.meaning = "pelvis down 6 cm and up";
  squat.pelvis[2] = {{-0.03, 0.1, 0.0}, {-0.02, 0.2, 0.0}};
  add_foot_waves(13, 0.018, &squat);
  plans->push_back(squat);
  MotionPlan bounce;  // beyond the paper: only quick changes of load show the vertical stiffness to an accelerometer
  bounce.name = "bounce";
  bounce.meaning = "pelvis bounces at 1.9 and 4.6 Hz: vertical stiffness";
  bounce.pelvis[2] = {{0.003, 1.9, 0.0}, {0.001, 4.6, 1.0}};
  add_foot_waves(14, 0.01, &bounce);
  plans->push_back(bounce);
}

// All joints of the upper body at once, each with two waves of its own: tells link from link, and friction from
// inertia.
void add_swings(std::vector<MotionPlan>* plans) {
  const char* const arm[] = {"SHOULDER_P", "SHOULDER_R", "SHOULDER_Y", "ELBOW", "WRIST_Y", "WRIST_P"};
  for (int i = 0; i < 3; ++i) {
    MotionPlan plan;
    plan.name = "swing" + std::to_string(i + 1);
    plan.meaning = "arms, neck and trunk swing at random";
    std::mt19937_64 random(static_cast<unsigned long long>(i) + 31);
    const auto draw = [&] { return draw_share(&random); };
    const auto make = [&](double size) -> Waves {
      return {{size * (0.6 + 0.4 * draw()), 0.15 + 0.2 * draw(), 6.0 * draw()},
              {0.4 * size * (0.6 + 0.4 * draw()), 0.5 + 0.5 * draw(), 6.0 * draw()}};
    };
    add_foot_waves(15 + i, 0.016, &plan);
    plan.lean[0] = make(0.005);
    plan.lean[1] = make(0.008);
    plan.upper["WAIST_P"] = make(0.012);
    plan.upper["NECK_Y"] = make(0.5);
    plan.upper["NECK_P"] = make(0.3);
    for (const char* side : kSides) {
      for (const char* joint : arm) plan.upper[std::string(side) + "_" + joint] = make(joint[0] == 'W' ? 0.5 : 0.2);
    }
    plans->push_back(plan);
  }
}

void add_paper_tilts(std::vector<MotionPlan>* plans) {
  const char* const stances[] = {"stance A", "stance B, feet apart", "stance C, one foot ahead"};
  for (int i = 0; i < 6; ++i) {
    MotionPlan plan;
    plan.name = "tilt" + std::to_string(i + 1);
    plan.meaning = std::string("chest tilts at 0.1 Hz, ") + stances[i % 3] + (i < 3 ? "" : ", with vertical motion");
    plan.width = i % 3 == 1 ? 0.05 : 0.0;
    plan.stride = i % 3 == 2 ? 0.04 : 0.0;
    plan.lean[0] = {{0.02, 0.1, 0.4}};
    plan.lean[1] = {{0.03, 0.1, 1.3}};
    plan.pelvis[0] = {{0.010, 0.1, 0.5}};
    plan.pelvis[1] = {{0.012, 0.1, 1.0}};
    if (i >= 3) plan.pelvis[2] = {{0.015, 0.3, 0.0}};
    plans->push_back(plan);
  }
}

// sway1 on both feet; sway2, 3 on the right foot forward and sideways; sway4, 5 on the left one.
void add_paper_sways(std::vector<MotionPlan>* plans) {
  for (int i = 0; i < 5; ++i) {
    MotionPlan plan;
    plan.name = "sway" + std::to_string(i + 1);
    const bool sideways = i == 2 || i == 4;
    if (i == 0) {
      plan.meaning = "hand sways around, both feet";
      plan.push[0] = {{4.0, 0.17, 0.0}, {1.5, 0.81, 0.0}};
      plan.push[1] = {{12.0, 0.21, 0.0}, {5.0, 0.71, 0.4}};
    } else {
      plan.lifted = i < 3 ? 1 : 0;
      plan.meaning = std::string("hand holds and sways ") + (sideways ? "sideways, " : "forward and back, ") +
                     (i < 3 ? "right foot alone" : "left foot alone");
      plan.hand[sideways ? 1 : 0] = {{0.015, 0.2, 0.0}, {0.005, 0.8, 0.4}};
    }
    plans->push_back(plan);
  }
}

void finish(double scale, std::vector<MotionPlan>* plans) {
  for (size_t i = 0; i < plans->size(); ++i) {
    (*plans)[i].duration *= scale;
    (*plans)[i].seed = i + 1;
  }
}

}  // namespace

std::vector<MotionPlan> make_plans(double scale) {
  std::vector<MotionPlan> plans;
  add_tilts(&plans);
  add_pushed_sways(&plans);
  add_held_sways(&plans);
  add_rest(&plans);
  add_swings(&plans);
  finish(scale, &plans);
  return plans;
}

std::vector<MotionPlan> make_paper_plans(double scale) {
  std::vector<MotionPlan> plans, rest;
  add_paper_tilts(&plans);
  add_paper_sways(&plans);
  add_rest(&rest);
  for (MotionPlan& plan : rest) {
    if (plan.name == "bounce") continue;
    for (auto& foot : plan.foot) {
      foot[0].clear();
      foot[1].clear();
    }
    plan.turn.clear();
    plan.upper.erase("WAIST_Y");
    plans.push_back(plan);
  }
  finish(scale, &plans);
  return plans;
}

}  // namespace hrp::identification
