// SPDX-License-Identifier: BSD-3-Clause
// libsdformat, and what all of this folder takes from it.
#pragma once

#include <string>

#include <sdf/sdf.hh>

#include "common/base/diagnostics.h"
#include "common/spatial/transform.h"

namespace hrp {

// Loads SDF text that was read from `path`. Models that it includes ("model://NAME") are looked for in the file's
// folder and in every folder above it. False after errors, which go to `diagnostics`.
[[nodiscard]] bool load_sdf(const std::string& text, const std::string& path, sdf::Root* root,
                            Diagnostics* diagnostics);

inline Vector3d make_vector(const ignition::math::Vector3d& v) { return {v.X(), v.Y(), v.Z()}; }

inline Transform make_transform(const ignition::math::Pose3d& pose) {
  const auto& q = pose.Rot();
  return {Eigen::Quaterniond(q.W(), q.X(), q.Y(), q.Z()).normalized().toRotationMatrix(), make_vector(pose.Pos())};
}

// 0 when it is not known.
template <typename Part>
int find_line(const Part& part) {
  return part.Element() ? part.Element()->LineNumber().value_or(0) : 0;
}

// As find_mesh() takes it.
inline std::string make_mesh_name(const std::string& uri) {
  const std::string model = "model://";
  return uri.rfind(model, 0) == 0 ? "package://" + uri.substr(model.size()) : uri;
}

}  // namespace hrp
