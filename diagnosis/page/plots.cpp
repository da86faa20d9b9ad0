// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/page/plots.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/has.h"
#include "diagnosis/page/text.h"

namespace hrp::diagnosis::html {
namespace {

std::string at(double value) { return format_number(std::round(value * 10) / 10, 6); }  // a tenth of a pixel will do

std::string make_text(double x, double y, const std::string& text, const char* attributes = "") {
  return "<text x='" + at(x) + "' y='" + at(y) + "' " + attributes + ">" + escape(text) + "</text>";
}

std::string make_line(double x1, double y1, double x2, double y2, const char* css) {
  return "<line class='" + std::string(css) + "' x1='" + at(x1) + "' y1='" + at(y1) + "' x2='" + at(x2) + "' y2='" +
         at(y2) + "'/>";
}

std::string open_svg(double width, double height, const std::string& label) {
  return "<svg viewBox='0 0 " + at(width) + " " + at(height) + "' role='img' aria-label='" + escape(label) + "'>";
}

// Round steps that cut [low, high] into at most about `count` parts.
std::vector<double> make_ticks(double low, double high, int count) {
  const double raw = (high - low) / count, unit = std::pow(10.0, std::floor(std::log10(raw)));
  const double step = raw <= unit ? unit : raw <= 2 * unit ? 2 * unit : raw <= 5 * unit ? 5 * unit : 10 * unit;
  std::vector<double> ticks;
  for (double t = std::ceil(low / step) * step; t <= high + 1e-9 * step; t += step)
    ticks.push_back(std::abs(t) < 1e-9 * step ? 0 : t);
  return ticks;
}

struct Frame {
  double left, top, width, height;  // of the plotting area in pixels
  double x0, x1, y0, y1;            // data ranges
  double x(double v) const { return left + (v - x0) / (x1 - x0) * width; }
  double y(double v) const { return top + height - (v - y0) / (y1 - y0) * height; }
};

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void add(double v) {
    if (std::isfinite(v)) {
      low = std::min(low, v);
      high = std::max(high, v);
    }
  }
  bool empty() const { return !(low <= high); }
  void pad() {
    const double gap = high > low ? 0.06 * (high - low) : std::max(1e-9, std::abs(high) * 0.1);
    low -= gap;
    high += gap;
  }
};

std::string make_axes(const Frame& f, const std::string& x_label, const std::string& y_label) {
  std::string out;
  for (double t : make_ticks(f.x0, f.x1, 8)) {
    out += make_line(f.x(t), f.top, f.x(t), f.top + f.height, "grid");
    out += make_text(f.x(t), f.top + f.height + 14, format_number(t), "text-anchor='middle'");
  }
  for (double t : make_ticks(f.y0, f.y1, 5)) {
    out += make_line(f.left, f.y(t), f.left + f.width, f.y(t), "grid");
    out += make_text(f.left - 5, f.y(t) + 4, format_number(t), "text-anchor='end'");
  }
  out += make_text(f.left + f.width / 2, f.top + f.height + 30, x_label, "text-anchor='middle'");
  return out + make_text(f.left, f.top - 6, y_label);
}

std::string make_path(const Frame& f, const std::vector<double>& x, const std::vector<double>& y, const char* css) {
  std::string d;
  bool pen = false;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) {
      pen = false;
      continue;
    }
    d += (pen ? "L" : "M") + at(f.x(x[i])) + " " + at(f.y(y[i]));
    pen = true;
  }
  return d.empty() ? "" : "<path class='" + std::string(css) + "' d='" + d + "'/>";
}

std::string find_name(const json& signals, const json& index, std::string* unit) {
  if (!index.is_number_integer() || !signals.is_array()) return "";
  const auto i = index.get<std::int64_t>();
  if (i < 0 || i >= static_cast<std::int64_t>(signals.size())) return "";
  const json& signal = signals[static_cast<std::size_t>(i)];
  if (unit) *unit = get_text(signal, "unit");
  return get_text(signal, "name");
}

// 0 at the noise floor, 1 at a hundred times it.
double calc_level(double rms) { return std::clamp(std::log10(std::max(rms, 1e-9)) / 2, 0.0, 1.0); }

struct MapRow {
  std::string name;
  std::vector<double> values;
  double worst = 0;  // before, so that both maps list the same signals in the same order
};

std::vector<MapRow> find_rows(const json& map, const json& signals, const char* which) {
  std::vector<MapRow> rows;
  for (const json& row : get_list(map, "rows")) {
    MapRow r{find_name(signals, get(row, "signal"), nullptr), get_numbers(row, which), 0};
    for (double v : get_numbers(row, "before")) r.worst = std::max(r.worst, std::isfinite(v) ? v : 0);
    if (!r.name.empty() && !r.values.empty()) rows.push_back(std::move(r));
  }
  std::stable_sort(rows.begin(), rows.end(), [](const MapRow& a, const MapRow& b) { return a.worst > b.worst; });
  constexpr std::size_t kRows = 24;  // more cannot be read on a laptop; the worst stay
  if (rows.size() > kRows) rows.resize(kRows);
  return rows;
}

// One strip for each kind of mark; times outside the map are cut.
std::string make_marks(const json& marks, const Frame& f, double* top) {
  std::vector<std::string> kinds;
  for (const json& mark : marks) {
    const std::string kind = get_text(mark, "kind");
    if (!kind.empty() && !has(kinds, kind)) kinds.push_back(kind);
  }
  std::sort(kinds.begin(), kinds.end());
  std::string out;
  for (const std::string& kind : kinds) {
    out += make_text(f.left - 6, *top + 8, kind, "text-anchor='end' class='kind'");
    for (const json& mark : marks) {
      if (get_text(mark, "kind") != kind) continue;
      const double from = std::max(f.x0, get_number(mark, "from", f.x0)),
                   to = std::min(f.x1, get_number(mark, "to", from));
      if (!(to >= from)) continue;
      const std::string where = get_text(mark, "where");
      out += "<rect class='mark' x='" + at(f.x(from)) + "' y='" + at(*top) + "' height='9' width='" +
             at(std::max(1.2, f.x(to) - f.x(from))) + "'><title>" + escape(kind + (where.empty() ? "" : ", " + where)) +
             " " + format_number(from) + " to " + format_number(to) + " s</title></rect>";
    }
    *top += 12;
  }
  return out;
}

// Shade of one cell: -1 nothing recorded, 0 about the noise floor (drawn as nothing), up to 9.
int find_shade(double rms) {
  if (!std::isfinite(rms)) return -1;
  constexpr double kFloor = 1.3;  // bins hold few samples: their rms scatters about 1
  return rms < kFloor ? 0 : static_cast<int>(std::ceil(calc_level(rms) * 9));
}

std::string make_cells(const MapRow& row, const Frame& f, double y, double height, double step) {
  std::string out;
  for (std::size_t b = 0, end; b < row.values.size(); b = end) {
    const int shade = find_shade(row.values[b]);
    for (end = b + 1; end < row.values.size() && find_shade(row.values[end]) == shade;)
      ++end;  // equal neighbours: one cell
    if (shade == 0) continue;
    const double from = f.x(f.x0 + static_cast<double>(b) * step), to = f.x(f.x0 + static_cast<double>(end) * step);
    out += "<rect class='" + (shade < 0 ? std::string("gap") : "heat h" + std::to_string(shade)) + "' x='" + at(from) +
           "' y='" + at(y) + "' width='" + at(to - from + 0.3) + "' height='" + at(height) + "'/>";
  }
  return out;
}

}  // namespace

std::string make_map_svg(const json& recording, const json& signals, const char* which) {
  const json& map = get(recording, "map");
  const std::vector<MapRow> rows = find_rows(map, signals, which);
  if (rows.empty()) return "";
  const double start = get_number(map, "start", 0), step = std::max(1e-6, get_number(map, "step", 0.1));
  std::size_t bins = 1;
  for (const MapRow& row : rows) bins = std::max(bins, row.values.size());
  Frame f{290, 8, 640, 0, start, start + step * static_cast<double>(bins), 0, 1};
  double y = f.top;
  std::string body = make_marks(get_list(recording, "marks"), f, &y);
  y += 3;
  const double first = y, pitch = rows.size() > 14 ? 13 : 16;
  for (const MapRow& row : rows) {
    body += make_text(f.left - 6, y + pitch - 4, row.name, "text-anchor='end'");
    body += make_cells(row, f, y, pitch - 1.5, step);
    y += pitch;
  }
  f.top = first;
  f.height = y - first;
  for (double t : make_ticks(f.x0, f.x1, 10)) {
    body += make_line(f.x(t), first, f.x(t), y, "grid") +
            make_text(f.x(t), y + 14, format_number(t), "text-anchor='middle'");
  }
  body += make_text(f.left + f.width / 2, y + 30, "time [s]", "text-anchor='middle'");
  const std::string label = "Residual by signal and time, " + std::string(which) + ", " + get_text(recording, "file") +
                            "; worst signal " + rows[0].name + " at " + format_number(rows[0].worst, 3) +
                            " times its noise";
  return open_svg(940, y + 36, label) + body + "</svg>";
}

namespace {

// Recorded minus predicted, sample by sample; not a number where one of them is missing.
std::vector<double> find_difference(const json& trace, const char* predicted) {
  std::vector<double> out = get_numbers(trace, "recorded");
  const std::vector<double> other = get_numbers(trace, predicted);
  out.resize(std::min(out.size(), other.size()));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] -= other[i];
  return out;
}

// Below the curves what is left between them, on a scale of its own: a good prediction hides its error otherwise.
std::string make_difference(const json& trace, const std::vector<double>& time) {
  const std::vector<double> recorded = get_numbers(trace, "recorded");
  // Traces of equations show what is left already: nothing was recorded of them.
  if (std::all_of(recorded.begin(), recorded.end(), [](double v) { return v == 0.0; })) return "";
  const std::vector<double> before = find_difference(trace, "before"), after = find_difference(trace, "after");
  Range range;
  for (const auto* values : {&before, &after}) {
    for (double v : *values) range.add(v);
  }
  if (range.empty()) return "";
  range.pad();
  const Frame f{64, 218, 400, 72, time.front(), time.back(), range.low, range.high};
  return make_axes(f, "time [s]", "recorded minus predicted") + make_path(f, time, before, "curve before") +
         make_path(f, time, after, "curve after");
}

}  // namespace

std::string make_trace_svg(const json& trace, const json& signals) {
  std::string unit;
  const std::string name = find_name(signals, get(trace, "signal"), &unit);
  const std::vector<double> time = get_numbers(trace, "time");
  if (name.empty() || time.size() < 2 || !(time.back() > time.front())) return "";
  Range range;
  for (const char* key : {"recorded", "before", "after"}) {
    for (double v : get_numbers(trace, key)) range.add(v);
  }
  if (range.empty()) return "";
  range.pad();
  const std::string difference = make_difference(trace, time);
  const Frame f{64, 24, 400, 150, time.front(), time.back(), range.low, range.high};
  std::string out = open_svg(480, difference.empty() ? 212 : 328, name + ": recorded, before and after") +
                    make_axes(f, difference.empty() ? "time [s]" : "", name + (unit.empty() ? "" : " [" + unit + "]"));
  out += make_path(f, time, get_numbers(trace, "before"), "curve before");
  out += make_path(f, time, get_numbers(trace, "recorded"), "curve recorded");
  return out + make_path(f, time, get_numbers(trace, "after"), "curve after") + difference + "</svg>";
}

std::string make_cloud_svg(const json& cloud) {
  Range x, y;
  for (const char* key : {"before", "after", "curve"}) {
    for (const json& p : get_list(cloud, key)) {
      if (p.is_array() && p.size() == 2 && p[0].is_number() && p[1].is_number()) {
        x.add(p[0].get<double>());
        y.add(p[1].get<double>());
      }
    }
  }
  if (x.empty()) return "";
  x.pad();
  y.pad();
  const Frame f{64, 24, 400, 190, x.low, x.high, y.low, y.high};
  std::string out =
      open_svg(480, 252, get_text(cloud, "title")) + make_axes(f, get_text(cloud, "x"), get_text(cloud, "y"));
  std::vector<double> cx, cy;
  for (const char* key : {"before", "after", "curve"}) {
    for (const json& p : get_list(cloud, key)) {
      if (!p.is_array() || p.size() != 2 || !p[0].is_number() || !p[1].is_number()) continue;
      const double px = p[0].get<double>(), py = p[1].get<double>();
      if (key[0] == 'c') {
        cx.push_back(px);
        cy.push_back(py);
      } else {
        out +=
            "<circle class='dot " + std::string(key) + "' cx='" + at(f.x(px)) + "' cy='" + at(f.y(py)) + "' r='1.6'/>";
      }
    }
  }
  return out + make_path(f, cx, cy, "curve law") + "</svg>";
}

std::string make_fit_svg(double before, double after, const std::string& label) {
  const double top = std::max({10.0, before, after}) * 1.3, low = 0.5;
  auto x = [&](double v) { return 150 + 420 * std::log(std::max(v, low) / low) / std::log(top / low); };
  std::string out = open_svg(
      640, 92,
      label + ": " + format_number(before, 3) + " before, " + format_number(after, 3) + " after; 1 is the noise floor");
  for (double v : {1.0, 10.0, 100.0, 1000.0, 1e4}) {
    if (v < top)
      out += make_line(x(v), 6, x(v), 66, v == 1 ? "floor" : "grid") +
             make_text(x(v), 80, v == 1 ? "noise floor" : format_number(v), "text-anchor='middle'");
  }
  const char* css[] = {"bar before", "bar after"};
  const char* words[] = {"before", "after"};
  const double values[] = {before, after};
  for (int i = 0; i < 2; ++i) {
    out += make_text(140, 24 + 26 * i, words[i], "text-anchor='end'");
    if (!std::isfinite(values[i])) continue;
    out += "<rect class='" + std::string(css[i]) + "' x='150' y='" + at(11 + 26 * i) + "' height='18' width='" +
           at(std::max(1.0, x(values[i]) - 150)) + "'/>";
    out += make_text(x(values[i]) + 6, 25 + 26 * i, format_number(values[i], 3), "class='strong'");
  }
  return out + "</svg>";
}

std::string make_interval_svg(double value, double low, double high) {
  if (!std::isfinite(value) || !(low <= high)) return "";
  Range r;
  for (double v : {0.0, value, low, high}) r.add(v);
  r.pad();
  const Frame f{4, 0, 152, 16, r.low, r.high, 0, 1};
  return open_svg(160, 16, "interval from " + format_number(low) + " to " + format_number(high)) +
         make_line(f.x(0), 2, f.x(0), 14, "grid") + make_line(f.x(low), 8, f.x(high), 8, "span") +
         "<circle class='value' cx='" + at(f.x(value)) + "' cy='8' r='3.5'/></svg>";
}

}  // namespace hrp::diagnosis::html
