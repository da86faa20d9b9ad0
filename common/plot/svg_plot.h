// SPDX-License-Identifier: BSD-3-Clause
// Line plots as SVG text that reads well on light and on dark pages.
#pragma once

#include <string>
#include <vector>

namespace hrp {

struct PlotSeries {
  std::string label;
  std::vector<double> x, y;  // equally long; a y that is not finite leaves a gap
};

struct Plot {
  std::string title;
  std::string x_label;  // with unit: "time [s]"
  std::string y_label;
  std::vector<PlotSeries> series;
};

// A long series is thinned to the smallest and the largest value within each column of the picture: peaks stay.
std::string make_svg(const Plot& plot);
// Throws std::runtime_error naming the file when it cannot be written.
void write_svg(const Plot& plot, const std::string& path);

// The vertical force on each foot of the scenario against time, from a log of ours. Throws mcap::McapError for a file
// that is no log, std::runtime_error for a log without what is needed or an output that cannot be written.
void write_contact_force_plot(const std::string& log_path, const std::string& svg_path);

}  // namespace hrp
