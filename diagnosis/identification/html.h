// SPDX-License-Identifier: BSD-3-Clause
// Pieces of the report.
#pragma once

#include <string>

#include "diagnosis/identification/identify.h"

namespace hrp::identification {

std::string print(const char* format, ...);
std::string escape(const std::string& text);
// Value, standard deviation, relative standard deviation, and the error where the truth is known.
std::string make_cell(const Estimate& e, const double* truth);
// Inertial and joint parameters [M14 eq. 2, 3].
std::string make_body_section(const Identification& r);
std::string make_body_text(const Identification& r);

}  // namespace hrp::identification
