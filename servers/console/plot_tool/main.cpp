// SPDX-License-Identifier: BSD-3-Clause
// hrp-plot DATA.csv --out PICTURE.svg: columns against the first one.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/base/command_line.h"
#include "common/base/split_cells.h"
#include "common/base/version.h"
#include "common/plot/svg_plot.h"

namespace {

// An empty cell leaves a gap.
void read(const std::string& path, hrp::Plot* plot) {
  std::ifstream file(path);
  std::string line;
  if (!file || !std::getline(file, line)) throw std::runtime_error(path + ": cannot be read");
  const std::vector<std::string> names = hrp::split_cells(line);
  for (size_t i = 1; i < names.size(); ++i) plot->series.push_back({names[i], {}, {}});
  for (int number = 2; std::getline(file, line); ++number) {
    const std::vector<std::string> cells = hrp::split_cells(line);
    try {
      for (size_t i = 1; i < cells.size() && i < names.size(); ++i) {
        plot->series[i - 1].x.push_back(std::stod(cells[0]));
        plot->series[i - 1].y.push_back(cells[i].empty() ? std::nan("") : std::stod(cells[i]));
      }
    } catch (const std::exception&) {
      throw std::runtime_error(path + ":" + std::to_string(number) + ": not a number");
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Draws the columns of a CSV file against its first column.", "hrp-plot");
  app.set_version_flag("--version", hrp::get_version_text("hrp-plot"));
  hrp::Plot plot;
  std::string data, out;
  app.add_option("data", data, "CSV file with a header")->required();
  app.add_option("--out", out, "SVG file")->required();
  app.add_option("--title", plot.title, "title of the plot");
  app.add_option("--x", plot.x_label, "label of the x axis, with unit");
  app.add_option("--y", plot.y_label, "label of the y axis, with unit");
  if (const auto status = hrp::take_command_line(&app, argc, argv)) return *status;
  try {
    read(data, &plot);
    hrp::write_svg(plot, out);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hrp-plot: %s\n", error.what());
    return 2;
  }
  return 0;
}
