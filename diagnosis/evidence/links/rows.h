// SPDX-License-Identifier: BSD-3-Clause
// A term of links/model.h: its row in the table of effects, and what only sensors behind the gears need. To add a term,
// add a row and its columns; selection, grading and wording read these fields.
#pragma once

#include <limits>
#include <vector>

#include "common/effects/effect_info.h"
#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

class LinkColumns;  // links/columns.h
struct LinkTermRow;

// An effect at one place, as columns of the regressor.
struct LinkTerm {
  const LinkTermRow* row = nullptr;
  int index = 0;   // link, joint or sensor
  int group = -1;  // of one group of readings of the sensor; -1: of all groups
  int columns = 1;
  Vector3d near = Vector3d::Zero();  // linearisation point: load [m], sensor's rotation [rad], delay [s] (x)
  long first = 0;                    // its first column
  bool of_link_encoder = false;      // the zero belongs to the second encoder, which measures the link

  const EffectInfo& effect() const;  // the effect that the report names
};

// A kind of term: its columns, its prior cost and its physical range.
struct LinkTermRow {
  const EffectInfo* effect = nullptr;
  PlaceKind place = PlaceKind::kLink;  // kNone: positions of all joints
  int columns = 1;
  // Writes the term's columns for one sample: readings x columns of all terms.
  void (LinkColumns::*fill)(const LinkTerm& term, Eigen::MatrixXd* out) = nullptr;
  // [nats] prior cost of the term. Low for common causes: loads that people attach, and zeros that are set often.
  double cost = 4.0, cost_per_column = 0.0;
  const char* motion = "slow motion through many postures, and fast reversals, with a known mass hung on and without";
  // Physical range of the first coefficient, or of the norm of all coefficients if `by_norm`.
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool by_norm = false;
  bool within_reach = false;  // the norm must be below the link's reach
  bool load = false;          // a mass and its moment about the linearisation point
  bool factor = false;        // the parameter is 1 + coefficient
  bool of_base = false;       // only at link 0
  bool needs_mass = false;    // only at links with a mass
  bool needs_torque = false;  // only at a joint with a torque sensor
  bool by_group = false;      // one term for each group of readings
  bool each_axis = false;     // with `by_group`: one column for each component of the reading
  bool of_vectors = false;    // only for sensors that read vectors
  bool of_encoder = false;    // zero of the encoder that measures the link
  bool moves_robot = false;   // its columns move the robot, so they are computed after the others
  // `find_start`: first linearisation point. `move`: new point after a fit; false if it did not move.
  Vector3d (*find_start)(const Experiment& experiment, int index) = nullptr;
  bool (*move)(const Eigen::VectorXd& coefficients, Vector3d* near) = nullptr;
  // Converts coefficients p with standard deviations s to the table's parameters. Null: p itself, or 1 + p for a
  // factor.
  void (*make_values)(const LinkTerm& term, const Eigen::VectorXd& p, const Eigen::VectorXd& s,
                      std::vector<double>* value, std::vector<double>* std) = nullptr;

  // `reach`: size of the link [m]; only rows with a load or `within_reach` use it.
  bool needs_reach() const { return load || within_reach; }
  bool allows(const LinkTerm& term, const Eigen::VectorXd& coefficients, double reach) const;
  double get_cost(int num_columns) const { return cost + cost_per_column * num_columns; }
};

// All rows, those of links first.
const std::vector<LinkTermRow>& list_link_rows();

// Converts a term's coefficients p with standard deviations s to the parameters of the effect table.
void find_link_values(const LinkTerm& term, const Eigen::VectorXd& p, const Eigen::VectorXd& s,
                      std::vector<double>* value, std::vector<double>* std);

}  // namespace hrp::diagnosis
