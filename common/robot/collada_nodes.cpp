// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/collada_nodes.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <vector>

namespace hrp {
namespace {

constexpr int kDeepest = 200;  // nodes within nodes: each is a call within a call; exported scenes have less than 20
constexpr int kMostNodes = 100000;  // with all repetitions: half of the triangles that a surface may have

struct Node {
  std::string id;
  std::vector<size_t> children;
  std::vector<std::string> others;  // references, without #
  enum { kNew, kOpen, kDone } state = kNew;
  double size = 1.0;  // with all that it contains
  int depth = 1;      // of what it contains
};

std::string describe_depth() { return "has nodes within nodes, more than " + std::to_string(kDeepest) + " deep"; }

bool is_space(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

// Of a tag's text: name="value" or name = 'value'; empty when it has none.
std::string find_attribute(const std::string& tag, const std::string& name) {
  for (size_t at = 0; (at = tag.find(name, at)) != std::string::npos; at += name.size()) {
    if (at == 0 || !is_space(tag[at - 1])) continue;
    size_t begin = at + name.size();
    while (begin < tag.size() && is_space(tag[begin])) ++begin;
    if (begin >= tag.size() || tag[begin] != '=') continue;
    begin = tag.find_first_of("\"'", begin);
    const size_t end = begin == std::string::npos ? begin : tag.find(tag[begin], begin + 1);
    if (end != std::string::npos) return tag.substr(begin + 1, end - begin - 1);
  }
  return "";
}

// Behind the tag, comment or section of plain text that begins at `at`. A > in quotes ends no tag.
size_t find_end(const std::string& text, size_t at) {
  const auto behind = [&](const char* mark, size_t length) {
    const size_t end = text.find(mark, at);
    return end == std::string::npos ? text.size() : end + length;
  };
  if (text.compare(at, 4, "<!--") == 0) return behind("-->", 3);
  if (text.compare(at, 9, "<![CDATA[") == 0) return behind("]]>", 3);
  if (text.compare(at, 2, "<?") == 0) return behind("?>", 2);
  char quote = 0;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (quote != 0)
      quote = c == quote ? '\0' : quote;
    else if (c == '"' || c == '\'')
      quote = c;
    else if (c == '>')
      return at + 1;
  }
  return at;
}

// Of what stands between < and >, and the > itself. An end has a / first.
std::string find_name(const std::string& tag) { return tag.substr(0, tag.find_first_of(" \t\r\n/>", 1)); }

bool is_empty_element(const std::string& tag) { return tag.size() > 1 && tag[tag.size() - 2] == '/'; }

class Scene {
 public:
  // False when tags of nodes are too deep within each other.
  bool read(const std::string& text) {
    for (size_t at = text.find('<'); at < text.size(); at = text.find('<', at)) {
      const size_t end = find_end(text, at);
      if (text.compare(at, 2, "<!") != 0) take_tag(text.substr(at + 1, end - at - 1));
      if (open_.size() > static_cast<size_t>(kDeepest)) return false;
      at = end;
    }
    return true;
  }

  std::string find_fault() {
    for (size_t i = 0; i < nodes_.size(); ++i) {
      std::string fault = visit(i, 1);
      if (!fault.empty()) return fault;
      if (nodes_[i].size > kMostNodes)
        return "has more than " + std::to_string(kMostNodes) + " nodes, as nodes contain others several times";
    }
    return "";
  }

 private:
  void take_tag(const std::string& tag) {
    const std::string name = find_name(tag);
    const bool ends = is_empty_element(tag);
    if (name == "library_nodes" || name == "/library_nodes") library_ = name[0] != '/' && !ends;
    if (name == "/node" && !open_.empty()) open_.pop_back();
    if (name == "instance_node" && !open_.empty()) {
      const std::string url = find_attribute(tag, "url");
      nodes_[open_.back()].others.push_back(url.substr(url.empty() ? 0 : 1));
    }
    if (name != "node") return;
    Node node;
    node.id = find_attribute(tag, "id");
    if (library_ && open_.empty()) shared_[node.id] = nodes_.size();
    for (const std::string& known : {node.id, find_attribute(tag, "name")}) first_.emplace(known, nodes_.size());
    if (!open_.empty()) nodes_[open_.back()].children.push_back(nodes_.size());
    if (!ends) open_.push_back(nodes_.size());
    nodes_.push_back(node);
  }

  // What is inside a node. Assimp looks in the library, then for the first node with this id or name, and leaves out
  // what is nowhere.
  std::vector<size_t> find_inside(const Node& node) const {
    std::vector<size_t> inside = node.children;
    for (const std::string& reference : node.others) {
      const auto shared = shared_.find(reference), first = first_.find(reference);
      if (shared != shared_.end())
        inside.push_back(shared->second);
      else if (first != first_.end())
        inside.push_back(first->second);
    }
    return inside;
  }

  std::string visit(size_t at, int depth) {
    if (nodes_[at].state == Node::kDone) return "";
    if (nodes_[at].state == Node::kOpen) return "has a node that contains itself: '" + nodes_[at].id + "'";
    nodes_[at].state = Node::kOpen;
    for (const size_t i : find_inside(nodes_[at])) {
      std::string fault = depth < kDeepest ? visit(i, depth + 1) : describe_depth();
      if (!fault.empty()) return fault;
      nodes_[at].size += nodes_[i].size;
      nodes_[at].depth = std::max(nodes_[at].depth, nodes_[i].depth + 1);
    }
    nodes_[at].state = Node::kDone;
    return nodes_[at].depth > kDeepest ? describe_depth() : "";
  }

  std::vector<Node> nodes_;
  std::map<std::string, size_t> shared_, first_;  // by id at the top of <library_nodes>; by id or name anywhere
  std::vector<size_t> open_;                      // nodes around the place that is read
  bool library_ = false;
};

// What the geometry of a file says: lists of whole numbers (corners of faces, how many each face has; the same of a
// skin's weights), arrays of numbers, and accessors, which say where in an array a vertex is.
class Numbers {
 public:
  std::string find_fault(const std::string& text) {
    for (size_t at = text.find('<'); at < text.size() && fault_.empty();) {
      const size_t end = find_end(text, at), next = std::min(text.find('<', end), text.size());
      if (text.compare(at, 9, "<![CDATA[") == 0)
        check_list(text.substr(at + 9, std::min(text.find("]]>", at), text.size()) - at - 9));
      else if (text.compare(at, 2, "<!") != 0)
        take_tag(text.substr(at + 1, end - at - 1));
      check_list(text.substr(end, next - end));
      at = next;
    }
    for (const Accessor& accessor : accessors_) check_accessor(accessor);
    return fault_;
  }

 private:
  struct Accessor {
    std::string array;
    double offset = 0.0, count = 0.0, stride = 1.0, params = 0.0;
  };

  void take_tag(const std::string& tag) {
    const std::string name = find_name(tag);
    if (name == "float_array") take_array(find_attribute(tag, "id"), read_count(tag, "count", 0.0));
    if (name == "accessor" && around_ > 0) {
      const std::string source = find_attribute(tag, "source");
      accessors_.push_back({source.substr(source.empty() ? 0 : 1), read_count(tag, "offset", 0.0),
                            read_count(tag, "count", 0.0), read_count(tag, "stride", 1.0)});
    }
    if (name == "param" && around_ > 0 && !accessors_.empty()) accessors_.back().params += 1.0;
    if (is_empty_element(tag)) return;
    if (name == "mesh" || name == "vertex_weights") ++around_;
    if (name == "/mesh" || name == "/vertex_weights") --around_;
    if (around_ > 0 && (name == "p" || name == "v" || name == "vcount")) list_ = name;
    if (name == "/" + list_) list_.clear();
  }

  // Of two arrays with the same name, the shorter one.
  void take_array(const std::string& id, double count) {
    const auto [at, added] = arrays_.emplace(id, count);
    if (!added) at->second = std::min(at->second, count);
  }

  double read_count(const std::string& tag, const std::string& name, double usual) {
    const std::string text = find_attribute(tag, name);
    if (text.empty()) return usual;
    if (text.find_first_not_of("0123456789") == std::string::npos && text.size() < 10) return std::stod(text);
    refuse("has " + name + "='" + text.substr(0, kShown) + "': expected a whole number of at most nine digits");
    return usual;
  }

  void check_list(const std::string& part) {
    const size_t at = list_.empty() ? std::string::npos : part.find_first_not_of("0123456789+- \t\r\n");
    if (at == std::string::npos) return;
    const size_t end = part.find_first_of(" \t\r\n", at);
    refuse("has '" + part.substr(at, std::min(end - at, kShown)) + "' in a list of whole numbers, <" + list_ + ">");
  }

  void check_accessor(const Accessor& a) {
    const auto array = arrays_.find(a.array);
    const double there = array == arrays_.end() ? 0.0 : array->second;
    // Without named values, Assimp still reads the first one.
    if (a.count > 0.0 && a.offset + (a.count - 1.0) * a.stride + std::max(1.0, a.params) > there)
      refuse("has an array '" + a.array + "' of fewer numbers than its accessor reads");
  }

  void refuse(const std::string& fault) {
    if (fault_.empty()) fault_ = fault;
  }

  static constexpr size_t kShown = 20;  // letters of what is no number
  int around_ = 0;                      // elements that have such lists
  std::string list_, fault_;            // the element that is read; the first fault
  std::map<std::string, double> arrays_;
  std::vector<Accessor> accessors_;
};

}  // namespace

std::string find_node_fault(const std::string& collada) {
  Scene scene;
  return scene.read(collada) ? scene.find_fault() : describe_depth();
}

std::string find_number_fault(const std::string& collada) { return Numbers().find_fault(collada); }

}  // namespace hrp
