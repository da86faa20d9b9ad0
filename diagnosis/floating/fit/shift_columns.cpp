// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/fit/shift_columns.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/floating/log/clip_maker.h"

namespace hrp::diagnosis::floating {
namespace {

// Every row has a sample. A short end is held; a longer one, before the first or after the last reading, is blank:
// nothing was read.
void shift_whole(const std::vector<double>& time, double late, std::vector<double>* column) {
  const std::vector<double> was = *column;
  size_t at = 0;
  for (size_t k = 0; k < was.size(); ++k) {
    const double at_time = time[k] + late, t = std::clamp(at_time, time.front(), time.back());
    while (at + 2 < was.size() && time[at + 1] < t) ++at;
    while (at > 0 && time[at] > t) --at;
    const double share = std::clamp((t - time[at]) / (time[at + 1] - time[at]), 0.0, 1.0);
    const bool beyond = std::abs(at_time - t) > kLongestStep;
    (*column)[k] = beyond ? std::numeric_limits<double>::quiet_NaN() : was[at] + share * (was[at + 1] - was[at]);
  }
}

void shift_sparse(const std::vector<double>& time, double late, std::vector<double>* column) {
  std::vector<double> t, v;
  for (size_t k = 0; k < column->size(); ++k) {
    if (std::isfinite((*column)[k])) {
      t.push_back(time[k] - late);
      v.push_back((*column)[k]);
    }
  }
  for (size_t k = 0; k < column->size(); ++k) {
    const auto next = std::lower_bound(t.begin(), t.end(), time[k]);
    (*column)[k] = std::numeric_limits<double>::quiet_NaN();
    if (next == t.end() || next == t.begin()) continue;
    const auto i = static_cast<size_t>(next - t.begin());
    if (t[i] - t[i - 1] <= kLongestStep)
      (*column)[k] = v[i - 1] + (time[k] - t[i - 1]) / (t[i] - t[i - 1]) * (v[i] - v[i - 1]);
  }
}

}  // namespace

void shift_columns(const std::string& sensor, double late, Recording* r) {
  for (auto& [name, column] : r->other) {
    if (name.rfind(sensor + "/", 0) != 0) continue;
    const bool whole = std::all_of(column.begin(), column.end(), [](double x) { return std::isfinite(x); });
    whole ? shift_whole(r->time, late, &column) : shift_sparse(r->time, late, &column);
  }
}

}  // namespace hrp::diagnosis::floating
