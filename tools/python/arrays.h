#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::python {

/// float64 in rows, as it is where it is so, else converted.
using Doubles = pybind11::array_t<double, pybind11::array::c_style>;
/// The same of int32.
using Integers = pybind11::array_t<std::int32_t, pybind11::array::c_style>;

/// Numbers (n, 3). Throws Error{InvalidArgument} naming `name` for another shape or type.
[[nodiscard]] Doubles as_points(const pybind11::object& values, const char* name);
/// Numbers (n,) of float64.
[[nodiscard]] Doubles as_numbers(const pybind11::object& values, const char* name);
/// Numbers (n, k) with k from `least` to `most`; where `least` is 0 also (n,). float64. Throws as
/// above, before a copy is made.
[[nodiscard]] Doubles as_rows(const pybind11::object& values, const char* name,
                              pybind11::ssize_t least, pybind11::ssize_t most);
[[nodiscard]] std::span<const glm::dvec3> points_of(const Doubles& values);
/// Integers of any shape. Throws Error{InvalidArgument} for numbers that are none or need more than
/// 32 bits.
[[nodiscard]] Integers as_integers(const pybind11::object& values, const char* name);

/// `faces`: integers (n, k); a tuple (sizes, indices); or a list of faces, each a sequence. Throws
/// Error{InvalidArgument}. Indices may name no vertex.
[[nodiscard]] PolygonMesh mesh_of(const pybind11::object& vertices, const pybind11::object& faces);
/// Throws Error{UnusableMesh} for an index that names no vertex. fit() looks at them on all
/// threads.
void require_indices(const PolygonMesh& mesh);

/// A read-only view of memory that `owner` keeps.
template <class Value>
pybind11::array view(const Value* data, std::vector<pybind11::ssize_t> shape,
                     const pybind11::object& owner) {
  pybind11::array_t<Value> array(std::move(shape), data, owner);
  array.attr("setflags")(pybind11::arg("write") = false);
  return array;
}

/// Polygons as an array (n, k) where all have k corners, else as (sizes, indices).
[[nodiscard]] pybind11::object faces_view(std::span<const std::int32_t> offsets,
                                          std::span<const std::int32_t> vertices,
                                          const pybind11::object& owner);

/// The array takes the values over, without a copy.
template <class Value>
pybind11::array_t<Value> take_over(std::vector<Value>&& values,
                                   std::vector<pybind11::ssize_t> shape) {
  auto* const kept = new std::vector<Value>(std::move(values));
  const pybind11::capsule owner(
      kept, [](void* pointer) { delete static_cast<std::vector<Value>*>(pointer); });
  return pybind11::array_t<Value>(std::move(shape), kept->data(), owner);
}

}  // namespace planish::python
