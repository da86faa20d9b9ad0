// SPDX-License-Identifier: BSD-3-Clause
// What accelerometers read while the robot stands, against gravity and against the base's recorded pose; and how far
// gyroscopes agree with encoders and attitudes.
#pragma once

#include "diagnosis/floating/checks/checks.h"

namespace hrp::diagnosis::floating {

void check_imus(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels,
                const ColumnLayout& layout, CheckResult* out);

}  // namespace hrp::diagnosis::floating
