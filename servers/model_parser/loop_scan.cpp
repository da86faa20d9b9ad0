// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/loop_scan.h"

#include <map>
#include <string>

#include <tinyxml2.h>

#include "common/base/suggest.h"
#include "servers/model_parser/urdf_scan.h"
#include "servers/model_parser/xml_values.h"

namespace hrp {
namespace {

using Element = tinyxml2::XMLElement;

// A scenario's word for the kind of a loop; empty for an unknown one.
std::string find_kind(const std::string& type) {
  static const std::map<std::string, std::string> kinds = {
      {"ball", "ball"},    {"point", "ball"}, {"spherical", "ball"}, {"pin", "pin"},   {"hinge", "pin"},
      {"revolute", "pin"}, {"weld", "weld"},  {"continuous", "pin"}, {"fixed", "weld"}};
  const auto found = kinds.find(type);
  return found == kinds.end() ? "" : found->second;
}

class LoopScanner {
 public:
  LoopScanner(const UrdfScan& scan, Diagnostics* diagnostics) : scan_(scan), diagnostics_(diagnostics) {}
  LoopScan scan_loop(const Element& element);

 private:
  void error(const Element& at, const std::string& message);
  void read_name(const Element& element, LoopScan* loop);
  void read_frame(const Element& loop, const char* tag, std::string* link, Transform* X_LF);
  Vector3d read_vector(const Element& origin, const char* attribute, const char* unit);
  void check_link(const Element& frame, const std::string& link);
  void check_children(const Element& loop);

  const UrdfScan& scan_;
  Diagnostics* diagnostics_;
  std::string owner_;
  std::map<std::string, int> lines_;  // of the loops so far
};

void LoopScanner::error(const Element& at, const std::string& message) {
  const std::string part = std::string(at.Name()) == "loop" ? "" : " <" + std::string(at.Name()) + ">";
  diagnostics_->add_error({scan_.file, owner_ + part, at.GetLineNum()}, message);
}

void LoopScanner::read_name(const Element& element, LoopScan* loop) {
  loop->spec.name = get_attribute(element, "name");
  owner_ = "loop '" + loop->spec.name + "'";
  if (loop->spec.name.empty()) {
    owner_ = "<loop>";
    return error(element, "has no name; every loop needs one");
  }
  // A name becomes a key of the scenario: "loops.NAME".
  if (loop->spec.name.find_first_of(".[") != std::string::npos) error(element, "expected a name without '.' and '['");
  const auto [first, fresh] = lines_.emplace(loop->spec.name, loop->line);
  if (!fresh) error(element, "stands here again; first in line " + std::to_string(first->second));
}

Vector3d LoopScanner::read_vector(const Element& origin, const char* attribute, const char* unit) {
  const char* text = origin.Attribute(attribute);
  if (text == nullptr) return Vector3d::Zero();
  const std::vector<double> numbers = parse_numbers(text, 3);
  if (numbers.size() == 3) return {numbers[0], numbers[1], numbers[2]};
  error(origin, std::string(attribute) + " is '" + text + "', expected 3 finite numbers [" + unit + "]");
  return Vector3d::Zero();
}

void LoopScanner::check_link(const Element& frame, const std::string& link) {
  if (link.empty()) return error(frame, "attribute 'link' is missing, expected the name of a link");
  if (scan_.find_link_line(link) > 0) return;
  std::vector<std::string> names;
  for (const LinkScan& l : scan_.links) names.push_back(l.name);
  error(frame, "names link '" + link + "', which is not in the file" + suggest(link, names));
}

void LoopScanner::read_frame(const Element& loop, const char* tag, std::string* link, Transform* X_LF) {
  const Element* frame = loop.FirstChildElement(tag);
  if (frame == nullptr) return error(loop, std::string("has no <") + tag + " link=\"...\">");
  if (frame->NextSiblingElement(tag) != nullptr)
    error(*frame->NextSiblingElement(tag), "stands here again, expected one");
  *link = get_attribute(*frame, "link");
  check_link(*frame, *link);
  const Element* origin = frame->FirstChildElement("origin");
  if (origin == nullptr) return;
  X_LF->p = read_vector(*origin, "xyz", "m");
  X_LF->R = make_rotation_from_rpy(read_vector(*origin, "rpy", "rad"));
}

void LoopScanner::check_children(const Element& loop) {
  for (const Element* e = loop.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    const std::string name = e->Name();
    if (name != "frame_a" && name != "frame_b") error(*e, "is unknown here, expected <frame_a> and <frame_b>");
  }
}

LoopScan LoopScanner::scan_loop(const Element& element) {
  LoopScan loop;
  loop.line = element.GetLineNum();
  read_name(element, &loop);
  const std::string type = get_attribute(element, "type");
  loop.spec.kind = find_kind(type);
  if (loop.spec.kind.empty()) {
    error(element, "is of type '" + type +
                       "', expected ball, pin or weld (also point, spherical; hinge, revolute, continuous; fixed)");
  }
  check_children(element);
  read_frame(element, "frame_a", &loop.spec.link_a, &loop.spec.X_AF);
  read_frame(element, "frame_b", &loop.spec.link_b, &loop.spec.X_BF);
  if (!loop.spec.link_a.empty() && loop.spec.link_a == loop.spec.link_b) {
    error(element,
          "has both frames on link '" + loop.spec.link_a + "', expected two links that move against each other");
  }
  return loop;
}

}  // namespace

std::vector<LoopScan> scan_loops(const tinyxml2::XMLElement& robot, const UrdfScan& scan, Diagnostics* diagnostics) {
  std::vector<LoopScan> loops;
  LoopScanner scanner(scan, diagnostics);
  for (const Element* e = robot.FirstChildElement("loop"); e != nullptr; e = e->NextSiblingElement("loop")) {
    loops.push_back(scanner.scan_loop(*e));
  }
  return loops;
}

}  // namespace hrp
