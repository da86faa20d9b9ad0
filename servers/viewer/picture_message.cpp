// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/picture_message.h"

#include <nlohmann/json.hpp>

#include "servers/viewer/dump_json.h"

namespace hrp {
namespace {

using Json = nlohmann::json;

const char* get_name(Picture::Kind kind) {
  return kind == Picture::Kind::kColor ? "color" : kind == Picture::Kind::kDepth ? "depth" : "points";
}

Json make_head(size_t source, const std::string& topic) {
  return {{"op", "picture"}, {"source", source}, {"topic", topic}};
}

std::string make_message(const Json& head, const std::string& pixels) {
  std::string text = dump_json(head);
  text.resize((text.size() + 3) & ~size_t{3}, ' ');  // a page reads numbers of 4 bytes behind it
  const auto length = static_cast<uint32_t>(text.size());
  std::string message(reinterpret_cast<const char*>(&length), sizeof length);
  message.reserve(sizeof length + text.size() + pixels.size());
  return message.append(text).append(pixels);
}

}  // namespace

std::string make_picture_message(size_t source, const std::string& topic, const Picture& picture) {
  Json head = make_head(source, topic);
  head["time"] = picture.time;
  head["kind"] = get_name(picture.kind);
  head["width"] = picture.width;
  head["height"] = picture.height;
  head["stride"] = picture.stride;
  return make_message(head, picture.pixels);
}

std::string make_picture_message(size_t source, const std::string& topic, const std::string& error) {
  Json head = make_head(source, topic);
  head["error"] = error;
  return make_message(head, "");
}

}  // namespace hrp
