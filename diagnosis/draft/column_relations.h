// SPDX-License-Identifier: BSD-3-Clause
// What the numbers of a log's columns say of each other, whatever their names.
#pragma once

#include <cstddef>
#include <vector>

namespace hrp::diagnosis {

// Median step of a column that may hold stamps; 0 when it goes back or mostly stands.
double find_stamp_period(const std::vector<double>& column);

// Of a column of stamps with this period and this first one: the unit of a clock that counts from 1970; else seconds,
// or the coarsest unit in which a period is short enough.
double find_time_scale(double period, double first);

// Of the central differences of a position with a velocity. `time`: of their rows.
double calc_rate_correlation(const std::vector<double>& position, const std::vector<double>& velocity,
                             const std::vector<double>& time);

// The integral of a velocity by the travel of a position, as a slope: speeds that are late hardly change it.
double calc_travel_ratio(const std::vector<double>& position, const std::vector<double>& velocity,
                         const std::vector<double>& time);

// Two columns, the second the rate of the first: rows a second that make it so, if both are in one unit of angle or
// length.
struct RatePair {
  size_t position = 0, velocity = 0;
  double rate = 0.0;  // [1/s]; 0: there is no such pair
};

// The pair that agrees best, of columns without stamps.
RatePair find_rate_pair(const std::vector<std::vector<double>>& columns);

}  // namespace hrp::diagnosis
