#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "arrays.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::python {

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
