// SPDX-License-Identifier: BSD-3-Clause
// Small tools of the HTML report: escaping, numbers, safe reading of JSON.
#pragma once

#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace hrp::diagnosis::html {

using nlohmann::json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();  // where a report has no number

std::string escape(const std::string& text);
// "3 +- 1 kg m^2" -> "3 ± 1 kg m²".
std::string typeset(std::string text);
std::string format_number(double value, int digits = 4);      // "3.021", "1.2e-05", "-" when not finite
std::string format_value(const json& value, int digits = 4);  // number, list or text, escaped
std::string join_values(const json& list, int digits = 4);    // "1, 2, 3"
// Of rows that are HTML already, with a head; empty without rows.
std::string make_table(const std::vector<std::string>& head, const std::string& rows);

// Reading that never throws: the fallback when the key is absent, null or of another type.
const json& get(const json& object, const char* key);
const json& get_list(const json& object, const char* key);    // an empty list
const json& get_object(const json& object, const char* key);  // an empty object
std::string get_text(const json& object, const char* key, const std::string& fallback = "");
double get_number(const json& object, const char* key, double fallback = kNone);
std::vector<double> get_numbers(const json& object, const char* key);  // null becomes NaN

// "rotor_inertia" -> "Rotor inertia", or "rotor inertia" where no sentence begins; names of people keep their capital.
std::string describe_effect(const std::string& effect, bool begins = true);
// {"joint": "elbow"} -> "joint elbow"; empty object -> "".
std::string describe_place(const json& where);
std::string print_place(const json& name);  // one name of `where`, not escaped

}  // namespace hrp::diagnosis::html
