// SPDX-License-Identifier: BSD-3-Clause
// A log as its sensors would have told it without the faults that a fit names. Columns of late, scaled or turned
// sensors are first order in the fault; written anew about the values that were found, they hold to the second
// (Gauss-Newton).
#pragma once

#include "diagnosis/floating/fit/columns.h"

namespace hrp::diagnosis::floating {

// Whether a column's quantity can be taken out of a log: of force sensors, IMUs, lags and delays of drives.
bool is_correctable(const ColumnLayout& layout, int column);

// Takes coefficients by column (zero: none) out of a log. Of a force sensor, gyroscope or accelerometer
//   reading(t) = R(turn)^T (scale true(t - delay) + bias).
void correct_log(const ColumnLayout& layout, const Eigen::VectorXd& by_column, LeggedLog* log);

// Gives the links of a log's robot the masses, centres and inertias that coefficients by column add. A link that would
// have no mass stays as it is.
void correct_links(const ColumnLayout& layout, const Eigen::VectorXd& by_column, LeggedLog* log);

// A first-order lag by `time` [s] of a track on an even grid: time dy/dt = x - y, at rest before it begins.
Track lag_track(const Track& x, double step, double time);

// A track as it is `ahead` [s] later: y(t) = x(t + ahead). Its ends are held.
Track shift_track(const Track& x, double step, double ahead);

}  // namespace hrp::diagnosis::floating
