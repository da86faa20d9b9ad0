// SPDX-License-Identifier: BSD-3-Clause
// The keys of an experiment folder that a simulation has no use for: recordings and what is known about them.
#pragma once

#include <limits>
#include <map>
#include <string>
#include <vector>

#include "common/spatial/transform.h"

namespace hrp {

// A body of known mass that somebody fixed to a link for one recording: a point mass.
struct LoadSpec {
  std::string link;
  double mass = 0.0;                 // [kg]
  Vector3d p_LC = Vector3d::Zero();  // [m] its centre, in the link's frame
};

// A hand or a rope that pulls at a link for a part of one recording.
struct HandPush {
  std::string link;                     // empty: anywhere
  bool known = false;                   // else nobody measured the force: that stretch is left out
  Vector3d force_W = Vector3d::Zero();  // [N] constant, world axes
  Vector3d p_LQ = Vector3d::Zero();     // [m] where it pulls, in the link's frame
  double start = 0.0, end = std::numeric_limits<double>::infinity();  // [s] after the recording's first sample
};

struct RecordingSpec {
  std::string file;                        // absolute
  std::string name;                        // as written
  bool train = true;                       // role train, else validate
  std::vector<std::string> feet_attached;  // links that stand fast (bolted or held)
  std::vector<std::string> unknown_force;  // joints or links pushed by somebody
  std::vector<LoadSpec> loads;
  std::vector<HandPush> pushes;
  int line = 0;
};

struct ExperimentKeys {
  std::vector<RecordingSpec> recordings;
  std::map<std::string, double> noise;              // standard deviations by quantity ("position") or by signal name
  std::map<std::string, std::string> wrench_frame;  // "world" or "link" by sensor
};

// From the text of an experiment file. Throws InputError with file, line, column.
ExperimentKeys parse_experiment_keys(const std::string& text, const std::string& path);

}  // namespace hrp
