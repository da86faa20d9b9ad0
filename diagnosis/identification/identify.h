// SPDX-License-Identifier: BSD-3-Clause
// From recordings to stiffness, damping and offset of the bushes, with what was checked on the way.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/identification/body_fit.h"
#include "diagnosis/identification/bush_fit.h"
#include "diagnosis/identification/vertical.h"

namespace hrp::identification {

// The robot still with its feet in the air: zeroes force sensors and gyroscope.
constexpr const char* kHanging = "hanging";

struct Source {
  std::string name;
  RobotLog log;
  bool train = true;  // fitted, else only predicted
  // A hand on the robot is no part of its equations of motion: sways tell of the bush only.
  bool is_pushed() const { return name.rfind("sway", 0) == 0; }
};

// Tracks of all motions and what goes with them into every fit.
struct Observation {
  std::vector<SensorZero> zeros;
  std::vector<MotionTrack> fitted, unseen;
  FitOptions options;                               // noise from the hanging robot, vertical compliance
  VerticalFit vertical;                             // empty when the motions do not show it
  bool zeroed = false;                              // there was a recording of the hanging robot
  Eigen::Vector2d taken = Eigen::Vector2d::Zero();  // [m/s^2] bias x, y that was taken off the accelerometer beforehand
};
// A first linear fit tells how soles hang on their bushes, which the force sensors' zeros depend on, and the bias of
// the accelerometer: 2 mrad, whose square would be 4e-6 rad of the vertical, 2 mN m of an offset.
Observation observe(const BushObserver& observer, const std::vector<Source>& sources);

struct Identification {
  Scenario scenario;
  bool simulated = true;
  std::vector<MotionTrack> tracks;  // all that could be used
  BushFit fit;
  LawChoice choice;
  VerticalFit vertical;
  std::vector<ValidationError> direct;  // motions that were fitted
  std::vector<ValidationError> cross;   // each motion predicted by a fit that has not seen it
  std::optional<BodyFit> body;          // [M14 eq. 2, 3], where motions tell enough
  std::vector<std::string> notes;       // what was left out and why
};

// Fits, chooses the law, validates. Of a simulated robot the description is the truth: the body is then identified from
// one that is wrong by about a tenth of every length and density.
Identification identify(const Scenario& scenario, const std::vector<Source>& sources, bool simulated);

// The body alone; the bush's fit tells the errors of the IMU.
BodyFit identify_body(const Scenario& scenario, const std::vector<Source>& sources,
                      const std::vector<SensorZero>& zeros, const BushFit& fit, bool simulated);

// How often intervals hold the truth: the same motions with the sensor errors of other seeds, linear law.
struct Coverage {
  struct Row {
    size_t foot = 0;
    int axis = 0, parameter = 0;     // K, C, O
    double truth = 0.0, mean = 0.0;  // of the estimates
    double spread = 0.0;             // standard deviation of the estimates
    double stated = 0.0;             // mean of the standard deviations that the fits state
    double worst = 0.0;              // largest error
    int inside = 0;                  // 95 % intervals that hold the truth
  };
  int seeds = 0;
  std::vector<Row> rows;
};
// `clean`: logs without sensor errors.
Coverage study_coverage(const Scenario& scenario, const std::vector<Source>& clean, int seeds);
std::string make_text(const Coverage& coverage, const Scenario& scenario);

}  // namespace hrp::identification
