// SPDX-License-Identifier: BSD-3-Clause
// The report's figures, in the form of those of [M14].
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/plot/svg_plot.h"
#include "diagnosis/identification/html.h"

namespace hrp::identification {
namespace {

using Point = Eigen::Vector2d;
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr double kPixels = 900.0, kMargin = 12.0;  // a metre; around the picture
constexpr double kLeastTime = 1.0;                 // [s] of standing, to draw a foot's torque

// Values where the foot stands, gaps elsewhere.
std::vector<double> list_standing(const Eigen::VectorXd& values, const Mask& stands) {
  std::vector<double> list(values.data(), values.data() + values.size());
  for (size_t k = 0; k < list.size(); ++k) {
    if (!stands[static_cast<Eigen::Index>(k)]) list[k] = kNothing;
  }
  return list;
}

std::vector<double> to_list(const Eigen::VectorXd& v) { return {v.data(), v.data() + v.size()}; }

// Convex hull, anticlockwise (Andrew's monotone chain).
std::vector<Point> make_hull(std::vector<Point> points) {
  const auto less = [](const Point& a, const Point& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); };
  std::sort(points.begin(), points.end(), less);
  std::vector<Point> hull;
  const auto add = [&](const Point& p, size_t start) {
    const auto turns_right = [&](const Point& a, const Point& b) {
      return (b - a).x() * (p - a).y() - (b - a).y() * (p - a).x() <= 0.0;
    };
    while (hull.size() >= start + 2 && turns_right(hull[hull.size() - 2], hull.back())) hull.pop_back();
    hull.push_back(p);
  };
  for (const Point& p : points) add(p, 0);
  const size_t lower = hull.size() - 1;
  for (auto p = points.rbegin(); p != points.rend(); ++p) add(*p, lower);
  hull.pop_back();
  return hull;
}

// x forward is up, y left is left.
struct Picture {
  explicit Picture(const Eigen::AlignedBox2d& box_in) : box(box_in) {}
  std::string at(const Point& p) const {
    return format("%.1f,%.1f ", kMargin + kPixels * (box.max().y() - p.y()),
                  kMargin + kPixels * (box.max().x() - p.x()));
  }
  void add_shape(const std::vector<Point>& corners, const char* style) {
    svg += "<polygon points=\"";
    for (const Point& p : corners) svg += at(p);
    svg += format("\" %s/>", style);
  }
  std::string finish() const {
    const Point size = kPixels * box.sizes() + Point::Constant(2.0 * kMargin);
    return format("<svg width=\"%.0f\" height=\"%.0f\" role=\"img\" aria-label=\"centre of pressure\">", size.y(),
                  size.x()) +
           svg + "</svg>";
  }
  Eigen::AlignedBox2d box;
  std::string svg;
};

std::vector<Point> make_corners(const Eigen::AlignedBox2d& sole, const Vector3d& place) {
  const Eigen::Rotation2Dd turn(place.z());
  std::vector<Point> corners;
  for (const Point& p :
       {sole.min(), Point(sole.max().x(), sole.min().y()), sole.max(), Point(sole.min().x(), sole.max().y())})
    corners.push_back(place.head<2>() + turn * p);
  return corners;
}

// Figure 4: centre of pressure of all feet that stand, in their support polygon.
std::string make_zmp(const MotionTrack& track, const std::vector<FootFrame>& feet) {
  if (feet.size() != 2 || feet[0].sole.isEmpty() || feet[1].sole.isEmpty()) return "";
  const Vector3d places[2] = {Vector3d::Zero(), track.second_sole};
  std::vector<Point> support, corners[2];
  Eigen::AlignedBox2d box;
  const double time = track.period * static_cast<double>(track.time.size());
  for (size_t f = 0; f < 2; ++f) {
    corners[f] = make_corners(feet[f].sole, places[f]);
    for (const Point& p : corners[f]) box.extend(p);
    if (track.calc_standing_time(f) > 0.5 * time) support.insert(support.end(), corners[f].begin(), corners[f].end());
  }
  Picture picture(box);
  if (!support.empty()) picture.add_shape(make_hull(support), "fill=\"#e8f0e8\" stroke=\"#4a4\" stroke-width=\"1.5\"");
  for (size_t f = 0; f < 2; ++f) picture.add_shape(corners[f], "fill=\"none\" stroke=\"#888\" stroke-width=\"1\"");
  const Mask any = track.stands[0] || track.stands[1];
  for (const auto& [first, end] : find_stretches(any)) {
    picture.svg += "<polyline fill=\"none\" stroke=\"#0072B2\" stroke-width=\"0.8\" points=\"";
    for (Eigen::Index k = first; k < end; k += 2) {
      Point sum = Point::Zero();
      double load = 0.0;
      for (size_t f = 0; f < 2; ++f) {
        const double share = std::max(0.0, track.feet[f].load[k]);
        sum += share * (places[f].head<2>() + Eigen::Rotation2Dd(places[f].z()) * Point(track.feet[f].zmp.col(k)));
        load += share;
      }
      if (load > kAirborne) picture.svg += picture.at(sum / load);
    }
    picture.svg += "\"/>";
  }
  return "<figure>" + picture.finish() +
         "<figcaption>Figure 4: centre of pressure in the support polygon, toes up; outlines are soles, grey alone "
         "that "
         "of a foot in the air</figcaption></figure>";
}

// Roll and pitch apart, as the paper has them.
std::string make_angles(const Identification& r, const MotionTrack& track) {
  std::string html;
  for (int a = 0; a < kAxes; ++a) {
    Plot plot{
        std::string("Figures 7 and 8: angles of the bushes about ") + kAxisNames[a], "time [s]", "angle [mrad]", {}};
    for (size_t f = 0; f < track.feet.size(); ++f) {
      if (track.calc_standing_time(f) < kLeastTime) continue;
      plot.series.push_back(
          {r.scenario.feet[f], to_list(track.time), list_standing(1e3 * track.feet[f].angle[a], track.stands[f])});
    }
    html += make_svg(plot);
  }
  return html;
}

// How far the first sole is pressed in more than the second, as the closed chain and as the loads have it.
std::string make_slide(const Identification& r, const MotionTrack& track) {
  if (r.vertical.stiffness.size() != 2 || track.slide.size() == 0) return "";
  Eigen::VectorXd loads = calc_slide(r.vertical, track, 0) - calc_slide(r.vertical, track, 1);
  loads.array() -= loads.mean();
  return make_svg({"Vertical displacement: first bush less second, less the mean",
                   "time [s]",
                   "displacement [mm]",
                   {{"closed chain", to_list(track.time), to_list(1e3 * track.slide)},
                    {"load over identified stiffness", to_list(track.time), to_list(1e3 * loads)}}});
}

std::string make_torque(const Identification& r, const MotionTrack& track, size_t f, int a) {
  const std::vector<double> time = to_list(track.time);
  const Eigen::VectorXd predicted = predict_torque(r.fit, track, f, a);
  return make_svg({"Figures 9 to 13: torque, " + r.scenario.feet[f] + ", " + kAxisNames[a],
                   "time [s]",
                   "torque [N m]",
                   {{"sensed", time, to_list(track.feet[f].torque[a])},
                    {"reconstructed", time, list_standing(predicted, track.stands[f])},
                    {"ten times the difference", time,
                     list_standing(10.0 * (predicted - track.feet[f].torque[a]), track.stands[f])}}});
}

}  // namespace

std::string make_figures(const Identification& r) {
  const std::vector<FootFrame> feet = BushObserver(r.scenario).feet();
  std::string html = "<h2>Figures</h2><p>Lines have gaps while a foot does not stand.</p>";
  for (const MotionTrack& track : r.tracks) {
    html += "<details open><summary>" + escape_xml(track.name) + ": " + escape_xml(describe_support(r, track)) + ", " +
            (is_fitted(r, track) ? "fitted" : "not seen by the fit") + "</summary><div class=\"row\">" +
            make_zmp(track, feet) + make_angles(r, track) + make_slide(r, track);
    for (size_t f = 0; f < track.feet.size(); ++f) {
      for (int a = 0; a < kAxes && track.calc_standing_time(f) >= kLeastTime; ++a) html += make_torque(r, track, f, a);
    }
    html += "</div></details>";
  }
  return html;
}

}  // namespace hrp::identification
