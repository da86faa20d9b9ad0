// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "diagnosis/report/report.h"

namespace hrp::diagnosis {

// DIR/report.json and DIR/report.html of an answer that is refined later; no scenario yet.
void write_first_report(const std::string& folder, const Reports& reports);

}  // namespace hrp::diagnosis
