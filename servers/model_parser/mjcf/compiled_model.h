// SPDX-License-Identifier: BSD-3-Clause
// MJCF text through MuJoCo's own reader and compiler.
#pragma once

#include <memory>
#include <string>

#include <mujoco/mujoco.h>

namespace hrp {

struct DeleteModel {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
using CompiledModel = std::unique_ptr<mjModel, DeleteModel>;

// `path`: where the text was read from; what it includes and its meshes are looked for from there. Throws
// std::runtime_error with what MuJoCo says.
CompiledModel compile_mjcf(const std::string& text, const std::string& path);

}  // namespace hrp
