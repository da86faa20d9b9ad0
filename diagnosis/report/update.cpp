// SPDX-License-Identifier: BSD-3-Clause
// The updated experiment: the same scenario with what was found, ready to be simulated.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "common/base/ends_with.h"
#include "common/base/write_file.h"
#include "common/robot/yaml_sections.h"
#include "diagnosis/data/csv_layout.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/export/take_home.h"
#include "diagnosis/page/page.h"
#include "diagnosis/report/first.h"
#include "diagnosis/report/print_json.h"
#include "diagnosis/report/report.h"
#include "servers/dynamics/joint_effects.h"
#include "servers/model_parser/mesh_path.h"

namespace hrp::diagnosis {
namespace {

namespace fs = std::filesystem;

// Light soles below a bush chatter on a hard floor without a margin (docs/scenario.md).
constexpr const char* kSoftContact = "contact: {margin: 0.001}\n";
constexpr int kExact = 10;  // digits of times and commands that are replayed

// The experiment's text in parts: what stays as it is, what it has under `effects:`, and the top-level keys of both.
struct ScenarioText {
  std::string kept, effects;
  std::set<std::string> keys;
};

// What is replaced: the robot (copied beside), the recordings, what moved the robot, and `also`.
ScenarioText split(const std::string& text, const std::set<std::string>& also) {
  std::set<std::string> dropped{"robot",      "recordings", "columns",       "topics",
                                "controller", "steps",      "interpolation", "logging"};
  dropped.insert(also.begin(), also.end());
  ScenarioText out;
  for (const YamlSection& section : split_sections(text)) {
    if (dropped.count(section.key) > 0) continue;
    if (!section.key.empty()) out.keys.insert(section.key);
    if (section.key == "effects")
      out.effects += list_items(section, text);
    else
      out.kept += section.text;
  }
  return out;
}

// How a sole gives in height a standing robot hardly shows, how it tilts a foot on a rail, and the simulator needs
// numbers: 3e5 N/m, and critical damping of 2 kg, a tenth of what a foot of a small robot carries; 1e4 N m/rad.
void complete_sole(Json* parameters) {
  if (!parameters->contains("k_roll") && !parameters->contains("k_pitch")) {
    (*parameters)["k_roll"] = (*parameters)["k_pitch"] = 1e4;
    (*parameters)["c_roll"] = (*parameters)["c_pitch"] = 1.0;
  }
  if (!parameters->contains("kz")) (*parameters)["kz"] = 3e5;
  if (!parameters->contains("cz")) (*parameters)["cz"] = 2 * std::sqrt((*parameters)["kz"].get<double>() * 2.0);
}

// Two encoders tell how a transmission gives; the rotor behind it is a finding of its own at the same joint.
void add_found_rotor(const nlohmann::json& finding, const nlohmann::json& list, Json* parameters) {
  if (parameters->contains("rotor_inertia")) return;
  for (const nlohmann::json& other : list) {
    if (other.at("effect") != "rotor_inertia" || other.at("where") != finding.at("where")) continue;
    const nlohmann::json& inertia = other.at("parameters").at("inertia");
    (*parameters)["rotor_inertia"] = inertia.is_object() ? inertia.at("value") : inertia;
  }
}

// [kg m^2] As the model has it; 0 where it has none.
double find_nominal_rotor(const Scenario& scenario, const TreeSpec& tree, const std::string& name) {
  const auto stated = scenario.rotor_inertia.find(name);
  if (stated != scenario.rotor_inertia.end()) return stated->second;
  const int joint = tree.find_joint(name);
  return joint < 0 ? 0.0 : tree.joint(joint).rotor_inertia;
}

// A foot's tilt tells only how far a joint gives. The simulator needs a rotor behind it, too, and damping: those that
// fits start from, about the model's own rotor.
void complete_transmission(const nlohmann::json& finding, double rotor, Json* parameters) {
  if (!parameters->contains("stiffness") || !(parameters->at("stiffness").get<double>() > 0)) return;
  const EffectInfo& row = *find_effect(finding.at("effect").get<std::string>());
  std::vector<double> values(row.parameters.size());
  row.give.make_parameters(rotor, 1.0 / parameters->at("stiffness").get<double>(), values.data());
  for (size_t i = 0; i < values.size(); ++i) {
    if (!parameters->contains(row.parameters[i].name)) (*parameters)[row.parameters[i].name] = values[i];
  }
}

// An element of `effects`, and those of its parameters that no recording told.
struct EffectLine {
  std::string text;
  std::vector<std::string> assumed;
};

// Noise may leave a sole's damping below 0: it is cut to the sole without it. A stiffness that the law cannot have
// stays: the scenario refuses it with a reason.
Json cut_to_law(const EffectInfo& effect, const std::string& name, Json value) {
  const int at = find_parameter(effect, name);
  if (effect.place != PlaceKind::kFoot || at < 0 || !value.is_number()) return value;
  const bool may_be_none = effect.parameters[static_cast<size_t>(at)].lower == 0.0;
  return may_be_none && value.get<double>() < 0.0 ? Json(0.0) : value;
}

// A finding without its intervals. JSON is YAML, too, and quotes every name.
EffectLine make_effect_line(const nlohmann::json& finding, const nlohmann::json& list, const Scenario& scenario,
                            const TreeSpec& tree) {
  const EffectInfo& effect = *find_effect(finding.at("effect").get<std::string>());
  Json parameters = Json::object();
  for (const auto& [name, p] : finding.at("parameters").items()) {
    parameters[name] = cut_to_law(effect, name, p.is_object() && p.contains("value") ? p.at("value") : p);
  }
  if (finding.contains("also_fitted")) {
    for (const auto& [name, value] : finding.at("also_fitted").items()) parameters[name] = value;
  }
  const bool elastic = finding.at("effect") == "joint_elasticity";
  if (elastic) add_found_rotor(finding, list, &parameters);
  const Json found = parameters;
  if (finding.at("where").contains("foot")) complete_sole(&parameters);
  if (elastic)
    complete_transmission(finding, find_nominal_rotor(scenario, tree, finding.at("where").value("joint", "")),
                          &parameters);
  EffectLine out;
  for (const auto& [name, value] : parameters.items()) {
    if (!found.contains(name)) out.assumed.push_back(name);
  }
  out.text = "  - " +
             Json{{"effect", finding.at("effect")}, {"where", finding.at("where")}, {"parameters", parameters}}.dump();
  return out;
}

// Behind an element of `effects`: "  # ambiguous; assumed: damping, rotor_inertia".
std::string make_comment(const std::string& grade, const std::vector<std::string>& assumed) {
  std::string out = grade;
  for (size_t i = 0; i < assumed.size(); ++i)
    out += (i > 0 ? ", " : out.empty() ? "assumed: " : "; assumed: ") + assumed[i];
  return (out.empty() ? "" : "  # ") + out + "\n";
}

bool is_listed(const nlohmann::json& list, const nlohmann::json& finding) {
  return std::any_of(list.begin(), list.end(), [&](const nlohmann::json& other) {
    return other.at("effect") == finding.at("effect") && other.at("where") == finding.at("where");
  });
}

// The best model that was found, whatever its effects are called, and findings that no simulator knows, as notes;
// without a model the findings.
nlohmann::json list_effects(const nlohmann::json& report) {
  const nlohmann::json& findings = report.at("findings");
  if (!report.contains("model") || report.at("model").empty()) return findings;
  nlohmann::json list = report.at("model");
  for (const nlohmann::json& finding : findings) {
    if (!find_effect(finding.at("effect").get<std::string>()) && !is_listed(list, finding)) list.push_back(finding);
  }
  return list;
}

std::string make_note(const nlohmann::json& effect, const std::string& why) {
  std::string place = effect.at("where").empty() ? "the world" : effect.at("where").begin()->get<std::string>();
  return "# not simulated: " + effect.at("effect").get<std::string>() + " at " + place + ": " + why +
         "; see report.json\n";
}

// A fault of the joints' log: what the driver writes is not what its servo reads.
bool is_of_log(const nlohmann::json& effect) {
  const std::string sensor = effect.at("where").value("sensor", "");
  return sensor == "/joint_states" || sensor.rfind("/joint_states/", 0) == 0 || sensor.rfind("/joint_commands", 0) == 0;
}

// Throws InputError where the simulator would refuse the scenario: a transmission that gives needs a rotor behind it.
void check_simulated(const std::string& text, const TreeSpec& tree, const std::string& path) {
  const Scenario scenario = parse_scenario(text, path);
  TreeSpec own = tree;
  make_joint_laws(scenario, &own);
}

// Servos that were found in the place of perfect joints. Joints whose own do not show get the median of the others.
std::string make_servos(const nlohmann::json& findings) {
  std::vector<double> kp, kd;
  std::string joints;
  for (const nlohmann::json& f : findings) {
    if (f.at("effect") != "joint_servo") continue;
    const nlohmann::json& p = f.at("parameters");
    kp.push_back(p.at("kp").at("value").get<double>());
    kd.push_back(p.at("kd").at("value").get<double>());
    joints += "    " + f.at("where").at("joint").get<std::string>() + ": {kp: " + number(kp.back(), 6) +
              ", kd: " + number(kd.back(), 6) + "}\n";
  }
  if (kp.empty()) return "";
  return "servo:  # found\n  default: {kp: " + number(find_median(kp), 6) + ", kd: " + number(find_median(kd), 6) +
         "}\n  joints:\n" + joints;
}

// Every effect that the simulator has a law for, with its grade; the others as comments that say why not. Transmissions
// that give come last: the inertia of their rotors may be a finding, too.
std::string make_effects(const std::string& scenario, const std::string& before, nlohmann::json list,
                         const Experiment& e, const std::string& path) {
  std::string effects = before, notes;
  std::stable_partition(list.begin(), list.end(), [](const nlohmann::json& effect) {
    const EffectInfo* info = find_effect(effect.at("effect").get<std::string>());
    return !info || !info->flexible;
  });
  for (const nlohmann::json& effect : list) {
    if (effect.at("effect") == "joint_servo") continue;  // make_servos()
    if (!find_effect(effect.at("effect").get<std::string>())) {
      notes += make_note(effect, "the simulator has no such law");
      continue;
    }
    if (is_of_log(effect)) {
      notes += make_note(effect, "a fault of the log, not of the robot");
      continue;
    }
    if (effect.value("drifts", false)) {
      notes += make_note(effect, "it drifts, and the simulator's is constant");
      continue;
    }
    const EffectLine line = make_effect_line(effect, list, e.scenario, e.robot.tree);
    try {
      check_simulated(scenario + "effects:\n" + effects + line.text + "\n", e.robot.tree, path);
      effects += line.text + make_comment(effect.value("grade", ""), line.assumed);
    } catch (const InputError& error) {
      std::string why = error.what();
      std::replace(why.begin(), why.end(), '\n', ' ');
      notes += make_note(effect, why);
    }
  }
  return (effects.empty() ? "" : "effects:\n" + effects) + notes;
}

// Control period of the replay [s]: whole tenths of a millisecond.
double find_period(const Experiment& e) { return 1e-4 * std::max(1.0, std::round(1e4 * e.sample_time)); }

// The motion that is replayed: commands where they were recorded, else positions; empty when there is neither.
// A controller answers a sample with what is reached one period later, so frames stand that much ahead.
std::string make_motion(const Experiment& e, const Recording& recording) {
  std::string text = "time";
  std::vector<const std::vector<double>*> columns;
  for (int j = 0; j < e.num_joints(); ++j) {
    const JointColumns& joint = recording.joints[static_cast<size_t>(j)];
    const std::vector<double>& column = joint.command.empty() ? joint.signal[0] : joint.command;
    if (column.empty()) continue;
    text += "," + e.robot.tree.joint(j).name;
    columns.push_back(&column);
  }
  if (columns.empty()) return "";
  const double begin = recording.time[0] + find_period(e);
  for (size_t k = 0; k < recording.size(); ++k) {
    if (recording.time[k] < begin - 1e-9) continue;
    std::string line = "\n" + number(std::max(0.0, recording.time[k] - begin), kExact);
    bool complete = true;
    for (const auto* column : columns) {
      complete = complete && std::isfinite((*column)[k]);
      line += "," + number((*column)[k], kExact);
    }
    if (complete) text += line;
  }
  return text + "\n";
}

// True if the first line names the columns as the recording does. Separators, names and dates of other people's text,
// and its columns by number, are known to the experiment alone.
bool has_own_header(const Recording& recording) {
  std::ifstream file = open_text(recording.spec.file);
  std::string line;
  while (std::getline(file, line) && is_blank(line)) continue;
  CsvLayout commas;
  std::vector<Cell> cells;
  std::vector<std::string> names;
  split_cells(commas, line, &cells);
  for (const Cell& cell : cells) names.push_back(trim_cell(cell));
  while (std::getline(file, line) && is_blank(line)) continue;
  split_cells(commas, line, &cells);
  const size_t time = static_cast<size_t>(std::find(names.begin(), names.end(), "time") - names.begin());
  double stamp = 0.0;
  if (time >= cells.size() || !parse_cell(cells[time], ',', &stamp)) return false;
  return std::all_of(recording.column_of.begin(), recording.column_of.end(), [&](const auto& column) {
    const size_t number = static_cast<size_t>(column.second);
    return number >= 1 && number <= names.size() && names[number - 1] == column.first;
  });
}

// Bags, parts of long files and other people's text cannot be compared with a simulation by their own files.
bool is_whole_file(const Recording& recording) {
  std::error_code error;
  const std::string& file = recording.spec.file;
  return fs::is_regular_file(file, error) && recording.spec.name.find(" (") == std::string::npos &&
         (ends_with(file, ".mcap") || has_own_header(recording));
}

// The readings as text, so that anything can compare a simulation with them.
std::string make_recorded(const Experiment& e, const Recording& recording) {
  std::string text = "time";
  std::vector<const std::vector<double>*> columns;
  for (int j = 0; j < e.num_joints(); ++j) {
    for (int q = 0; q < kQuantities; ++q) {
      const std::vector<double>& column = recording.joints[static_cast<size_t>(j)].signal[q];
      if (column.empty()) continue;
      text += "," + e.signal_name(j, static_cast<Quantity>(q));
      columns.push_back(&column);
    }
  }
  for (const auto& [name, column] : recording.other) {
    if (name.rfind('/', 0) != 0 || column.size() != recording.size()) continue;
    text += "," + name;
    columns.push_back(&column);
  }
  for (size_t k = 0; k < recording.size(); ++k) {
    text += "\n" + number(recording.time[k] - recording.time[0], kExact);
    for (const auto* column : columns) text += std::isfinite((*column)[k]) ? "," + number((*column)[k], kExact) : ",";
  }
  return text + "\n";
}

// Where the replayed recording begins, if that is not where the scenario does: a robot that jumps to its first sample
// is thrown. A robot on the ground is put on its lowest foot.
std::string make_start(const Experiment& e, const Recording& recording) {
  Json joints = Json::object();
  bool jumps = false;
  for (int j = 0; j < e.num_joints(); ++j) {
    const std::vector<double>& q = recording.joints[static_cast<size_t>(j)].signal[0];
    const auto first = std::find_if(q.begin(), q.end(), [](double x) { return std::isfinite(x); });
    if (first == q.end()) return "";
    const std::string& name = e.robot.tree.joint(j).name;
    const auto stated = e.scenario.initial_joints.find(name);
    // What hardly moves a joint, its servo makes good without a knock.
    jumps =
        jumps || std::abs(*first - (stated == e.scenario.initial_joints.end() ? 0.0 : stated->second)) > kHardlyMoved;
    joints[name] = *first;
  }
  if (!jumps) return "";
  const Vector3d& p = e.scenario.initial_position;
  const Vector3d& rpy = e.scenario.initial_rpy;
  Json start{{"rpy", {rpy.x(), rpy.y(), rpy.z()}}, {"joints", joints}};
  const bool stands = e.scenario.floating_base && e.scenario.ground.present && !e.scenario.feet.empty();
  if (e.scenario.initial_height_given && !stands) start["position"] = {p.x(), p.y(), p.z()};
  return "initial: " + start.dump() + "\n";
}

// Steps of at most one millisecond, of which the period has to be a multiple.
std::string make_steps(const Experiment& e, const Recording& recording) {
  const double period = find_period(e);
  const double step = period / std::ceil(period / 1e-3 - 1e-9);
  return "steps: {time_step: " + number(step, kExact) + ", control_period: " + number(period, kExact) +
         ", duration: " + number(period * std::floor(recording.duration() / period), kExact) +
         "}\ninterpolation: hermite\n";
}

// A recording that nothing was fitted to, where there is one; none that a hand moved or loaded, as long as there is
// another.
const Recording& find_replayed(const Experiment& e) {
  for (bool held : {true, false}) {
    for (const Recording& r : e.recordings) {
      if (r.spec.unknown_force.empty() && r.spec.loads.empty() && r.spec.pushes.empty() && (!held || !r.spec.train))
        return r;
    }
  }
  return e.recordings.front();
}

// A scenario that its own reader refuses is no reason to lose the report.
void write_exports(const fs::path& folder) {
  try {
    write_take_home(folder.string());
  } catch (const std::exception& error) {
    fs::create_directories(folder / "export");
    write_file(folder / "export" / "README.txt", std::string("Nothing was exported: ") + error.what() + "\n");
  }
}

// Joints without servos do not follow the recorded positions.
bool is_limp(const Experiment& e) { return e.scenario.drive == "effort"; }

// The URDF with the full path of each mesh, which was found from the folder of the original.
std::string name_meshes(std::string urdf, const std::string& urdf_path) {
  const std::string attribute = "filename=";
  for (size_t at = urdf.find("<mesh"); at != std::string::npos; at = urdf.find("<mesh", at + 1)) {
    const size_t name = urdf.find(attribute, at);
    if (name == std::string::npos || name > urdf.find('>', at)) continue;
    const size_t begin = name + attribute.size() + 1;
    const size_t end = urdf.find(urdf[begin - 1], begin);
    if (end == std::string::npos) break;
    const std::string file = find_mesh(urdf.substr(begin, end - begin), urdf_path);
    if (!file.empty()) urdf.replace(begin, end - begin, file);
  }
  return urdf;
}

std::string write_updated(const Experiment& e, const nlohmann::json& report, const std::string& urdf,
                          const fs::path& folder) {
  fs::create_directories(folder);
  write_file(folder / "robot.urdf", name_meshes(urdf.empty() ? e.robot.urdf : urdf, e.robot.urdf_path));
  const Recording* replayed = &find_replayed(e);
  const std::string servos = make_servos(report.at("findings")), start = make_start(e, *replayed);
  std::set<std::string> also;
  if (!start.empty()) also.insert("initial");
  const ScenarioText parts = split(e.scenario.text, also);
  const std::string use = is_limp(e) ? "'drive: effort' has no servo: it needs a controller that sends torques"
                                     : "replays " + replayed->spec.name;
  const std::string head = "# The experiment's scenario with what was found; " + use + ".\nrobot: robot.urdf\n";
  std::string tail = start;
  const std::string motion = make_motion(e, *replayed);
  if (!motion.empty()) {
    write_file(folder / "motion.csv", motion);
    tail += "controller: {motion: motion.csv}\n";
  }
  tail += make_steps(e, *replayed);
  if (parts.keys.count("contact") == 0 && !e.scenario.feet.empty()) tail += kSoftContact;
  write_file(folder / "nominal.yaml",
             head + parts.kept + tail + (parts.effects.empty() ? "" : "effects:\n" + parts.effects));
  const fs::path path = folder / "scenario.yaml";
  if (!servos.empty()) also.insert({"servo", "perfect_joints"});
  const std::string kept = split(e.scenario.text, also).kept;
  std::string text = head + kept + servos + tail;
  text += make_effects(text, parts.effects, list_effects(report), e, path.string());
  write_file(path, text);
  write_exports(folder);
  return text;
}

}  // namespace

std::string make_scenario_text(const Experiment& e, const nlohmann::json& effects) {
  const ScenarioText parts = split(e.scenario.text, {});
  std::string text = "robot: " + Json(e.scenario.robot).dump() + "\n" + parts.kept + make_steps(e, find_replayed(e));
  if (parts.keys.count("contact") == 0 && !e.scenario.feet.empty()) text += kSoftContact;
  return text + make_effects(text, parts.effects, effects, e, e.scenario.path);
}

void write_first_report(const std::string& folder, const Reports& reports) {
  prepare_folder(folder);
  write_file(fs::path(folder) / "report.json", print_json(reports.report, 1) + "\n");
  write_html_report(copy_json(reports.report), copy_json(reports.series), (fs::path(folder) / "report.html").string());
}

void write_reports(const Experiment& e, const std::string& folder, Reports reports) {
  prepare_folder(folder);
  const nlohmann::json report = copy_json(reports.report);
  const std::string text = write_updated(e, report, reports.urdf, fs::path(folder) / "updated");
  const Recording& replayed = find_replayed(e);
  std::string replays = replayed.spec.file;
  if (!is_whole_file(replayed)) {
    replays = fs::absolute(fs::path(folder) / "updated" / "recorded.csv").string();
    write_file(replays, make_recorded(e, replayed));
  }
  reports.series["updated"] = {
      {"folder", "updated"},
      {"scenario", "updated/scenario.yaml"},
      {"text", text},
      {"replays", replays},
      {"command", "scripts/simulate.sh " + (fs::path(folder) / "updated/scenario.yaml").string()}};
  if (is_limp(e)) reports.series["updated"]["limp"] = true;
  write_file(fs::path(folder) / "report.json", print_json(reports.report, 1) + "\n");
  write_file(fs::path(folder) / "series.json", print_json(reports.series) + "\n");
  write_html_report(report, copy_json(reports.series), (fs::path(folder) / "report.html").string());
}

}  // namespace hrp::diagnosis
