// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/mjcf/mjcf_text.h"

#include <filesystem>

#include <tinyxml2.h>

#include "servers/model_parser/xml_values.h"

namespace hrp {
namespace {

using Element = tinyxml2::XMLElement;

const Element* find_first(const Element& root, const char* group, const char* name) {
  const Element* found = root.FirstChildElement(group);
  return found == nullptr || name == nullptr ? found : found->FirstChildElement(name);
}

class Reader {
 public:
  MjcfText read(const std::string& text) {
    tinyxml2::XMLDocument document;
    if (document.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS) return std::move(result_);
    Element* root = document.RootElement();
    if (root == nullptr) return std::move(result_);
    read_meshes(*root);
    walk(root);
    tinyxml2::XMLPrinter printer(nullptr, true);
    document.Print(&printer);
    result_.with_spheres = printer.CStr();
    return std::move(result_);
  }

 private:
  void walk(Element* at) {
    const std::string name = get_attribute(*at, "name");
    if (!name.empty()) result_.lines.emplace(std::make_pair(std::string(at->Name()), name), at->GetLineNum());
    if (std::string(at->Name()) == "geom" && at->Attribute("mesh") != nullptr) {
      at->DeleteAttribute("mesh");
      at->SetAttribute("type", "sphere");
      at->SetAttribute("size", "0.01");
    }
    for (Element* child = at->FirstChildElement(); child != nullptr; child = child->NextSiblingElement()) walk(child);
  }

  void read_meshes(const Element& root) {
    std::string folder;
    for (const Element* c = root.FirstChildElement("compiler"); c != nullptr; c = c->NextSiblingElement("compiler")) {
      if (c->Attribute("assetdir") != nullptr) folder = get_attribute(*c, "assetdir");
      if (c->Attribute("meshdir") != nullptr) folder = get_attribute(*c, "meshdir");
    }
    const Element* common = find_first(root, "default", "mesh");
    for (const Element* a = root.FirstChildElement("asset"); a != nullptr; a = a->NextSiblingElement("asset")) {
      for (const Element* m = a->FirstChildElement("mesh"); m != nullptr; m = m->NextSiblingElement("mesh")) {
        add_mesh(*m, common, folder);
      }
    }
  }

  void add_mesh(const Element& element, const Element* common, const std::string& folder) {
    const std::filesystem::path file = get_attribute(element, "file");
    if (file.empty() || element.Attribute("class") != nullptr || element.Attribute("refpos") != nullptr ||
        element.Attribute("refquat") != nullptr) {
      return;
    }
    MjcfMesh mesh;
    mesh.file = (std::filesystem::path(folder) / file).lexically_normal().string();
    const char* scale = element.Attribute("scale");
    if (scale == nullptr && common != nullptr) scale = common->Attribute("scale");
    if (scale != nullptr) {
      const std::vector<double> numbers = parse_numbers(scale, 3);
      if (numbers.empty()) return;
      mesh.scale = {numbers[0], numbers[1], numbers[2]};
    }
    const std::string name = get_attribute(element, "name");
    result_.meshes[name.empty() ? file.stem().string() : name] = mesh;
  }

  MjcfText result_;
};

}  // namespace

int MjcfText::find_line(const std::string& kind, const std::string& name) const {
  const auto found = lines.find({kind, name});
  return found == lines.end() ? 0 : found->second;
}

MjcfText read_mjcf_text(const std::string& text) { return Reader().read(text); }

}  // namespace hrp
