// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "diagnosis/page/text.h"

namespace hrp::diagnosis::html {

// Recordings, motion and what it tells, remarks (`checks` of report.json); empty where there are none.
std::string make_checks_section(const json& report);

// What each recording alone asks for, by finding (`per_recording` of report.json): a dot and an interval a recording.
std::string make_per_recording(const json& report);

// Of long recordings: what was found on stretches, judged on all of them (`on_all` of report.json).
std::string make_on_all(const json& report);

// What each finding takes away of the whole mismatch, as a falling staircase.
std::string make_waterfall(const json& report);

}  // namespace hrp::diagnosis::html
