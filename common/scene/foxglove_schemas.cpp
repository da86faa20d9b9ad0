// SPDX-License-Identifier: BSD-3-Clause
#include <string>
#include <utility>
#include <vector>

#include "common/scene/foxglove.h"
#include "common/scene/json_text.h"

namespace hrp::foxglove {
namespace {

using Fields = std::vector<std::pair<const char*, std::string>>;

std::string make_type(const char* type) { return JsonText().begin('{').key("type").put(type).end('}').text(); }

std::string make_object(const char* title, const Fields& fields) {
  JsonText json;
  json.begin('{').key("title").put(title).key("type").put("object").key("properties").begin('{');
  for (const auto& [name, schema] : fields) json.key(name).raw(schema);
  json.end('}').key("required").begin('[');
  for (const auto& [name, schema] : fields) json.put(name);
  return json.end(']').end('}').text();
}

std::string make_list(const std::string& items) {
  return JsonText().begin('{').key("type").put("array").key("items").raw(items).end('}').text();
}

struct Schemas {
  std::string number = make_type("number"), integer = make_type("integer"), text = make_type("string"),
              flag = make_type("boolean");
  std::string bytes =
      JsonText().begin('{').key("type").put("string").key("contentEncoding").put("base64").end('}').text();
  std::string time = make_object("time", {{"sec", integer}, {"nsec", integer}});
  std::string duration = make_object("duration", {{"sec", integer}, {"nsec", integer}});
  std::string vector = make_object("foxglove.Vector3", {{"x", number}, {"y", number}, {"z", number}});
  std::string point = make_object("foxglove.Point3", {{"x", number}, {"y", number}, {"z", number}});
  std::string quaternion =
      make_object("foxglove.Quaternion", {{"x", number}, {"y", number}, {"z", number}, {"w", number}});
  std::string pose = make_object("foxglove.Pose", {{"position", vector}, {"orientation", quaternion}});
  std::string colour = make_object("foxglove.Color", {{"r", number}, {"g", number}, {"b", number}, {"a", number}});

  std::string make_frame_transforms() const {
    const std::string transform = make_object("foxglove.FrameTransform", {{"timestamp", time},
                                                                          {"parent_frame_id", text},
                                                                          {"child_frame_id", text},
                                                                          {"translation", vector},
                                                                          {"rotation", quaternion}});
    return make_object(kFrameTransforms, {{"transforms", make_list(transform)}});
  }

  std::string make_arrow() const {
    return make_object("foxglove.ArrowPrimitive", {{"pose", pose},
                                                   {"shaft_length", number},
                                                   {"shaft_diameter", number},
                                                   {"head_length", number},
                                                   {"head_diameter", number},
                                                   {"color", colour}});
  }
  std::string make_cylinder() const {
    return make_object(
        "foxglove.CylinderPrimitive",
        {{"pose", pose}, {"size", vector}, {"bottom_scale", number}, {"top_scale", number}, {"color", colour}});
  }
  std::string make_line() const {
    return make_object("foxglove.LinePrimitive", {{"type", integer},
                                                  {"pose", pose},
                                                  {"thickness", number},
                                                  {"scale_invariant", flag},
                                                  {"points", make_list(point)},
                                                  {"color", colour},
                                                  {"colors", make_list(colour)},
                                                  {"indices", make_list(integer)}});
  }
  std::string make_triangles() const {
    return make_object("foxglove.TriangleListPrimitive", {{"pose", pose},
                                                          {"points", make_list(point)},
                                                          {"color", colour},
                                                          {"colors", make_list(colour)},
                                                          {"indices", make_list(integer)}});
  }
  std::string make_text() const {
    return make_object("foxglove.TextPrimitive", {{"pose", pose},
                                                  {"billboard", flag},
                                                  {"font_size", number},
                                                  {"scale_invariant", flag},
                                                  {"color", colour},
                                                  {"text", text}});
  }
  std::string make_model() const {
    return make_object("foxglove.ModelPrimitive", {{"pose", pose},
                                                   {"scale", vector},
                                                   {"color", colour},
                                                   {"override_color", flag},
                                                   {"url", text},
                                                   {"media_type", text},
                                                   {"data", bytes}});
  }
  std::string make_scene_update() const {
    const Fields solid{{"pose", pose}, {"size", vector}, {"color", colour}};
    const std::string pair = make_object("foxglove.KeyValuePair", {{"key", text}, {"value", text}});
    const std::string entity =
        make_object("foxglove.SceneEntity", {{"timestamp", time},
                                             {"frame_id", text},
                                             {"id", text},
                                             {"lifetime", duration},
                                             {"frame_locked", flag},
                                             {"metadata", make_list(pair)},
                                             {"arrows", make_list(make_arrow())},
                                             {"cubes", make_list(make_object("foxglove.CubePrimitive", solid))},
                                             {"spheres", make_list(make_object("foxglove.SpherePrimitive", solid))},
                                             {"cylinders", make_list(make_cylinder())},
                                             {"lines", make_list(make_line())},
                                             {"triangles", make_list(make_triangles())},
                                             {"texts", make_list(make_text())},
                                             {"models", make_list(make_model())}});
    const std::string deletion =
        make_object("foxglove.SceneEntityDeletion", {{"timestamp", time}, {"type", integer}, {"id", text}});
    return make_object(kSceneUpdate, {{"deletions", make_list(deletion)}, {"entities", make_list(entity)}});
  }
};

}  // namespace

std::string find_schema(const std::string& type) {
  const Schemas schemas;
  return type == kFrameTransforms ? schemas.make_frame_transforms()
         : type == kSceneUpdate   ? schemas.make_scene_update()
                                  : "";
}

}  // namespace hrp::foxglove
