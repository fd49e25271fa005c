#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
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

/// What rides on a mesh beside its faces, as keywords give it; None where there is none.
struct MeshArguments {
  pybind11::object crease_edges = pybind11::none(), corner_vertices = pybind11::none(),
                   uvs = pybind11::none(), face_uvs = pybind11::none(), colors = pybind11::none(),
                   groups = pybind11::none(), face_groups = pybind11::none(),
                   attributes = pybind11::none();

  /// Calls each(name, value) for all of them.
  template <class Each>
  void visit(const Each& each) {
    each("crease_edges", crease_edges);
    each("corner_vertices", corner_vertices);
    each("uvs", uvs);
    each("face_uvs", face_uvs);
    each("colors", colors);
    each("groups", groups);
    each("face_groups", face_groups);
    each("attributes", attributes);
  }
  /// Adds them to a mesh with vertices and faces. Throws Error{InvalidArgument}.
  void add_to(PolygonMesh& mesh) const;
};

/// What the keywords mean, for docstrings.
[[nodiscard]] const char* mesh_keywords();

/// {name: values}, float32 of shape (n,) or (n, k), read-only views that `owner` keeps.
[[nodiscard]] pybind11::dict attributes_view(std::span<const VertexAttribute> attributes,
                                             const pybind11::object& owner);

/// [(name, material)].
[[nodiscard]] pybind11::list groups_list(std::span<const FaceGroup> groups);

/// Adds what rides on a mesh or a surface as read-only properties of its class; held_by(object) has
/// the C++ object.
template <class Class, class HeldBy>
void add_riders(Class& type, const HeldBy& held_by) {
  namespace py = pybind11;
  const auto rows = [](const auto& values, py::ssize_t width, const py::object& self) {
    using Value = std::remove_cvref_t<decltype(values[0][0])>;
    const Value* const first = values.empty() ? nullptr : &values[0].x;
    return view(first, {static_cast<py::ssize_t>(values.size()), width}, self);
  };
  const auto list = [](const auto& values, const py::object& self) {
    return view(values.data(), {static_cast<py::ssize_t>(values.size())}, self);
  };
  type.def_property_readonly(
          "uvs", [=](const py::object& self) { return rows(held_by(self).uvs, 2, self); },
          "float64 (k, 2): texture coordinates, which face_uvs names; empty: none.")
      .def_property_readonly(
          "face_uvs", [=](const py::object& self) { return list(held_by(self).face_uvs, self); },
          "int32, one for each corner of the faces, in their order; -1: none there.")
      .def_property_readonly(
          "colors", [=](const py::object& self) { return rows(held_by(self).colors, 4, self); },
          "float32 (n, 4): linear RGBA of each vertex; empty: none.")
      .def_property_readonly(
          "groups", [=](const py::object& self) { return groups_list(held_by(self).groups); },
          "[(name, material)], which face_groups numbers.")
      .def_property_readonly(
          "face_groups",
          [=](const py::object& self) { return list(held_by(self).face_groups, self); },
          "int32, one for each face; empty: none.")
      .def_property_readonly(
          "attributes",
          [=](const py::object& self) { return attributes_view(held_by(self).attributes, self); },
          "{name: float32 (n,) or (n, k)}, of each vertex.");
}

/// Makes objects of a class picklable, by packed() and unpack(). They do not change, so that copies
/// of them are they themselves.
template <class Held, class Class>
void add_pickle(Class& type, std::string (*pack)(const Held&),
                void (*unpack)(std::string_view, Held&)) {
  namespace py = pybind11;
  type.def(py::pickle([pack](const Held& held) { return py::bytes(pack(held)); },
                      [unpack](const py::bytes& bytes) {
                        auto made = std::make_shared<Held>();
                        unpack(std::string_view(bytes), *made);
                        return made;
                      }))
      .def("__copy__", [](const py::object& self) { return self; })
      .def(
          "__deepcopy__", [](const py::object& self, const py::dict&) { return self; },
          py::arg("memo"));
}

}  // namespace planish::python
