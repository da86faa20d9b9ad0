// SPDX-License-Identifier: BSD-3-Clause
// Small pieces that the reports are made of.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/rounding.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

using Json = nlohmann::ordered_json;

// Parameters of one effect with their units at its place; missing deviations are 0. Vectors are gathered under one
// name, nuisances left out.
std::vector<Estimate> list_estimates(const Experiment& e, const Effect& effect, const std::vector<double>& std);
std::string get_place_unit(const Experiment& e, const Effect& effect, const EffectParameter& info);

// A parameter as the schema has it, with its 95 % interval: one number, or a vector with an interval for each axis.
Json make_value(double value, double std, const std::string& unit);
Json make_vector(const std::vector<double>& values, const std::vector<double>& std, const std::string& unit);

// Of channel c = joint * 3 + quantity: "/joint_states/elbow/effort".
std::string signal_name(const Experiment& e, size_t c);

// A number of a finding's parameters; NaN where it does not say.
double read_value(const Json& parameters, const EffectParameter& p);

// What a finding adds to the model that a report ends with: {effect, where, parameters, grade}.
Json make_model_entry(const Json& finding);

// {"joint": ...}, {"link": ...} or {"sensor": ...}.
Json make_where(const Experiment& e, const Effect& effect);
// The other way round; index -1: there is no such place.
Place find_place(const Experiment& e, const EffectInfo& effect, const Json& where);

}  // namespace hrp::diagnosis
