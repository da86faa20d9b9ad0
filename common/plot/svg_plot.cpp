// SPDX-License-Identifier: BSD-3-Clause
#include "common/plot/svg_plot.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/escape_xml.h"
#include "common/base/format.h"
#include "common/base/write_file.h"

namespace hrp {
namespace {

constexpr double kWidth = 900, kHeight = 420, kLeft = 80, kRight = 20, kTop = 40, kBottom = 55, kLegendLine = 20;
// The palette of Okabe and Ito: told apart by everybody, and dark enough on white, light enough on black.
constexpr std::array<const char*, 7> kColours{"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                              "#E69F00", "#56B4E9", "#8C6D31"};

struct Range {
  double low = 0, high = 0;
  bool empty = true;
  void add(double value) {
    if (!std::isfinite(value)) return;
    low = empty ? value : std::min(low, value);
    high = empty ? value : std::max(high, value);
    empty = false;
  }
};

struct Axis {
  double low = 0, high = 1, step = 0.2;  // the step between ticks
  double pixel_low = 0, pixel_high = 1;
  double map(double value) const { return pixel_low + (value - low) / (high - low) * (pixel_high - pixel_low); }
};

// Ticks at 1, 2 or 5 times a power of ten, about six of them.
double find_tick_step(double span) {
  const double raw = span / 6, power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= raw) return factor * power;
  }
  return 10 * power;
}

// `round` widens the range to whole ticks.
Axis make_axis(Range range, bool round, double pixel_low, double pixel_high) {
  if (range.empty) range.add(0);
  if (range.high - range.low < 1e-9 * std::max(1.0, std::abs(range.high))) {
    const double margin = std::max(1.0, std::abs(range.high)) * 0.1;  // a constant in the middle of the picture
    range.low -= margin;
    range.high += margin;
  }
  Axis axis{range.low, range.high, find_tick_step(range.high - range.low), pixel_low, pixel_high};
  if (round) {
    axis.low = std::floor(axis.low / axis.step) * axis.step;
    axis.high = std::ceil(axis.high / axis.step) * axis.step;
  }
  return axis;
}

std::string print_tick(double value, double step) {
  return std::abs(value) < 1e-9 * step ? "0" : format("%.10g", std::round(value / step) * step);
}

std::string draw_axes(const Plot& plot, const Axis& x, const Axis& y) {
  std::string svg;
  for (double tick = std::ceil(x.low / x.step) * x.step; tick <= x.high + 1e-9 * x.step; tick += x.step) {
    svg += format("<line class=\"grid\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>", x.map(tick), y.pixel_low,
                  x.map(tick), y.pixel_high);
    svg += format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%s</text>\n", x.map(tick), y.pixel_low + 18,
                  print_tick(tick, x.step).c_str());
  }
  for (double tick = std::ceil(y.low / y.step) * y.step; tick <= y.high + 1e-9 * y.step; tick += y.step) {
    svg += format("<line class=\"grid\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>", x.pixel_low, y.map(tick),
                  x.pixel_high, y.map(tick));
    svg += format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%s</text>\n", x.pixel_low - 8, y.map(tick) + 4,
                  print_tick(tick, y.step).c_str());
  }
  const double middle = (y.pixel_low + y.pixel_high) / 2;
  svg += format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", (x.pixel_low + x.pixel_high) / 2,
                y.pixel_low + 42) +
         escape_xml(plot.x_label) + "</text>\n";
  svg += format("<text x=\"18\" y=\"%.1f\" text-anchor=\"middle\" transform=\"rotate(-90 18 %.1f)\">", middle, middle) +
         escape_xml(plot.y_label) + "</text>\n";
  svg += format("<text x=\"%.1f\" y=\"24\" class=\"title\">", kLeft) + escape_xml(plot.title) + "</text>\n";
  return svg;
}

// Joins the points of one series that fall into one column of pixels: first, smallest, largest, last.
class PathPen {
 public:
  void add(double px, double py) {
    if (open_ && std::floor(px) == std::floor(column_)) {
      low_ = std::min(low_, py);
      high_ = std::max(high_, py);
      last_ = py;
      return;
    }
    end_column();
    column_ = px;
    low_ = high_ = last_ = py;
    path_ += format(broken_ ? "M%.1f %.1f" : "L%.1f %.1f", px, py);
    broken_ = false;
    open_ = true;
  }
  void break_line() {
    end_column();
    broken_ = true;
  }
  std::string finish() {
    end_column();
    return path_;
  }

 private:
  void end_column() {
    if (open_ && low_ != high_) {
      path_ += format("L%.1f %.1fL%.1f %.1fL%.1f %.1f", column_, low_, column_, high_, column_, last_);
    }
    open_ = false;
  }
  std::string path_;
  bool open_ = false, broken_ = true;
  double column_ = 0, low_ = 0, high_ = 0, last_ = 0;
};

std::string draw_series(const PlotSeries& series, const Axis& x, const Axis& y, const char* colour) {
  PathPen pen;
  for (size_t i = 0; i < series.x.size() && i < series.y.size(); ++i) {
    if (std::isfinite(series.x[i]) && std::isfinite(series.y[i])) {
      pen.add(x.map(series.x[i]), y.map(series.y[i]));
    } else {
      pen.break_line();
    }
  }
  return format("<path fill=\"none\" stroke=\"%s\" stroke-width=\"1.5\" d=\"", colour) + pen.finish() + "\"/>\n";
}

}  // namespace

std::string make_svg(const Plot& plot) {
  Range x_range, y_range;
  for (const PlotSeries& series : plot.series) {
    for (const double value : series.x) x_range.add(value);
    for (const double value : series.y) y_range.add(value);
  }
  const double legend = kLegendLine * static_cast<double>(plot.series.size());
  const double height = kHeight + legend;
  const Axis x = make_axis(x_range, false, kLeft, kWidth - kRight);
  const Axis y = make_axis(y_range, true, kHeight - kBottom, kTop);
  std::string svg = format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" width=\"%.0f\" "
      "height=\"%.0f\" font-family=\"sans-serif\" font-size=\"13\">\n",
      kWidth, height, kWidth, height);
  svg +=
      "<style>text{fill:#333}.title{font-weight:bold;font-size:15px}.grid{stroke:#999;stroke-width:.5;opacity:.5}"
      ".page{fill:#fff}@media(prefers-color-scheme:dark){text{fill:#ddd}.page{fill:#181818}}</style>\n"
      "<rect class=\"page\" width=\"100%\" height=\"100%\"/>\n";
  svg += draw_axes(plot, x, y);
  for (size_t i = 0; i < plot.series.size(); ++i) {
    const char* colour = kColours[i % kColours.size()];
    const double line = kHeight + kLegendLine * static_cast<double>(i);
    svg += draw_series(plot.series[i], x, y, colour);
    svg += format("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" stroke=\"%s\" stroke-width=\"3\"/>", kLeft,
                  line, kLeft + 24, line, colour);
    svg +=
        format("<text x=\"%.1f\" y=\"%.1f\">", kLeft + 32, line + 4) + escape_xml(plot.series[i].label) + "</text>\n";
  }
  return svg + "</svg>\n";
}

void write_svg(const Plot& plot, const std::string& path) { write_file(path, make_svg(plot)); }

}  // namespace hrp
