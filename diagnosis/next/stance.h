// SPDX-License-Identifier: BSD-3-Clause
// Proposes the next experiment for a robot on its feet: sways, leans and squats that keep the zero-moment point inside
// the soles under every explanation.
#pragma once

#include "diagnosis/next/propose.h"

namespace hrp::diagnosis {

Next propose_stance(const Experiment& experiment, const Json& report, const NextOptions& options,
                    const Progress& progress);

}  // namespace hrp::diagnosis
