// SPDX-License-Identifier: BSD-3-Clause
// The columns of link_model.h.
#pragma once

#include "diagnosis/evidence/link_model.h"

namespace hrp::diagnosis {

// Every effect that some sensor can show.
std::vector<LinkTerm> list_link_terms(const LinkData& data, const LinkSensors& sensors, const LinkReadings& readings,
                                      const LinkPoints& points);

// By kept sample of a recording: readings x columns of all terms.
std::vector<Eigen::MatrixXd> calc_link_columns(const LinkRecording& recording, const std::vector<LinkTerm>& terms,
                                               const Experiment& experiment, LinkReadings* readings);

}  // namespace hrp::diagnosis
