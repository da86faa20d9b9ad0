// SPDX-License-Identifier: BSD-3-Clause
#include "common/plot/robot_pictures.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "common/base/format.h"
#include "common/base/write_file.h"
#include "common/mcap/reader.h"
#include "common/messages/cdr.h"
#include "common/messages/convert.h"
#include "common/messages/convert_robot.h"
#include "common/messages/logged_description.h"
#include "common/messages/topics.h"
#include "common/multibody/kinematics.h"
#include "common/plot/solids.h"
#include "common/robot/movers.h"
#include "common/robot/sole.h"

namespace hrp {
namespace {

using Eigen::Vector2d;

constexpr double kPanelWidth = 240, kPanelHeight = 250;
constexpr int kColumns = 4;
constexpr double kSunk = 0.02;  // [m] deeper than that in the ground nothing but a fallen robot's body is

// Left blue, right orange, as the first two lines of a plot; the rest grey: who steps is seen at once.
constexpr Colour kLeft{0.36, 0.62, 0.90}, kRight{0.95, 0.62, 0.33}, kMiddle{0.86, 0.87, 0.88}, kStone{0.72, 0.70, 0.66};

struct Moment {
  double time = 0.0;  // [s]
  State first;
  ObjectStates others;
};

struct Run {
  RobotDescription robot;
  Scenario scenario;
  std::vector<Mover> robots;
  size_t followed = 0;          // of the robots
  std::vector<Moment> moments;  // 100 a second
};

size_t find_followed(const Run& run, const std::string& path, const std::string& name) {
  std::string known;
  for (size_t k = 0; k < run.robots.size(); ++k) {
    if (run.robots[k].name == name) return k;
    if (k > 0) known += (k > 1 ? ", " : "") + run.robots[k].name;
  }
  throw std::runtime_error(path + ": has no robot '" + name + "'; expected " +
                           (known.empty() ? "none: there is one robot" : "one of " + known));
}

// Of a run that has diverged, nothing can be drawn, and nothing be sorted by distance.
bool is_finite(const State& state) {
  return std::isfinite(state.p_WB.squaredNorm()) && state.R_WB.coeffs().allFinite() && state.q.allFinite();
}

Run read_run(const std::string& path, const PictureOptions& options) {
  mcap::Reader log(path);
  Run run;
  msg::RobotState message;
  double next = options.from;
  log.read_messages(
      [&](const mcap::Message& sample) {
        const Bytes bytes{sample.data, sample.size};
        if (log.channels().at(sample.channel_id).topic == topics::kRobotDescription.name) {
          msg::RobotDescription description;
          decode_logged(bytes, &description);
          from_message(description, &run.robot);
          return true;
        }
        decode_logged(bytes, &message);
        const double time = message.header().time();
        if (options.to >= 0.0 && time > options.to + 1e-9) return false;
        if (time < next - 1e-9) return true;
        next = time + 0.01;
        run.moments.emplace_back();
        run.moments.back().time = time;
        from_message(message, &run.moments.back().first);
        from_message(message, &run.moments.back().others);
        const auto& [at, first, others] = run.moments.back();
        if (is_finite(first) && std::all_of(others.begin(), others.end(), is_finite)) return true;
        run.moments.pop_back();
        return false;
      },
      {topics::kRobotDescription.name, topics::kRobotState.name});
  if (run.robot.tree.links.empty()) throw std::runtime_error(path + ": no log of a simulation: it has no robot");
  if (run.moments.empty()) throw std::runtime_error(path + ": no run at the wanted times");
  run.scenario = parse_scenario(run.robot.scenario, run.robot.scenario_path);
  run.robots = make_robots(run.robot, run.scenario);
  run.followed = find_followed(run, path, options.robot);
  return run;
}

Colour find_colour(double y) { return y > 0.03 ? kLeft : y < -0.03 ? kRight : kMiddle; }

class Painter {
 public:
  explicit Painter(const Run& run) : run_(run), ground_(make_ground_plane(run.scenario.ground)) {
    for (size_t k = 0; k < run.robots.size(); ++k) add_robot(run.robots[k], k == run.followed);
    for (const ObstacleSpec& obstacle : run.scenario.obstacles) add_obstacle(obstacle);
  }

  // False when something other than a sole of the robot that the camera follows is in the ground.
  bool stands_clear(const Moment& moment) {
    if (!run_.scenario.ground.present) return true;
    const Mover& robot = run_.robots[run_.followed];
    const std::vector<Solid> placed = place(&bodies_[run_.followed], get_state(run_.followed, moment));
    for (size_t i = 0; i < placed.size(); ++i) {
      if (robot.robot.shapes[i].sole) continue;
      for (const Vector3d& v : placed[i].vertices) {
        if (calc_height(v) < -kSunk) return false;
      }
    }
    return true;
  }

  std::string draw(const Moment& moment, const PictureOptions& options) {
    std::vector<Solid> placed;
    for (size_t k = 0; k < bodies_.size(); ++k) {
      for (Solid& solid : place(&bodies_[k], get_state(k, moment))) placed.push_back(std::move(solid));
    }
    Camera camera;
    camera.azimuth = options.azimuth;
    camera.elevation = options.elevation;
    camera.scale = 0.74 * kPanelHeight / height_;
    camera.middle_x = 0.5 * kPanelWidth;
    camera.middle_y = 0.52 * kPanelHeight;
    const Vector3d& base = get_state(run_.followed, moment).p_WB;
    camera.target_W = put_on_ground({base.x(), base.y(), 0.0}) + Vector3d(0, 0, 0.5 * height_);
    std::string svg;
    if (run_.scenario.ground.present) svg += draw_floor(camera) + draw_shadow(placed, camera);
    placed.insert(placed.end(), obstacles_.begin(), obstacles_.end());
    return svg + draw_solids(placed, camera);
  }

 private:
  struct Body {
    explicit Body(const Mover& mover) : robot(&mover.robot), model(mover.robot.tree), data(model) {}
    const RobotDescription* robot;
    Model model;
    Data data;
    std::vector<Solid> solids;  // link axes
  };

  const State& get_state(size_t k, const Moment& moment) const {
    return find_robot_state(k, moment.first, moment.others, run_.scenario);
  }

  void add_robot(const Mover& robot, bool followed) {
    Body& body = bodies_.emplace_back(robot);
    for (const CollisionShape& shape : robot.robot.shapes)
      body.solids.push_back(move_solid(shape.X_LG, make_solid(shape)));
    const State start = make_start_state(robot.robot, robot.scenario);
    const std::vector<Solid> placed = place(&body, start);
    for (size_t i = 0; i < placed.size(); ++i) {
      body.solids[i].colour = find_colour((start.R_WB.conjugate() * (calc_middle(placed[i]) - start.p_WB)).y());
      if (!followed) continue;
      for (const Vector3d& v : placed[i].vertices) height_ = std::max(height_, calc_height(v));
    }
  }

  double calc_height(const Vector3d& p_W) const { return ground_.n_W.dot(p_W) - ground_.offset; }

  Vector3d put_on_ground(const Vector3d& p_W) const { return p_W - Vector3d(0, 0, calc_height(p_W) / ground_.n_W.z()); }

  void add_obstacle(const ObstacleSpec& obstacle) {
    if (obstacle.is_surface()) return;  // solids are convex here
    CollisionShape shape;
    shape.size = obstacle.size;
    shape.kind = obstacle.shape == "sphere"     ? ShapeKind::kSphere
                 : obstacle.shape == "cylinder" ? ShapeKind::kCylinder
                                                : ShapeKind::kBox;
    obstacles_.push_back(move_solid(obstacle.X_WG, make_solid(shape)));
    obstacles_.back().colour = kStone;
  }

  static std::vector<Solid> place(Body* body, const State& state) {
    update_kinematics(body->model, state, &body->data);
    std::vector<Solid> placed;
    for (size_t i = 0; i < body->solids.size(); ++i) {
      placed.push_back(move_solid(get_pose(body->data, body->robot->shapes[i].link), body->solids[i]));
    }
    return placed;
  }

  static constexpr double kReach = 0.9, kStep = 0.2;  // [m] of the floor that is drawn, between its lines

  // Whole multiples of kStep on the floor around a coordinate; none where doubles are further apart than lines, as in a
  // run that has diverged.
  static std::vector<double> list_lines(double middle) {
    std::vector<double> lines;
    const double first = std::ceil((middle - kReach) / kStep);
    for (double k = first; k * kStep <= middle + kReach && k + 1.0 > k; k += 1.0) lines.push_back(k);
    return lines;
  }

  // Lines of the world every 0.2 m, heavier ones every metre, on a piece of floor below the robot.
  std::string draw_floor(const Camera& camera) const {
    const double x = camera.target_W.x(), y = camera.target_W.y();
    const auto at = [&](double px, double py) { return camera.project(put_on_ground({px, py, 0.0})); };
    std::string svg = "<polygon class=\"floor\" points=\"" +
                      make_points({at(x - kReach, y - kReach), at(x + kReach, y - kReach), at(x + kReach, y + kReach),
                                   at(x - kReach, y + kReach)}) +
                      "\"/>\n";
    const auto add_line = [&](double k, const Vector2d& a, const Vector2d& b) {
      svg += format("<path class=\"%s\" d=\"M%.1f %.1fL%.1f %.1f\"/>", std::fmod(k, 5.0) == 0.0 ? "metre" : "line",
                    a.x(), a.y(), b.x(), b.y());
    };
    for (double k : list_lines(x)) add_line(k, at(k * kStep, y - kReach), at(k * kStep, y + kReach));
    for (double k : list_lines(y)) add_line(k, at(x - kReach, k * kStep), at(x + kReach, k * kStep));
    return svg + "\n";
  }

  // Of a light high up on the viewer's side.
  std::string draw_shadow(const std::vector<Solid>& solids, const Camera& camera) const {
    const Vector3d light = (0.35 * camera.calc_direction() + Vector3d(0, 0, 1)).normalized();
    std::string svg = "<g class=\"shadow\">";
    for (const Solid& solid : solids) {
      std::vector<Vector2d> points;
      for (const Vector3d& v : solid.vertices) {
        points.push_back(camera.project(v - light * (std::max(0.0, calc_height(v)) / ground_.n_W.dot(light))));
      }
      svg += "<polygon points=\"" + make_points(find_outline(points)) + "\"/>";
    }
    return svg + "</g>\n";
  }

  const Run& run_;
  GroundPlane ground_;
  std::vector<Body> bodies_;      // one a robot
  std::vector<Solid> obstacles_;  // world axes
  double height_ = 0.1;           // [m] at the start, of the robot that the camera follows
};

std::vector<size_t> choose_moments(const Run& run, int count, Painter* painter) {
  size_t end = 1;
  while (end < run.moments.size() && painter->stands_clear(run.moments[end])) ++end;
  std::vector<size_t> chosen;
  for (int i = 0; i < count; ++i) {
    const double part = count > 1 ? static_cast<double>(i) / (count - 1) : 0.0;
    chosen.push_back(static_cast<size_t>(std::lround(part * static_cast<double>(end - 1))));
  }
  return chosen;
}

}  // namespace

void write_robot_pictures(const std::string& log_path, const PictureOptions& options, const std::string& svg_path) {
  const Run run = read_run(log_path, options);
  Painter painter(run);
  const std::vector<size_t> chosen = choose_moments(run, std::max(1, options.count), &painter);
  const int columns = std::min<int>(kColumns, static_cast<int>(chosen.size()));
  const double width = kPanelWidth * columns;
  const double height = kPanelHeight * std::ceil(static_cast<double>(chosen.size()) / columns);
  std::string svg = format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" width=\"%.0f\" height=\"%.0f\" "
      "font-family=\"sans-serif\" font-size=\"13\" class=\"robot\">\n",
      width, height, width, height);
  svg +=
      "<style>text{fill:#333}.page{fill:#fff}.floor{fill:#eceae6}.line,.metre{stroke:#bbb6ad;stroke-width:.6;fill:none}"
      ".metre{stroke:#8d877c;stroke-width:1.4}.shadow{fill:#000;opacity:.16}"
      "@media(prefers-color-scheme:dark){text{fill:#ddd}.page{fill:#181818}.floor{fill:#3a3936}"
      ".line,.metre{stroke:#5a5852}.metre{stroke:#85817a}.shadow{opacity:.4}}</style>\n"
      "<rect class=\"page\" width=\"100%\" height=\"100%\"/>\n";
  for (size_t i = 0; i < chosen.size(); ++i) {
    const Moment& moment = run.moments[chosen[i]];
    const size_t row = i / size_t(columns), column = i % size_t(columns);
    svg += format("<svg x=\"%.0f\" y=\"%.0f\" width=\"%.0f\" height=\"%.0f\">\n",
                  kPanelWidth * static_cast<double>(column), kPanelHeight * static_cast<double>(row), kPanelWidth,
                  kPanelHeight);
    svg += painter.draw(moment, options);
    svg += format("<text x=\"10\" y=\"20\">%.2f s</text></svg>\n", moment.time);
  }
  svg += "</svg>\n";
  write_file(svg_path, svg);
}

}  // namespace hrp
