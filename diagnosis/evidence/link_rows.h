// SPDX-License-Identifier: BSD-3-Clause
// What a term of the sensors behind the gears (link_model.h) is: its row in the table of effects, and what only these
// sensors ask. A new term is a row and its columns; choice, grades and words read the fields.
#pragma once

#include <limits>
#include <vector>

#include "common/effects/effect_info.h"
#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

class LinkColumns;  // link_columns.h
struct LinkTermRow;

// An effect at a place: columns of what these sensors read.
struct LinkTerm {
  const LinkTermRow* row = nullptr;
  int index = 0;     // link, joint or sensor
  int group = -1;    // of one group of readings of that sensor; -1: of all
  int columns = 1;
  Vector3d near = Vector3d::Zero();  // near which it is linear: place of a load [m], turn of a sensor [rad], delay [s] (x)
  long first = 0;    // its first column
  bool of_link_encoder = false;  // a joint's zero is that of its second encoder, which gives the link's motion

  const EffectInfo& effect() const;  // as it is reported
};

struct LinkTermRow {
  const EffectInfo* effect = nullptr;
  PlaceKind place = PlaceKind::kLink;  // kNone: the positions of all joints
  int columns = 1;
  // Writes the term's columns of one moment: readings x columns of all terms.
  void (LinkColumns::*fill)(const LinkTerm& term, Eigen::MatrixXd* out) = nullptr;
  // [nats] before it pays by cross-validation. What people fix to a robot's links, and what is set to zero each morning,
  // costs least.
  double cost = 4.0, cost_per_column = 0.0;
  const char* motion = "slow motion through many postures, and fast reversals, with a known mass hung on and without";
  // Of a real machine: the first coefficient, or the norm of all.
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool by_norm = false;
  bool within_reach = false;   // the norm is at most the link's reach
  bool load = false;           // a mass, and its moment about the point near which it is linear
  bool factor = false;         // 1 + coefficient multiplies
  bool of_base = false;        // of link 0, and of no other
  bool needs_mass = false;     // a link without mass has none
  bool needs_torque = false;   // only at a joint with a torque sensor
  bool by_group = false;       // one for each group of readings, with one column for each number that it reads where
  bool each_axis = false;      // this is set
  bool of_vectors = false;     // a sensor that reads one number has none
  bool of_encoder = false;     // of the encoder that gives the link's motion
  bool moves_robot = false;    // its columns move the robot that the others are computed with
  // Where the term is linear: first, and after a fit. The second one is false where nothing moved.
  Vector3d (*find_start)(const Experiment& experiment, int index) = nullptr;
  bool (*move)(const Eigen::VectorXd& coefficients, Vector3d* near) = nullptr;
  // Parameters as the table has them, from coefficients p with deviations s. Null: they are the same, or 1 + p.
  void (*make_values)(const LinkTerm& term, const Eigen::VectorXd& p, const Eigen::VectorXd& s, std::vector<double>* value,
                      std::vector<double>* std) = nullptr;

  // `reach`: of the link [m], where the row asks for it.
  bool needs_reach() const { return load || within_reach; }
  bool allows(const LinkTerm& term, const Eigen::VectorXd& coefficients, double reach) const;
  double get_cost(int num_columns) const { return cost + cost_per_column * num_columns; }
};

// All of them, those of links first.
const std::vector<LinkTermRow>& list_link_rows();

void find_link_values(const LinkTerm& term, const Eigen::VectorXd& p, const Eigen::VectorXd& s, std::vector<double>* value,
                      std::vector<double>* std);

}  // namespace hrp::diagnosis
