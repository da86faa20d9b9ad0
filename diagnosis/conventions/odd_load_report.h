// SPDX-License-Identifier: BSD-3-Clause
// What a report says of a load in one recording only (conventions/odd_load.h).
#pragma once

#include "diagnosis/conventions/odd_load.h"
#include "diagnosis/report/first.h"

namespace hrp::diagnosis {

// Adds a finding with `only_in`, the file, and a warning. The load is no part of the model of the machine.
void add_odd_load(const Experiment& experiment, const OddLoad& load, Reports* reports);

}  // namespace hrp::diagnosis
