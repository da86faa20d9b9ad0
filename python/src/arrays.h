// SPDX-License-Identifier: BSD-3-Clause
// Numbers from and to Python: shapes are checked with the argument's name in the message.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "common/spatial/transform.h"

namespace hrp::python {

namespace py = pybind11;
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

// "(3,)", "(2, 4)".
std::string format_shape(const py::array& array);
// Throws TypeError when `value` is no array of numbers: the name of the argument is in the message.
Numbers take_numbers(const py::handle& value, const std::string& name);
// A vector of this size. Throws ValueError with the name, the shape that is expected and the one that came.
Eigen::VectorXd take_vector(const py::handle& value, const std::string& name, Eigen::Index size);
// The same, and every number finite.
Eigen::VectorXd take_finite(const py::handle& value, const std::string& name, Eigen::Index size);

// Unit quaternion from (w, x, y, z); throws ValueError when its norm is no one.
Eigen::Quaterniond take_quaternion(const py::handle& value, const std::string& name);
Eigen::Vector4d make_wxyz(const Eigen::Quaterniond& q);
Eigen::Matrix4d make_matrix(const Transform& X);

// A read-only array that looks into memory of `owner`, which lives as long as the array does.
template <typename Vector>
py::array view(const Vector& vector, const py::handle& owner) {
  py::array_t<double> array({static_cast<py::ssize_t>(vector.size())}, {static_cast<py::ssize_t>(sizeof(double))},
                            vector.data(), owner);
  array.attr("setflags")(py::arg("write") = false);
  return std::move(array);
}

// rows x columns, moved into an array without a copy.
py::array give(std::vector<double>&& values, size_t columns, size_t rows_without_columns = 0);

void bind_robot(py::module_& m);
void bind_controller(py::module_& m);
void bind_simulation(py::module_& m);
void bind_logs(py::module_& m);

}  // namespace hrp::python
