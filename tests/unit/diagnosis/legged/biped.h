// SPDX-License-Identifier: BSD-3-Clause
// A biped of our own for claims about robots on their feet. Its readings are made from the equations of motion, so that
// each case hides exactly what its name says.
#pragma once

#include <string>

#include "common/spatial/transform.h"
#include "diagnosis/data/recording.h"
#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis::floating {

// What is hidden from the model.
struct Hidden {
  double load = 0;                 // [kg]
  std::string carrier = "pelvis";  // of the load
  Vector3d place{0, 0, 0};         // [m]
  double dry = 0;                  // [N m] in the left knee
  double rotor = 0;                // [kg m^2] there
  double every = 0;                // [N m] dry friction of every joint
  double force_scale = 1;          // of the left foot's sensor
  double lower = 0;                // [m] by which the left thigh's centre of mass lies lower
  double zero_y = 0;               // [N m] that the left foot's sensor reads about y without a load
  Vector3d turn{0, 0, 0};          // [rad] of the left foot's sensor against its link, a rotation vector
  double heavier = 1;              // factor of all masses
  double give = 0;                 // [rad/(N m)] of the left hip: its link falls behind its encoder
  double slope = 0;                // [rad] of the ground about y
  double push = 0;                 // [N] amplitude of somebody's hand at the base's origin, along y
  double tether = 0;               // [N/m] of a spring to the world at the pelvis's centre of mass, along x
  double bend = 0;                 // [rad/(N m)] of what carries the left hip, about x, across its axis
  double every_viscous = 0;        // [N m s/rad] of every joint
  double every_rotor = 0;          // [kg m^2] of every joint
};

// What is recorded beside encoders and IMU.
struct Recorded {
  bool six_axes = true, effort = true;
  double unit = 1, zero = 0;  // of the vertical forces, where six_axes is false
  bool imu = true;
  bool leans = false;       // both feet stay where they are
  bool right_foot = true;   // has a force sensor
  bool moments = true;      // of the force sensors
  bool whole_feet = false;  // forces of the ground on the whole foot, not of an ankle on the leg
  bool lifts = false;       // bears all of its weight on one foot in turn
  bool pose = false;        // motion capture of the base
  double creep = 0;         // [rad/s] by which hips that lean go on leaning
};

// Encoders and force sensors alone. Flat feet that stand tell how the body moves.
constexpr Recorded kLeans{.effort = false, .imu = false, .leans = true};

// A pelvis and two legs of hip, knee and ankle, all about y.
std::string make_biped_urdf();

constexpr const char* kBipedScenario =
    "robot: biped.urdf\nbase: floating\ndrive: motion\nfeet: [l_foot, r_foot]\n"
    "sensors: {imu: {waist: {link: pelvis}}, wrench: {l: {link: l_foot}, r: {link: r_foot}}}\n";

// A link of a URDF. `z` [m]: its centre of mass; `more`: further elements.
std::string make_link(const std::string& name, double mass, double z, const std::string& more = "");

// Three recordings of 8 s at 250 Hz, the last one held out.
Experiment make_biped(const Hidden& hidden, const Recorded& recorded = {});

// Turns the feet's force sensors by half a turn about x, in the model and in the readings, as those of the iCub are.
void hang_upside_down(Experiment* e);

// Readings of a sensor of three axes times a factor.
void scale_readings(const std::string& sensor, double factor, Experiment* e);

Evidence diagnose_biped(const Hidden& hidden, const Recorded& recorded = {});

}  // namespace hrp::diagnosis::floating
