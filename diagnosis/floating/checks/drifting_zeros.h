// SPDX-License-Identifier: BSD-3-Clause
// Zeros of foot force sensors that drift from recording to recording, or while one or two long ones last, as those of
// strain gauges do while they warm up. No constant fault and no mass goes on with time, whatever the robot does; so the
// equations of the whole body tell a drift before anything is fitted.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "diagnosis/data/recording.h"
#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis::floating {

struct ZeroDrift {
  // By column of a sensor, by recording, by equal stretch of it: its zero [N], [N m], less the mean over all of them,
  // which is a constant zero that other equations tell.
  std::map<std::string, std::vector<std::vector<double>>> zero;
  std::vector<Finding> findings;  // empty: zeros are constant
  bool found() const { return !findings.empty(); }
};

ZeroDrift find_zero_drift(const Experiment& experiment);

// The recordings as they would read without it.
Experiment take_out(const ZeroDrift& drift, Experiment experiment);

}  // namespace hrp::diagnosis::floating
