// SPDX-License-Identifier: BSD-3-Clause
#include "python/src/arrays.h"

#include <cmath>

namespace hrp::python {

std::string format_shape(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
  return text + (array.ndim() == 1 ? ",)" : ")");
}

Numbers take_numbers(const py::handle& value, const std::string& name) {
  // Without this check numpy would make NaN of None.
  Numbers array = value.is_none() ? Numbers() : Numbers::ensure(value);
  if (value.is_none() || !array) {
    PyErr_Clear();
    throw py::type_error(name + " must be an array of numbers, not " +
                         std::string(py::str(py::type::of(value).attr("__name__"))));
  }
  return array;
}

Eigen::VectorXd take_vector(const py::handle& value, const std::string& name, Eigen::Index size) {
  const Numbers array = take_numbers(value, name);
  if (array.ndim() != 1 || array.shape(0) != size) {
    throw py::value_error(name + " must have shape (" + std::to_string(size) + ",), not " + format_shape(array));
  }
  return Eigen::Map<const Eigen::VectorXd>(array.data(), size);
}

Eigen::VectorXd take_finite(const py::handle& value, const std::string& name, Eigen::Index size) {
  Eigen::VectorXd vector = take_vector(value, name, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    if (!std::isfinite(vector[i]))
      throw py::value_error(name + "[" + std::to_string(i) + "] is " + (std::isnan(vector[i]) ? "NaN" : "infinite"));
  }
  return vector;
}

Eigen::Quaterniond take_quaternion(const py::handle& value, const std::string& name) {
  const Eigen::VectorXd q = take_finite(value, name, 4);
  if (std::abs(q.norm() - 1.0) > 1e-6)
    throw py::value_error(name + " must be a unit quaternion (w, x, y, z); its norm is " + std::to_string(q.norm()));
  return {q[0], q[1], q[2], q[3]};
}

Eigen::Vector4d make_wxyz(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

Eigen::Matrix4d make_matrix(const Transform& X) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = X.R;
  matrix.topRightCorner<3, 1>() = X.p;
  return matrix;
}

py::array give(std::vector<double>&& values, size_t columns, size_t rows_without_columns) {
  auto* kept = new std::vector<double>(std::move(values));
  const py::capsule owner(kept, [](void* p) { delete static_cast<std::vector<double>*>(p); });
  const auto rows = static_cast<py::ssize_t>(columns == 0 ? rows_without_columns : kept->size() / columns);
  return py::array_t<double>({rows, static_cast<py::ssize_t>(columns)}, kept->data(), owner);
}

}  // namespace hrp::python
