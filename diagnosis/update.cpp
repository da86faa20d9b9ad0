// SPDX-License-Identifier: BSD-3-Clause
// The updated experiment: the same scenario with what was found, and a URDF with changed masses.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include "diagnosis/report.h"
#include "diagnosis/report_html.h"

namespace hrp::diagnosis {
namespace {

namespace fs = std::filesystem;

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.flush();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

std::string make_inertial(const LinkInertia& inertia) {
  const Matrix3d& I = inertia.I_LLcm_L;
  const Vector3d& c = inertia.p_LLcm_L;
  return "<inertial><origin xyz=\"" + number(c.x()) + " " + number(c.y()) + " " + number(c.z()) + "\" rpy=\"0 0 0\"/><mass value=\"" +
         number(inertia.mass) + "\"/><inertia ixx=\"" + number(I(0, 0)) + "\" ixy=\"" + number(I(0, 1)) + "\" ixz=\"" + number(I(0, 2)) +
         "\" iyy=\"" + number(I(1, 1)) + "\" iyz=\"" + number(I(1, 2)) + "\" izz=\"" + number(I(2, 2)) + "\"/></inertial>";
}

// Replaces the <inertial> of a link in the URDF text; false when the link has no plain one.
bool replace_inertial(const std::string& link, const LinkInertia& inertia, std::string* urdf) {
  const size_t begin = urdf->find("<link name=\"" + link + "\"");
  if (begin == std::string::npos) return false;
  const size_t end = urdf->find("</link>", begin), from = urdf->find("<inertial>", begin);
  if (end == std::string::npos || from == std::string::npos || from > end) return false;
  const size_t to = urdf->find("</inertial>", from);
  if (to == std::string::npos || to > end) return false;
  urdf->replace(from, to + 11 - from, make_inertial(inertia));
  return true;
}

// The lines of the experiment without its top-level `robot` and `recordings`.
std::string strip_keys(const std::string& text) {
  std::istringstream in(text);
  std::string line, out;
  bool skip = false;
  while (std::getline(in, line)) {
    const bool top = !line.empty() && line[0] != ' ' && line[0] != '-' && line[0] != '#' && line[0] != '\t';
    if (top) skip = line.rfind("robot:", 0) == 0 || line.rfind("recordings:", 0) == 0 || line.rfind("joint_laws:", 0) == 0;
    if (!skip) out += line + "\n";
  }
  return out;
}

std::string make_laws(const Experiment& e, const Hypothesis& found, std::vector<std::string>* notes) {
  std::map<std::string, std::string> laws;
  for (const Effect& effect : found) {
    const EffectInfo& info = get_effect(effect.id);
    if (info.place == PlaceKind::kJoint) {
      std::string& text = laws[get_place_text(e, effect)];
      text += (text.empty() ? "" : ", ") + std::string(info.name) + ": {";
      bool first = true;
      for (size_t i = 0; i < effect.p.size(); ++i) {
        if (std::string(info.parameters[i].name) == "stick_speed") continue;
        text += (first ? "" : ", ") + std::string(info.parameters[i].name) + ": " + number(effect.p[i]);
        first = false;
      }
      text += "}";
    } else if (info.place != PlaceKind::kLink || effect.id == EffectId::kExternalForce) {
      notes->push_back("# " + get_label(e, effect) + " is not part of a scenario: see report.json");
    }
  }
  std::string text;
  for (const auto& item : laws) text += (text.empty() ? "joint_laws:\n" : "") + std::string("  ") + item.first + ": {" + item.second + "}\n";
  return text;
}

std::string write_updated(const Problem& problem, const Hypothesis& found, const std::vector<std::string>& lines, const fs::path& folder) {
  const Experiment& e = *problem.experiment;
  fs::create_directories(folder);
  std::string urdf = e.robot.urdf;
  const Plant plant = make_plant(e, found);
  std::vector<std::string> notes;
  for (const Effect& effect : found) {
    if (get_effect(effect.id).place != PlaceKind::kLink || effect.id == EffectId::kExternalForce) continue;
    const std::string link = get_place_text(e, effect);
    if (!replace_inertial(link, plant.tree.links[static_cast<size_t>(effect.place)].inertia, &urdf)) {
      notes.push_back("# the URDF's link " + link + " has no inertial element to change: see report.json");
    }
  }
  write_text(folder / "robot.urdf", urdf);
  std::string text = "# The experiment's scenario with what was found.\nrobot: robot.urdf\n" + strip_keys(e.scenario.text) + make_laws(e, found, &notes);
  for (const std::string& line : lines) text += line + "\n";
  for (const std::string& note : notes) text += note + "\n";
  write_text(folder / "scenario.yaml", text);
  return text;
}

}  // namespace

void write_reports(const Problem& problem, const Hypothesis& found, const std::vector<std::string>& lines, const std::string& folder, Reports reports) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw std::runtime_error(folder + ": cannot be made: " + error.message());
  const std::string text = write_updated(problem, found, lines, fs::path(folder) / "updated");
  reports.series["updated"] = {{"folder", "updated"}, {"scenario", "updated/scenario.yaml"}, {"text", text},
                               {"command", "scripts/simulate.sh " + (fs::path(folder) / "updated/scenario.yaml").string()}};
  write_text(fs::path(folder) / "report.json", reports.report.dump(1) + "\n");
  write_text(fs::path(folder) / "series.json", reports.series.dump() + "\n");
  write_html_report(nlohmann::json::parse(reports.report.dump()), nlohmann::json::parse(reports.series.dump()), (fs::path(folder) / "report.html").string());
}

}  // namespace hrp::diagnosis
