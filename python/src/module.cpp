// SPDX-License-Identifier: BSD-3-Clause
// openhrp_dds._core: what the package's Python files are written on.
#include "python/src/arrays.h"

PYBIND11_MODULE(_core, m) {
  m.doc() = "The compiled part of openhrp_dds: robots, simulations, controllers, logs. Import openhrp_dds instead.";
  hrp::python::bind_robot(m);
  hrp::python::bind_controller(m);
  hrp::python::bind_simulation(m);
  hrp::python::bind_logs(m);
}
