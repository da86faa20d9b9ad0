// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace hrp {

// "robot.urdf" of "models/robot.urdf".
inline std::string get_file_name(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }

}  // namespace hrp
