// SPDX-License-Identifier: BSD-3-Clause
// Inline SVG plots of the HTML report. Colours come from CSS classes of the page, so that light and dark both work.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace hrp::diagnosis::html {

// Residual of each signal over time for one recording ("before" or "after"), with the marks above it.
std::string make_map_svg(const nlohmann::json& recording, const nlohmann::json& signals, const char* which);

// Recorded against predicted, before and after.
std::string make_trace_svg(const nlohmann::json& trace, const nlohmann::json& signals);

// What is missing against one variable: scatter before and after, and the law that was found.
std::string make_cloud_svg(const nlohmann::json& cloud);

// Two bars on a logarithmic scale with the noise floor and the 1.2-fold of it.
std::string make_fit_svg(double before, double after, const std::string& label);

// A dot with its interval, on a scale of its own from 0.
std::string make_interval_svg(double value, double low, double high);

}  // namespace hrp::diagnosis::html
