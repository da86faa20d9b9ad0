// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/diagnosis/legged/late_columns.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/floating/diagnose.h"

namespace hrp::diagnosis::floating {

void delay_columns(const std::string& begin, long samples, Experiment* e) {
  for (Recording& r : e->recordings) {
    for (auto& [name, column] : r.other) {
      if (name.rfind(begin, 0) != 0) continue;
      std::rotate(column.begin(), column.end() - samples, column.end());
      std::fill(column.begin(), column.begin() + samples, column[static_cast<size_t>(samples)]);
    }
  }
}

void expect_delay_alone(const Experiment& e, const char* sensor, long samples) {
  const Evidence found = diagnose_legged(e, nullptr).evidence;
  ASSERT_EQ(found.findings.size(), 1u);
  const Finding& f = found.findings[0];
  EXPECT_EQ(f.effect, "sensor_delay");
  EXPECT_EQ(f.where.at("sensor"), sensor);
  const double delay = 0.004 * static_cast<double>(samples);   // [s]
  EXPECT_NEAR(f.parameters[0].value[0], delay, 0.05 * delay);  // of first order in the delay
}

}  // namespace hrp::diagnosis::floating
