// SPDX-License-Identifier: BSD-3-Clause
// What landings tell of soles: a foot that comes down sinks into its rubber later than its force rises. The signals are
// not smoothed, because the lag is as short as a few samples.
#pragma once

#include <vector>

#include "diagnosis/findings/finding.h"
#include "diagnosis/floating/log/contacts.h"

namespace hrp::diagnosis::floating {

// A window around one landing, on an even grid: from well before the first force, so that a lag forgets how it began.
struct Landing {
  double step = 0;                    // [s]
  size_t foot = 0, other = 0;         // that comes down; that stands meanwhile
  std::vector<double> force, others;  // [N] that the sensors of both read, downwards
  double mass = 0, others_mass = 0;   // [kg] of each foot below its sensor: the upper part of it rides on the rubber
  std::vector<double> height;         // [m] of the middle of the foot's sole over the other's
  std::vector<char> flat;             // samples at which both soles lie flat: there the height tells how far they sink
};

// m d2z/dt2 + cz dz/dt + kz z = force: how far a sole sinks under a mass m that rides on it. Deviations hold what
// landings differ by, and that m is unknown: from nothing to all of the foot below its sensor.
struct SoleLaw {
  double kz = 0, kz_std = 0;  // [N/m]
  double cz = 0, cz_std = 0;  // [N s/m]
  size_t landings = 0;        // of the foot, or of the other one while this one stands; 0: nothing is told
};

// How far a sole sinks [m] for one unit of give [m/N] at each sample: inertia z'' + lag z' + z = force, with lag = cz /
// kz [s] and inertia = mass on the rubber / kz [s^2], at rest before the first sample. Exact for a force that is a line
// between samples.
std::vector<double> calc_sinking(const std::vector<double>& force, double step, double lag, double inertia);

// The laws of soles, by foot. Feet that are not `soft` are rigid; theirs are empty.
std::vector<SoleLaw> fit_landings(const std::vector<Landing>& landings, const std::vector<char>& soft);

// Puts kz and cz into the estimates of a sole, cz only if it is told. False: nothing is told, or stances say another
// kz.
bool put_law(const SoleLaw& law, std::vector<Estimate>* sole);

// Of a log that is not smoothed (Half::kAll). Empty without an attitude, encoders, and whole wrenches of two flat feet.
std::vector<Landing> list_landings(const LeggedLog& log);

}  // namespace hrp::diagnosis::floating
