// SPDX-License-Identifier: BSD-3-Clause
// Pieces of the report.
#pragma once

#include <string>

#include "common/base/escape_xml.h"
#include "common/base/format.h"
#include "diagnosis/identification/identify.h"

namespace hrp::identification {

// Value, standard deviation, relative standard deviation, and the error where the truth is known.
std::string make_cell(const Estimate& e, const double* truth);
// What a simulated scenario says of a joint: the sum of this parameter over its laws of this effect.
double sum_laws(const Scenario& scenario, const std::string& joint, const char* effect, const char* parameter);

// Which feet stand during a motion, in words.
std::string describe_support(const Identification& r, const MotionTrack& track);
bool is_fitted(const Identification& r, const MotionTrack& track);

// report_tables.cpp: motions; model selection; tables 1, 2 and 3 of [M14]; vertical.
std::string make_tables(const Identification& r);
// report_figures.cpp: figures 4 and 7 to 13 of [M14].
std::string make_figures(const Identification& r);
// body_report.cpp: inertial and joint parameters [M14 eq. 2, 3].
std::string make_body_section(const Identification& r);
std::string make_body_text(const Identification& r);

}  // namespace hrp::identification
