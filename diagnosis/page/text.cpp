// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/page/text.h"

#include <cctype>
#include <cmath>

#include "common/base/escape_xml.h"
#include "common/base/join_words.h"
#include "common/base/rounding.h"

namespace hrp::diagnosis::html {

std::string escape(const std::string& text) { return escape_xml(text); }

std::string typeset(std::string text) {
  for (const auto& [plain, sign] : {std::pair{"+-", "\u00b1"}, std::pair{"^2", "\u00b2"}, std::pair{"^3", "\u00b3"}}) {
    for (size_t at = text.find(plain); at != std::string::npos; at = text.find(plain, at)) text.replace(at, 2, sign);
  }
  return text;
}

std::string format_number(double value, int digits) {
  return std::isfinite(value) ? number(value == 0 ? 0.0 : value, digits) : "-";
}

std::string format_value(const json& value, int digits) {
  if (value.is_number()) return format_number(value.get<double>(), digits);
  if (value.is_string()) return escape(value.get<std::string>());
  if (!value.is_array())
    return value.is_null() ? "-" : escape(value.dump(-1, ' ', false, json::error_handler_t::replace));
  return "(" + join_values(value, digits) + ")";
}

std::string join_values(const json& list, int digits) {
  return join_words(list, [digits](const json& item) { return format_value(item, digits); });
}

std::string make_table(const std::vector<std::string>& head, const std::string& rows) {
  if (rows.empty()) return "";
  std::string out = "<div class='wide' tabindex='0'><table><thead><tr>";
  for (const std::string& h : head) out += "<th scope='col'>" + h + "</th>";
  return out + "</tr></thead><tbody>" + rows + "</tbody></table></div>";
}

const json& get(const json& object, const char* key) {
  static const json nothing;
  if (!object.is_object()) return nothing;
  const auto at = object.find(key);
  return at == object.end() ? nothing : *at;
}

const json& get_list(const json& object, const char* key) {
  static const json empty = json::array();
  const json& list = get(object, key);
  return list.is_array() ? list : empty;
}

const json& get_object(const json& object, const char* key) {
  static const json empty = json::object();
  const json& inner = get(object, key);
  return inner.is_object() ? inner : empty;
}

std::string get_text(const json& object, const char* key, const std::string& fallback) {
  const json& value = get(object, key);
  return value.is_string() ? value.get<std::string>() : fallback;
}

double get_number(const json& object, const char* key, double fallback) {
  const json& value = get(object, key);
  return value.is_number() ? value.get<double>() : fallback;
}

std::vector<double> get_numbers(const json& object, const char* key) {
  std::vector<double> out;
  const json& list = get(object, key);
  if (!list.is_array()) return out;
  for (const json& item : list) {
    out.push_back(item.is_number() ? item.get<double>() : kNone);
  }
  return out;
}

std::string describe_effect(const std::string& effect, bool begins) {
  std::string out = effect;
  for (char& c : out) c = c == '_' ? ' ' : c;
  const bool of_person = out.rfind("coulomb", 0) == 0 || out.rfind("stribeck", 0) == 0;
  if (!out.empty() && (begins || of_person))
    out[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(out[0])));
  return out;
}

std::string print_place(const json& name) { return name.is_string() ? name.get<std::string>() : format_value(name); }

std::string describe_place(const json& where) {
  if (where.is_string()) return where.get<std::string>();
  std::string out;
  if (!where.is_object()) return out;
  for (const auto& [kind, name] : where.items()) {
    if (name.is_string()) out += (out.empty() ? "" : ", ") + kind + " " + name.get<std::string>();
  }
  return out;
}

}  // namespace hrp::diagnosis::html
