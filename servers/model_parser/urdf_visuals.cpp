// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/urdf_visuals.h"

#include <map>
#include <optional>

#include <tinyxml2.h>

#include "servers/model_parser/mesh_path.h"
#include "servers/model_parser/xml_values.h"

namespace hrp {
namespace {

using Element = tinyxml2::XMLElement;

constexpr double kSoleGrey[] = {0.35, 0.38, 0.45};

// `fallback` where the attribute is not there or no three numbers.
Vector3d read_three(const Element& element, const char* attribute, const Vector3d& fallback) {
  const std::vector<double> numbers = parse_numbers(get_attribute(element, attribute).c_str(), 3);
  return numbers.empty() ? fallback : Vector3d(numbers[0], numbers[1], numbers[2]);
}

double read_length(const Element& element, const char* attribute) {
  const std::vector<double> numbers = parse_numbers(get_attribute(element, attribute).c_str(), 1);
  return numbers.empty() ? 0.0 : numbers[0];
}

std::optional<Vector3d> read_color(const Element& material) {
  const Element* color = material.FirstChildElement("color");
  if (color == nullptr) return std::nullopt;
  const std::vector<double> rgba = parse_numbers(get_attribute(*color, "rgba").c_str(), 4);
  if (rgba.empty()) return std::nullopt;
  return Vector3d(rgba[0], rgba[1], rgba[2]).cwiseMax(0.0).cwiseMin(1.0);
}

// By name; a material may be defined inside the visual of some link.
using Materials = std::map<std::string, Vector3d>;

void add_material(const Element& material, Materials* materials) {
  const std::optional<Vector3d> color = read_color(material);
  const std::string name = get_attribute(material, "name");
  if (color && !name.empty()) materials->emplace(name, *color);
}

template <typename Visit>
void for_each(const Element& parent, const char* name, Visit visit) {
  for (const Element* e = parent.FirstChildElement(name); e != nullptr; e = e->NextSiblingElement(name)) visit(*e);
}

Materials read_materials(const Element& robot) {
  Materials materials;
  for_each(robot, "material", [&](const Element& material) { add_material(material, &materials); });
  for_each(robot, "link", [&](const Element& link) {
    for_each(link, "visual", [&](const Element& visual) {
      for_each(visual, "material", [&](const Element& material) { add_material(material, &materials); });
    });
  });
  return materials;
}

// False where the geometry cannot be drawn.
bool read_geometry(const Element& visual, const std::string& urdf_path, CollisionShape* shape) {
  const Element* geometry = visual.FirstChildElement("geometry");
  const Element* solid = geometry == nullptr ? nullptr : geometry->FirstChildElement();
  if (solid == nullptr) return false;
  const std::string kind = solid->Name();
  if (kind == "mesh") {
    shape->kind = ShapeKind::kMesh;
    shape->scale = read_three(*solid, "scale", Vector3d::Ones());
    shape->mesh = find_mesh(get_attribute(*solid, "filename"), urdf_path);
    return !shape->mesh.empty();
  }
  if (kind == "box") {
    shape->size = read_three(*solid, "size", Vector3d::Zero());
    return shape->size.minCoeff() > 0.0;
  }
  shape->size.x() = read_length(*solid, "radius");
  shape->kind = ShapeKind::kSphere;
  if (kind == "sphere") return shape->size.x() > 0.0;
  shape->size.y() = read_length(*solid, "length");
  shape->kind = ShapeKind::kCylinder;
  return kind == "cylinder" && shape->size.x() > 0.0 && shape->size.y() > 0.0;
}

std::optional<VisualShape> read_visual(const Element& visual, const FrameSpec& frame, const std::string& urdf_path,
                                       const Materials& materials) {
  VisualShape drawn;
  drawn.shape.link = frame.link;
  drawn.shape.name = frame.name;
  if (!read_geometry(visual, urdf_path, &drawn.shape)) return std::nullopt;
  Transform X_LV;
  if (const Element* origin = visual.FirstChildElement("origin")) {
    X_LV.p = read_three(*origin, "xyz", Vector3d::Zero());
    X_LV.R = make_rotation_from_rpy(read_three(*origin, "rpy", Vector3d::Zero()));
  }
  drawn.shape.X_LG = frame.X_LF * X_LV;
  if (const Element* material = visual.FirstChildElement("material")) {
    const auto named = materials.find(get_attribute(*material, "name"));
    const std::optional<Vector3d> own = read_color(*material);
    if (own)
      drawn.color = *own;
    else if (named != materials.end())
      drawn.color = named->second;
  }
  return drawn;
}

// Collision shapes have the name of their URDF link, with '#' and more behind it where it has several.
void add_collision_shapes(const std::string& link, const RobotDescription& robot, std::vector<VisualShape>* visuals) {
  for (const CollisionShape& shape : robot.shapes) {
    if (shape.name != link && shape.name.rfind(link + "#", 0) != 0) continue;
    VisualShape drawn;
    drawn.shape = shape;
    if (shape.sole) drawn.color = Vector3d(kSoleGrey);
    visuals->push_back(drawn);
  }
}

}  // namespace

std::vector<VisualShape> read_visuals(const std::string& urdf, const RobotDescription& robot) {
  std::vector<VisualShape> visuals;
  tinyxml2::XMLDocument document;
  if (document.Parse(urdf.c_str(), urdf.size()) != tinyxml2::XML_SUCCESS) return visuals;
  const Element* root = document.FirstChildElement("robot");
  if (root == nullptr) return visuals;
  const Materials materials = read_materials(*root);
  for_each(*root, "link", [&](const Element& link) {
    const std::string name = get_attribute(link, "name");
    const int frame = robot.tree.find_frame(name);
    if (frame < 0) return;
    const size_t before = visuals.size();
    for_each(link, "visual", [&](const Element& visual) {
      const auto drawn = read_visual(visual, robot.tree.frames[static_cast<size_t>(frame)], robot.urdf_path, materials);
      if (drawn) visuals.push_back(*drawn);
    });
    if (visuals.size() == before) add_collision_shapes(name, robot, &visuals);
  });
  return visuals;
}

}  // namespace hrp
