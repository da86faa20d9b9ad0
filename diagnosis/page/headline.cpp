// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/page/headline.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>

#include "common/base/ends_with.h"
#include "common/base/join_words.h"
#include "diagnosis/page/fit_words.h"
#include "diagnosis/page/lead.h"

namespace hrp::diagnosis::html {
namespace {

constexpr size_t kFew = 3;         // findings that are told one by one, and places that are named
constexpr size_t kMostGroups = 5;  // effects that are told with their values
const char* const kCounts = "counts/N";
const char* const kTurned = "turned";  // in place of a unit: efforts whose sign is turned are no scale that is off
constexpr double kDetail = 0.02;       // of the weight of all findings: less is named without values

struct Group {
  std::string effect, unit;  // unit: only of raw counts and turned signs, which are told apart from a scale that is off
  std::vector<const json*> findings;
  double weight = 0.0;
  double probability = 0.0;  // the largest
  bool sure = false;         // physics or a fault that takes something away, told from all else at one place at least
};

bool is_ambiguous(const json& finding) { return get_text(finding, "grade") == "ambiguous"; }

double get_weight(const json& finding) {
  return std::max(0.0, get_number(finding, "weight", get_number(finding, "share", 0.0)));
}

bool is_of_log(const json& finding) { return get_object(finding, "where").contains("sensor"); }

std::string get_unit(const json& finding) {
  const auto parameters = list_parameters(finding);
  return parameters.empty() ? "" : get_text(parameters[0].second, "unit");
}

// The first number of the first parameter.
double get_value(const json& finding) {
  const auto parameters = list_parameters(finding);
  return parameters.empty() ? kNone : get_number(parameters[0].second, "value");
}

// True for a log that holds the effort with the opposite sign.
bool is_turned_effort(const json& finding) {
  return ends_with(get_text(get_object(finding, "where"), "sensor"), "/effort") && get_value(finding) == -1.0;
}

std::string get_kind(const json& finding) {
  if (is_turned_effort(finding)) return kTurned;
  return get_unit(finding) == kCounts ? kCounts : "";
}

std::vector<Group> group_by_effect(const json& report) {
  std::vector<Group> groups;
  for (const json& f : get_list(report, "findings")) {
    const std::string effect = get_text(f, "effect"), unit = get_kind(f);
    const auto same = std::find_if(groups.begin(), groups.end(),
                                   [&](const Group& g) { return g.effect == effect && g.unit == unit; });
    Group& group = same == groups.end() ? groups.emplace_back(Group{effect, unit, {}, 0.0}) : *same;
    group.findings.push_back(&f);
    group.weight += get_weight(f);
    group.probability = std::max(group.probability, get_number(f, "probability", 0.0));
    group.sure = group.sure || (!is_ambiguous(f) && (get_weight(f) > 0.0 || !is_of_log(f)));
  }
  // What is sure first: a foot that gives weighs nothing in torques.
  std::stable_sort(groups.begin(), groups.end(), [](const Group& a, const Group& b) {
    return std::tie(b.sure, b.weight, b.probability) < std::tie(a.sure, a.weight, a.probability);
  });
  return groups;
}

bool is_in_log_unit(const json& finding) { return get(finding, "in_log_unit") == json(true); }

// "level 0.14 to 1.3 N m, most at joint elbow"; of one place or one value for all: with its interval.
std::string describe_values(const std::vector<const json*>& findings) {
  const bool alike = std::all_of(findings.begin(), findings.end(), [&](const json* f) {
    return get(*f, "parameters") == get(*findings[0], "parameters");
  });
  if (alike) return describe_parameters(*findings[0]) + (findings.size() > 1 ? " at each" : "");
  double low = std::numeric_limits<double>::infinity(), high = -low;
  const json* highest = nullptr;
  for (const json* f : findings) {
    const double value = get_value(*f);
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    if (value > high) {
      high = value;
      highest = f;
    }
  }
  if (!highest) return "";
  const auto [name, parameter] = list_parameters(*highest)[0];
  const std::string unit = get_text(parameter, "unit");
  std::string words = name;
  std::replace(words.begin(), words.end(), '_', ' ');
  return words + " " + format_number(low, 2) + " to " + format_number(high, 2) +
         (unit.empty() || unit == "1" ? "" : " " + unit) + (is_in_log_unit(*highest) ? " (unit of the log)" : "") +
         ", most at " + describe_place(get(*highest, "where"));
}

// Values of different units, as of sliding and turning joints, are told apart. So are milliamperes and newton metres:
// values in the unit of a log are no larger or smaller than others.
std::string describe(const std::vector<const json*>& findings) {
  std::map<std::pair<bool, std::string>, std::vector<const json*>> by_unit;
  for (const json* f : findings) by_unit[{is_in_log_unit(*f), get_unit(*f)}].push_back(f);
  std::string out;
  for (const auto& [unit, same] : by_unit) {
    const std::string values = describe_values(same);
    out += (out.empty() ? "" : ", and at ") + describe_places(same) + (values.empty() ? "" : ": " + values);
  }
  return out;
}

// A check of a robot on its feet states what was measured and what it can be: "The feet carry 1.033 of ...". Others
// begin with their place.
bool is_of_check(const json& finding) {
  const std::string statement = get_text(finding, "statement");
  const json& where = get_object(finding, "where");
  return is_ambiguous(finding) && std::none_of(where.begin(), where.end(), [&](const json& place) {
           return statement.rfind(print_place(place), 0) == 0;
         });
}

// The first sentence; the second as well, if the first is a short one.
std::string cut_statement(const std::string& statement) {
  constexpr size_t kShort = 70;  // letters: half a line of the page
  size_t end = statement.find(". ");
  if (end < kShort) end = statement.find(". ", end + 1);
  return typeset(end == std::string::npos ? statement : statement.substr(0, end + 1));
}

// "Coulomb friction at 10 joints: level ...; perhaps also at joint hip: ...".
std::string make_group_sentence(const Group& group) {
  if (group.findings.size() == 1 && is_of_check(*group.findings[0]))
    return cut_statement(get_text(*group.findings[0], "statement"));
  if (group.unit == kTurned)
    return "The recorded effort has the opposite sign at " + describe_places(group.findings) + ".";
  if (group.unit == kCounts) return "Forces are raw counts, no newtons, at " + describe(group.findings) + ".";
  std::vector<const json*> sure, perhaps;
  for (const json* f : group.findings) (is_ambiguous(*f) ? perhaps : sure).push_back(f);
  if (sure.empty()) return "Perhaps " + describe_effect(group.effect, false) + " at " + describe(perhaps) + ".";
  return describe_effect(group.effect) + " at " + describe(sure) +
         (perhaps.empty() ? "" : "; perhaps also at " + describe(perhaps)) + ".";
}

void add_groups(const json& report, std::vector<std::string>* out) {
  const std::vector<Group> groups = group_by_effect(report);
  double all = 0.0;
  for (const Group& g : groups) all += g.weight;
  std::string smaller;
  size_t told = 0;
  for (const Group& g : groups) {
    if (told < kFew || (told < kMostGroups && g.weight >= kDetail * all)) {
      out->push_back(make_group_sentence(g));
      ++told;
    } else {
      smaller +=
          (smaller.empty() ? "" : ", ") + describe_effect(g.effect, false) + " at " + describe_places(g.findings);
    }
  }
  if (!smaller.empty()) out->push_back("Smaller: " + smaller + ".");
}

// What the updated model has beyond the findings, so that nobody is surprised by its effects: by effect, with places.
std::string make_unnamed_sentence(const json& report) {
  struct Places {
    std::string names;
    size_t count = 0;
  };
  std::map<std::string, Places> all;  // by effect
  for (const json& entry : get_list(report, "model")) {
    if (get_text(entry, "grade").rfind("not named", 0) != 0) continue;
    const json& where = get(entry, "where");
    if (!where.is_object() || where.empty() || !where.begin()->is_string()) continue;
    Places& at = all[describe_effect(get_text(entry, "effect"), false)];
    at.names += (at.count++ > 0 ? ", " : "") + where.begin()->get<std::string>();
  }
  std::string text;
  for (const auto& [effect, at] : all)
    text += (text.empty() ? "" : ", ") + effect + " (" +
            (at.count > kFew ? std::to_string(at.count) + " places" : at.names) + ")";
  return text.empty() ? "" : "The updated model also has, without proof: " + text + ".";
}

std::string list_joints(const json& report, const char* key) { return join_values(get_list(report, key)); }

// "viscous friction at joint servo (coefficient 0.8 N m s/rad) and command delay at ..."
std::string list_set(const json& effects) {
  std::string out;
  for (const json& f : effects)
    out += (out.empty() ? "" : " and ") + describe_effect(get_text(f, "effect"), false) + " at " +
           describe_place(get(f, "where")) + " (" + describe_parameters(f) + ")";
  return out;
}

// "With viscous friction at joint servo (...) and command delay at ..., held-out errors fall: ...".
std::string make_set_sentence(const json& report) {
  std::string errors = make_errors_sentence(report);
  if (errors.empty()) return "";
  errors[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(errors[0])));
  return "With " + list_set(get_list(report, "findings")) + ", " + errors;
}

// What comes closest where nothing is explained: whoever reads on knows what to try first.
std::string make_closest_sentence(const json& report) {
  const json& closest = get(report, "closest");
  const json& effects = get_list(closest, "effects");
  if (effects.empty()) return "";
  std::string text = list_set(effects);
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  const json& rest = get(closest, "times_noise");
  const std::string others =
      join_words(get(closest, "others"), [](const json& label) { return label.get<std::string>(); });
  return text + (effects.size() == 1 ? " comes" : " together come") + " closest: the held-out error falls from " +
         format_number(get_number(rest, "before", 0.0)) + " to " + format_number(get_number(rest, "after", 0.0)) +
         " times the noise. What is left has another cause, so " +
         (effects.size() == 1 ? "it is no finding." : "they are no findings.") +
         (others.empty() ? "" : " About as close: " + others + ".");
}

// Of angles that were taken as the model has them.
std::string make_angle_sentence(const json& report) {
  const std::string text = get_text(report, "angles");
  return text.empty() ? "" : typeset(text) + ". They were converted.";
}

std::string make_unit_sentence(const json& report) {
  const std::string untold = list_joints(report, "untold_units"), least = list_joints(report, "least_units");
  std::string text;
  if (!untold.empty())
    text =
        "This motion does not tell the unit of the effort of " + untold + ": values there are in the unit of the log.";
  if (least.empty()) return text;
  return text + (text.empty() ? "" : " ") + "The unit of the effort of " + least +
         " and the values there are lower bounds: a rotor makes them larger.";
}

// Of recordings in which a joint hardly moves: that nothing explains them says little.
std::string make_short_sentence(const json& report) {
  std::string files;
  for (const json& warning : get_list(report, "warnings")) {
    const std::string text = warning.is_string() ? warning.get<std::string>() : "";
    if (text.find(": too short to show what a model leaves out") != std::string::npos)
      files += (files.empty() ? "" : ", ") + text.substr(0, text.find(':'));
  }
  return files.empty() ? ""
                       : "Recordings that are too short to show what a model leaves out: " + typeset(files) +
                             ". Record seconds of motion.";
}

std::string make_left_sentence(const json& report) {
  const json* worst = nullptr;
  for (const json& r : get_list(report, "remaining")) {
    if (get_number(r, "share", 0.0) < 0.2) continue;
    if (!worst || get_number(r, "share", 0.0) > get_number(*worst, "share", 0.0)) worst = &r;
  }
  return worst ? "Most is left here: " + typeset(get_text(*worst, "statement")) : "";
}

std::string tell_alone(const json& finding) {
  std::string others;
  for (const json& a : get_list(finding, "alternatives")) {
    const bool elsewhere = get(a, "where") != get(finding, "where");
    const std::string one =
        describe_effect(get_text(a, "effect"), false) + (elsewhere ? " (" + describe_place(get(a, "where")) + ")" : "");
    others += (others.empty() ? "" : ", ") + one;
  }
  const std::string text = typeset(get_text(finding, "statement"));
  return others.empty() ? text : text + " These recordings cannot tell it from: " + others + ".";
}

// The recordings in which it is, if it is not in all.
std::string describe_only_in(const json& finding) {
  const std::string files =
      join_words(get(finding, "only_in"), [](const json& file) { return file.get<std::string>(); });
  return files.empty() ? "" : " (only in " + files + ")";
}

}  // namespace

std::string describe_places(const std::vector<const json*>& findings) {
  std::map<std::string, std::vector<std::string>> by_kind;
  for (const json* f : findings) {
    for (const auto& item : get_object(*f, "where").items())
      by_kind[item.key()].push_back(print_place(item.value()) + describe_only_in(*f));
  }
  std::string out;
  for (const auto& [kind, names] : by_kind) {
    out += out.empty() ? "" : ", ";
    if (names.size() == 1 && kind == names[0]) {
      out += "the " + kind;
      continue;
    }
    const std::string kinds = names.size() == 1 ? kind : kind == "foot" ? "feet" : kind + "s";
    if (findings.size() > kFew) {
      out += std::to_string(names.size()) + " " + kinds;
      continue;
    }
    out += kinds;
    for (size_t i = 0; i < names.size(); ++i) out += (i == 0 ? " " : i + 1 < names.size() ? ", " : " and ") + names[i];
  }
  return out.empty() ? "the whole recording" : out;
}

std::string list_alternatives(const json& finding) {
  std::string out;
  for (const json& a : get_list(finding, "alternatives")) {
    const std::string effect = describe_effect(get_text(a, "effect"), false);
    if (out.find(effect) == std::string::npos) out += (out.empty() ? "" : ", ") + effect;
  }
  return out;
}

std::vector<FindingGroup> list_shared(const json& report) {
  std::vector<FindingGroup> groups;
  for (const json& f : get_list(report, "findings")) {
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const FindingGroup& g) {
      const json& first = *g.findings[0];
      return get_text(first, "effect") == get_text(f, "effect") && get_text(first, "grade") == get_text(f, "grade") &&
             get(first, "parameters") == get(f, "parameters");
    });
    (same == groups.end() ? groups.emplace_back() : *same).findings.push_back(&f);
  }
  return groups;
}

std::vector<std::string> make_headline(const json& report) {
  std::vector<std::string> out;
  if (get(report, "preliminary") == json(true))
    out.push_back("A first answer from a part of the recordings; the search goes on.");
  const json& findings = get_list(report, "findings");
  if (findings.empty()) {
    const std::string closest = make_closest_sentence(report);
    out.push_back(get_text(report, "summary",
                           closest.empty() ? find_verdict_words(get_text(report, "verdict")).sentence : closest));
    for (const json& item : get_list(report, "unexplained")) {
      const std::string statement = typeset(get_text(item, "statement"));
      const bool told = std::any_of(out.begin(), out.end(), [&](const std::string& sentence) {
        return sentence.find(statement) != std::string::npos;
      });
      if (!told) out.push_back(statement);
    }
    for (const std::string& sentence :
         {make_angle_sentence(report), make_unit_sentence(report), make_short_sentence(report)}) {
      if (!sentence.empty() && out[0].find(sentence) == std::string::npos) out.push_back(sentence);
    }
    return out;
  }
  const bool as_set = get(report, "as_set") == json(true);
  if (as_set) out.push_back(make_set_sentence(report));
  if (findings.size() <= kFew) {
    for (const json& f : findings) out.push_back(tell_alone(f));
  } else {
    add_groups(report, &out);
  }
  for (const std::string& sentence :
       {as_set ? "" : make_errors_sentence(report), make_ceiling_sentence(report), get_text(report, "motion"),
        make_angle_sentence(report), make_unit_sentence(report), make_left_sentence(report),
        make_unnamed_sentence(report)}) {
    if (!sentence.empty()) out.push_back(sentence);
  }
  return out;
}

}  // namespace hrp::diagnosis::html
