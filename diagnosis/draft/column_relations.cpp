// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/draft/column_relations.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "diagnosis/data/gaps.h"
#include "diagnosis/data/make_recording.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
double find_stamp_period(const std::vector<double>& column) {
  if (!std::is_sorted(column.begin(), column.end())) return 0.0;
  long repeated = 0;
  for (size_t i = 1; i < column.size(); ++i) repeated += column[i] == column[i - 1];
  return repeated > static_cast<long>(column.size() / 2) ? 0.0 : find_period(column);
}

double find_time_scale(double period, double first) {
  // Clocks that count from 1970 tell their unit: 1.7e18 ns, 1.7e15 us, 1.7e12 ms.
  if (first > 1e17) return 1e-9;
  if (first > 1e14) return 1e-6;
  if (first > 1e11) return 1e-3;
  for (const double scale : {1.0, 1e-3, 1e-6, 1e-9}) {
    if (period * scale <= kLongestStep) return scale;  // slower logs are in a finer unit of time
  }
  return 1.0;
}

double calc_rate_correlation(const std::vector<double>& q, const std::vector<double>& v, const std::vector<double>& t) {
  double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, syy = 0.0, sxy = 0.0;
  for (size_t i = 1; i + 1 < q.size(); ++i) {
    const double x = (q[i + 1] - q[i - 1]) / (t[i + 1] - t[i - 1]), y = v[i];
    if (!std::isfinite(x) || !std::isfinite(y)) continue;
    n += 1.0;
    sx += x;
    sy += y;
    sxx += x * x;
    syy += y * y;
    sxy += x * y;
  }
  const double spread = (n * sxx - sx * sx) * (n * syy - sy * sy);
  return spread > 0.0 ? (n * sxy - sx * sy) / std::sqrt(spread) : 0.0;
}

double calc_travel_ratio(const std::vector<double>& q, const std::vector<double>& v, const std::vector<double>& t) {
  double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, integral = 0.0;
  for (size_t i = 1; i < q.size(); ++i) {
    const double step = 0.5 * (v[i] + v[i - 1]) * (t[i] - t[i - 1]), x = q[i] - q[0];
    if (!std::isfinite(step) || !std::isfinite(x)) continue;
    integral += step;
    n += 1.0;
    sx += x;
    sy += integral;
    sxx += x * x;
    sxy += x * integral;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

RatePair find_rate_pair(const std::vector<std::vector<double>>& columns) {
  RatePair best;
  if (columns.empty()) return best;
  std::vector<double> rows(columns[0].size());
  std::iota(rows.begin(), rows.end(), 0.0);
  double most = 1.0 - kTrace;  // correlation with a position's differences: other columns move alike, too
  for (size_t i = 0; i < columns.size(); ++i) {
    for (size_t k = 0; k < columns.size(); ++k) {
      const double alike = i == k ? 0.0 : calc_rate_correlation(columns[i], columns[k], rows);
      if (alike > most) {
        most = alike;
        best = {i, k, calc_travel_ratio(columns[i], columns[k], rows)};
      }
    }
  }
  return best;
}

}  // namespace hrp::diagnosis
