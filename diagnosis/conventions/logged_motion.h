// SPDX-License-Identifier: BSD-3-Clause
// Whether the columns of joints mean another motion: what friction and rotors leave of the efforts under each reading.
#pragma once

#include <functional>
#include <optional>

#include "diagnosis/measurement/motion_rows.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// Samples of a log, for all readings of it.
struct LoggedMotion {
  Plant plant;  // nominal
  SampledMotion rows;
  double left = 0.0;   // of the squares of all efforts, as logged
  double share = 0.0;  // the same over the squares; 0 if the samples tell nothing
};

// Training recordings without loads or forces by hand. Nothing is told where sensors sit behind the gears.
LoggedMotion sample_motion(const TorqueData& data);

// The reading of `count` others that leaves least, if that is no more than a detail of what is left as logged.
// `calc_left` gives the squares that are left under one of them.
std::optional<size_t> find_reading(const LoggedMotion& motion, size_t count,
                                   const std::function<double(size_t)>& calc_left);

}  // namespace hrp::diagnosis
