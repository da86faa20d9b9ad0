// SPDX-License-Identifier: BSD-3-Clause
// A robot file through urdfdom, and urdfdom's types in ours.
#pragma once

#include <urdf_model/model.h>

#include <memory>

#include "common/base/diagnostics.h"
#include "common/multibody/model.h"
#include "servers/model_parser/urdf_scan.h"

namespace hrp {

// Null where urdfdom refuses the file; `diagnostics` says why.
std::shared_ptr<urdf::ModelInterface> parse_urdf(const UrdfScan& scan, Diagnostics* diagnostics);

Transform make_transform(const urdf::Pose& pose);
Vector3d make_vector(const urdf::Vector3& v);
LinkInertia make_inertia(const urdf::Link& link);  // in the link's axes, about its origin

}  // namespace hrp
