// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/surface_file.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <map>
#include <tuple>

#include "common/base/diagnostics.h"
#include "common/base/file_ending.h"
#include "common/base/read_file.h"
#include "common/robot/mesh.h"

namespace hrp {
namespace {

bool is_separator(char c) { return c == ',' || c == ';' || c == ' ' || c == '\t' || c == '\r'; }

// Appends the numbers of one line and returns how many there were.
int parse_row(const char* at, const char* end, int line, const std::string& path, std::vector<double>* values) {
  int count = 0;
  for (;;) {
    while (at != end && is_separator(*at)) ++at;
    if (at == end || *at == '#') return count;
    double value = 0.0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || (next != end && !is_separator(*next))) {
      refuse_input({path, "", line},
                   "'" + std::string(at, std::min(at + 12, end)) + "' is no number, expected heights in metres");
    }
    values->push_back(value);
    ++count;
    at = next;
  }
}

// The next word of a PGM header; comments run from # to the end of the line.
std::string take_word(const std::string& text, size_t* at) {
  const auto is_space = [&] { return std::isspace(static_cast<unsigned char>(text[*at])) != 0; };
  while (*at < text.size() && (is_space() || text[*at] == '#')) {
    if (text[*at] == '#') {
      while (*at < text.size() && text[*at] != '\n') ++*at;
    } else {
      ++*at;
    }
  }
  const size_t first = *at;
  while (*at < text.size() && !is_space() && *at - first < 12) ++*at;
  return text.substr(first, *at - first);
}

int take_number(const std::string& text, size_t* at, const std::string& path) {
  const std::string word = take_word(text, at);
  int value = -1;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || value < 0)
    refuse_input(path, "is no PGM image: '" + word + "' where a number should be");
  return value;
}

HeightTable load_heights(const std::string& path) {
  const std::string ending = find_ending(path);
  if (ending == ".png") return read_png(path);
  if (ending == ".pgm") return parse_pgm(read_input(path), path);
  if (ending == ".csv" || ending == ".txt") return parse_height_text(read_input(path), path);
  refuse_input(path, "heights are read from .csv, .txt, .png and .pgm files");
}

// [m^3] that a mesh without border holds; 0 when it has a border.
double calc_volume(const Mesh& mesh) {
  std::map<std::pair<int, int>, int> open;  // edges that no triangle follows the other way
  double volume = 0.0;
  for (const auto& t : mesh.triangles) {
    volume += mesh.vertices[size_t(t[0])].dot(mesh.vertices[size_t(t[1])].cross(mesh.vertices[size_t(t[2])])) / 6.0;
    for (size_t k = 0; k < 3; ++k) {
      const int u = t[k], v = t[(k + 1) % 3];
      const auto other = open.find({v, u});
      if (other == open.end()) {
        ++open[{u, v}];
      } else if (--other->second == 0) {
        open.erase(other);
      }
    }
  }
  return open.empty() ? volume : 0.0;
}

void load_grid(const ObstacleSpec& obstacle, Surface* surface) {
  HeightTable table = load_heights(obstacle.file);
  if (table.rows < 2 || table.columns < 2)
    refuse_input(obstacle.file, "a height field needs two rows and two columns at least");
  const bool image = table.white > 0.0;
  if (image && obstacle.low == obstacle.high)
    refuse_input(obstacle.file, "is an image: the obstacle needs 'low' and 'high', the heights of black and white [m]");
  if (!image && obstacle.low != obstacle.high)
    refuse_input(obstacle.file, "has heights in metres: 'low' and 'high' are for images");
  for (double& value : table.values) {
    if (image) value = obstacle.low + (obstacle.high - obstacle.low) * (value / table.white);
  }
  surface->columns = table.columns;
  surface->rows = table.rows;
  surface->spacing = obstacle.spacing;
  surface->heights = std::move(table.values);
}

}  // namespace

HeightTable parse_height_text(const std::string& text, const std::string& path) {
  HeightTable table;
  int line = 0;
  for (size_t at = 0; at < text.size(); ++line) {
    const size_t end = std::min(text.find('\n', at), text.size());
    const int count = parse_row(text.data() + at, text.data() + end, line + 1, path, &table.values);
    at = end + 1;
    if (count == 0) continue;
    if (table.rows++ == 0) table.columns = count;
    if (count != table.columns) {
      refuse_input({path, "", line + 1},
                   "has " + std::to_string(count) + " heights, the lines above have " + std::to_string(table.columns));
    }
    if (table.values.size() > static_cast<size_t>(kMostHeights))
      refuse_input(path, "has more than " + std::to_string(kMostHeights) + " heights");
  }
  return table;
}

HeightTable parse_pgm(const std::string& text, const std::string& path) {
  size_t at = 0;
  const std::string kind = take_word(text, &at);
  if (kind != "P2" && kind != "P5")
    refuse_input(path, "is no PGM image: it begins with '" + kind + "', expected P2 or P5");
  HeightTable table;
  table.columns = take_number(text, &at, path);
  table.rows = take_number(text, &at, path);
  const int white = take_number(text, &at, path);
  if (white < 1 || white > 65535)
    refuse_input(path, "has the largest value " + std::to_string(white) + ", expected 1 to 65535");
  table.white = white;
  const auto count = static_cast<size_t>(table.columns) * static_cast<size_t>(table.rows);
  if (count > static_cast<size_t>(kMostHeights))
    refuse_input(path,
                 "has " + std::to_string(count) + " pixels, expected " + std::to_string(kMostHeights) + " at most");
  const size_t bytes = white > 255 ? 2 : 1;
  if (at < text.size()) ++at;  // one blank after the header
  if (kind == "P5" && text.size() - at < count * bytes) refuse_input(path, "ends within its pixels");
  for (size_t i = 0; i < count; ++i) {
    int value = 0;
    if (kind == "P2") value = take_number(text, &at, path);
    for (size_t k = 0; kind == "P5" && k < bytes; ++k) value = value * 256 + static_cast<unsigned char>(text[at++]);
    table.values.push_back(std::min(value, white));
  }
  return table;
}

Mesh weld(const Mesh& mesh) {
  Mesh welded;
  std::map<std::tuple<double, double, double>, int> known;
  std::vector<int> index;
  for (const Vector3d& v : mesh.vertices) {
    const auto [it, fresh] = known.try_emplace({v.x(), v.y(), v.z()}, static_cast<int>(welded.vertices.size()));
    if (fresh) welded.vertices.push_back(v);
    index.push_back(it->second);
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::array<int, 3> t{index[size_t(a)], index[size_t(b)], index[size_t(c)]};
    const Vector3d &p = welded.vertices[size_t(t[0])], &q = welded.vertices[size_t(t[1])],
                   &r = welded.vertices[size_t(t[2])];
    if ((q - p).cross(r - p).norm() > 1e-12 * (q - p).norm() * (r - p).norm()) welded.triangles.push_back(t);
  }
  return welded;
}

Mesh make_outward(const Mesh& mesh) {
  Mesh outward = weld(mesh);
  if (calc_volume(outward) < 0.0) {
    for (auto& [a, b, c] : outward.triangles) std::swap(b, c);
  }
  return outward;
}

std::shared_ptr<const Surface> load_surface(const ObstacleSpec& obstacle) {
  auto surface = std::make_shared<Surface>();
  surface->obstacle = obstacle.name;
  if (obstacle.shape == "mesh") {
    surface->mesh = weld(load_mesh(obstacle.file, obstacle.scale));
    if (calc_volume(surface->mesh) < 0.0)
      refuse_input(obstacle.file, "faces inward: triangles must be counter-clockwise seen from outside");
  } else {
    load_grid(obstacle, surface.get());
  }
  const std::string fault = find_surface_fault(*surface);
  if (!fault.empty()) refuse_input(obstacle.file, fault);
  return surface;
}

}  // namespace hrp
