// SPDX-License-Identifier: BSD-3-Clause
// The two parts of the list of terms, and a helper to write rows. Private to measurement.
#pragma once

#include "diagnosis/measurement/torque/terms.h"

namespace hrp::diagnosis {

std::vector<TermRow> make_joint_rows();
std::vector<TermRow> make_whole_rows();

// Motions that would distinguish a term from others.
extern const char* const kReversals;
extern const char* const kSweeps;
extern const char* const kPostures;

constexpr double kMostHeld = 0.8;    // share of the load; a gear that holds more would hardly be driven backwards
constexpr double kLongest = 0.1;     // [s] longest lag or delay of a drive
constexpr double kAngleStep = 1e-4;  // [rad] of the central differences over a position or the base's attitude
constexpr double kMaterialFactor = 0.03, kMaterialAngle = 0.003;  // [rad]

// Speed [rad/s] that a joint exceeds in a tenth of its used samples; 0 if it has none.
double find_fast_speed(const TorqueData& data, int joint);
std::vector<double> list_delays();

// A row written in one expression.
struct Row : TermRow {
  Row(const char* name, double nats, const char* motion_in) {
    effect = find_effect(name);
    cost = nats;
    motion = motion_in;
  }
  Row& column(decltype(TermRow::calc_columns) calc, int count = 1) {
    calc_columns = calc;
    columns = count;
    return *this;
  }
  Row& in_all_rows(PlaceKind at, int count, decltype(TermRow::fill_columns) fill) {
    whole = true;
    place = at;
    columns = count;
    fill_columns = fill;
    return *this;
  }
  Row& shapes(decltype(TermRow::list_shapes) list) {
    list_shapes = list;
    return *this;
  }
  Row& parameters(decltype(TermRow::make_values) to, decltype(TermRow::make_coefficients) from) {
    make_values = to;
    make_coefficients = from;
    return *this;
  }
  Row& within(double least, double most) {
    low = least;
    high = most;
    return *this;
  }
  Row& positive() {
    low = 0.0;
    return *this;
  }
  Row& small_angle(double most) {
    by_norm = true;
    material = kMaterialAngle;
    return within(0.0, most);
  }
  Row& worth_saying_from(double size) {
    material = size;
    return *this;
  }
  Row& is(bool TermRow::*property) { return this->*property = true, *this; }
  Row& constant_in(int column) {
    constant = column;
    return *this;
  }
  Row& shape_above(double least) {
    least_shape = least;
    return *this;
  }
  Row& shaped_by(int parameter) {
    shape_parameter = parameter;
    scanned = true;
    return *this;
  }
};

}  // namespace hrp::diagnosis
