// SPDX-License-Identifier: BSD-3-Clause
// Computes the regressor columns of links/model.h.
#pragma once

#include "diagnosis/evidence/links/model.h"

namespace hrp::diagnosis {

// All terms that at least one of the sensors can show.
std::vector<LinkTerm> list_link_terms(const LinkData& data, const LinkSensors& sensors, const LinkReadings& readings,
                                      const LinkPoints& points);

// One matrix per kept sample of the recording: readings x columns of all terms.
std::vector<Eigen::MatrixXd> calc_link_columns(const LinkRecording& recording, const std::vector<LinkTerm>& terms,
                                               const Experiment& experiment, LinkReadings* readings);

// Columns of one recording, sample by sample. The rows of links/rows.h refer to the `fill_...` functions.
class LinkColumns {
 public:
  LinkColumns(const LinkRecording& recording, const std::vector<LinkTerm>& terms, const Experiment& experiment,
              LinkReadings* readings);

  Eigen::MatrixXd make(long moment);

  void fill_load(const LinkTerm& term, Eigen::MatrixXd* out);
  void fill_mass(const LinkTerm& term, Eigen::MatrixXd* out);
  void fill_com(const LinkTerm& term, Eigen::MatrixXd* out);
  void fill_force(const LinkTerm& term, Eigen::MatrixXd* out);
  void fill_offset(const LinkTerm& term, Eigen::MatrixXd* out);
  void fill_spring(const LinkTerm& term, Eigen::MatrixXd* out);
  void fill_tilt(const LinkTerm& term, Eigen::MatrixXd* out);
  void fill_late_positions(const LinkTerm& term, Eigen::MatrixXd* out);
  void fill_bias(const LinkTerm& term, Eigen::MatrixXd* out);
  void fill_scale(const LinkTerm& term, Eigen::MatrixXd* out);
  void fill_late_sensor(const LinkTerm& term, Eigen::MatrixXd* out);
  void fill_turn(const LinkTerm& term, Eigen::MatrixXd* out);

 private:
  Eigen::VectorXd calc_change(double delay) const;
  std::vector<const ReadingGroup*> list_groups(const LinkTerm& term) const;

  const LinkRecording& r_;
  const std::vector<LinkTerm>& terms_;
  LinkReadings& readings_;
  std::vector<LinkReadings> turned_;  // for turned gravity: by axis, positive then negative angle
  Eigen::MatrixXd rate_;              // time derivative of the predicted readings
  Eigen::VectorXd q_, v_, a_;
  long moment_ = 0, width_ = 0;
};

}  // namespace hrp::diagnosis
