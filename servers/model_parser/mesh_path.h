// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace hrp {

// The file that a URDF's mesh name means, absolute; empty when there is none. "package://name/rest" is looked for in
// the URDF's folder and every folder above it, as name/rest, and then as rest beside or above the URDF (a package that
// was renamed). "file://" and plain names are taken from the URDF's folder.
std::string find_mesh(const std::string& name, const std::string& urdf_path);

}  // namespace hrp
