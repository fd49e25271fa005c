#include "arrays.h"

#include <algorithm>
#include <limits>
#include <string>

#include "errors.h"
#include "planish/core/error.h"

namespace py = pybind11;

namespace planish::python {
namespace {

constexpr std::int64_t kMaxIndex = std::numeric_limits<std::int32_t>::max();

std::string shape_text(const py::array& array) {
  return py::str(array.attr("shape")).cast<std::string>();
}

// Before a copy is made: an array that repeats its elements (numpy.broadcast_to()) takes little
// memory for many.
void require_count(const py::array& array, py::ssize_t columns, const char* name) {
  const py::ssize_t count = array.ndim() > 0 ? array.shape(0) : 1;
  if (count > kMaxIndex || array.size() > columns * kMaxIndex) {
    refuse(formatted("{}: shape {} has more than 2^31 - 1 elements; give fewer", name,
                     shape_text(array)));
  }
}

// Any numbers as an array of float64. A complex or text array is none.
Doubles as_doubles(const py::object& values, const char* name, const char* wanted,
                   py::ssize_t columns = 3) {
  const py::array array = py::array::ensure(values);
  if (!array) {
    PyErr_Clear();
    refuse(std::string(name) + ": no array; " + wanted);
  }
  require_count(array, columns, name);
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u') {
    refuse(formatted("{}: an array of {}; {}", name, py::str(array.dtype()).cast<std::string>(),
                     wanted));
  }
  return py::array_t<double, py::array::c_style | py::array::forcecast>(array);
}

void require_vertex(std::int32_t vertex, std::int32_t count, std::int64_t face) {
  if (vertex >= 0 && vertex < count) return;
  throw Error(ErrorCode::UnusableMesh,
              formatted("face {} names vertex {} of {}; indices count from 0", face, vertex, count),
              face);
}

void set_alike_faces(const Integers& faces, PolygonMesh& mesh) {
  const std::int64_t count = faces.shape(0), size = faces.shape(1);
  if (count * size > kMaxIndex) refuse("faces: more than 2^31 - 1 corners");
  if (count > 0 && size == 0)
    refuse("faces: shape " + shape_text(faces) + ", so none has a corner; give 3 or more each");
  mesh.face_vertices.assign(faces.data(), faces.data() + faces.size());
  mesh.face_offsets.resize(static_cast<std::size_t>(count) + 1);
  for (std::int64_t f = 0; f <= count; ++f)
    mesh.face_offsets[f] = static_cast<std::int32_t>(f * size);
}

void set_sized_faces(const Integers& sizes, const Integers& indices, PolygonMesh& mesh) {
  if (sizes.ndim() != 1 || indices.ndim() != 1) {
    refuse(formatted(
        "faces: a tuple is (sizes, indices), both of one dimension; these have shapes {} and {}",
        shape_text(sizes), shape_text(indices)));
  }
  std::int64_t end = 0;
  for (py::ssize_t f = 0; f < sizes.size(); ++f) {
    const std::int32_t size = sizes.data()[f];
    if (size < 0) refuse(formatted("faces: size {} of face {}", size, f));
    end += size;
    if (end > indices.size()) break;
    mesh.face_offsets.push_back(static_cast<std::int32_t>(end));
  }
  if (end != indices.size()) {
    refuse(formatted("faces: the sizes add up to {}{}, and there are {} indices", end,
                     end > indices.size() ? " or more" : "", indices.size()));
  }
  mesh.face_vertices.assign(indices.data(), indices.data() + indices.size());
}

// A list of faces: one after another, since each may have another number of corners.
void set_listed_faces(const py::sequence& faces, PolygonMesh& mesh) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Integers face = as_integers(faces[f], "faces");
    if (face.ndim() != 1) refuse(formatted("faces: face {} is no sequence of indices", f));
    mesh.add_face({face.data(), static_cast<std::size_t>(face.size())});
  }
}

void set_faces(const py::object& faces, PolygonMesh& mesh) {
  if (py::isinstance<py::tuple>(faces) && py::len(faces) == 2) {
    const auto pair = py::cast<py::tuple>(faces);
    set_sized_faces(as_integers(pair[0], "faces[0]"), as_integers(pair[1], "faces[1]"), mesh);
    return;
  }
  if (!py::isinstance<py::array>(faces) && py::isinstance<py::sequence>(faces)) {
    set_listed_faces(py::cast<py::sequence>(faces), mesh);
    return;
  }
  const Integers array = as_integers(faces, "faces");
  if (array.ndim() != 2) {
    refuse(
        "faces: an array (n, k), a tuple (sizes, indices) or a list of faces is wanted; this has "
        "shape " +
        shape_text(array));
  }
  set_alike_faces(array, mesh);
}

}  // namespace

Doubles as_points(const py::object& values, const char* name) {
  constexpr const char* kWanted = "numbers of shape (n, 3) are wanted";
  Doubles points = as_doubles(values, name, kWanted);
  if (points.size() == 0 && points.ndim() == 1) return Doubles(std::vector<py::ssize_t>{0, 3});
  if (points.ndim() != 2 || points.shape(1) != 3)
    refuse(formatted("{}: shape {}; {}", name, shape_text(points), kWanted));
  return points;
}

Doubles as_numbers(const py::object& values, const char* name) {
  constexpr const char* kWanted = "numbers of shape (n,) are wanted";
  Doubles numbers = as_doubles(values, name, kWanted);
  if (numbers.ndim() != 1)
    refuse(formatted("{}: shape {}; {}", name, shape_text(numbers), kWanted));
  return numbers;
}

Doubles as_rows(const py::object& values, const char* name, py::ssize_t least, py::ssize_t most) {
  const std::string columns = least == most ? std::to_string(most)
                              : least == 0  ? "k"
                                            : formatted("{} or {}", least, most);
  const std::string wanted =
      formatted("numbers of shape {}(n, {}) are wanted{}", least == 0 ? "(n,) or " : "", columns,
                least == 0 ? formatted(", k up to {}", most) : "");
  Doubles rows = as_doubles(values, name, wanted.c_str(), most);
  const bool is_list = least == 0 && rows.ndim() == 1;
  const bool is_table =
      rows.ndim() == 2 && rows.shape(1) >= std::max<py::ssize_t>(least, 1) && rows.shape(1) <= most;
  if (!is_list && !is_table) refuse(formatted("{}: shape {}; {}", name, shape_text(rows), wanted));
  return rows;
}

std::span<const glm::dvec3> points_of(const Doubles& values) {
  static_assert(sizeof(glm::dvec3) == 3 * sizeof(double));
  return {reinterpret_cast<const glm::dvec3*>(values.data()),
          static_cast<std::size_t>(values.shape(0))};
}

Integers as_integers(const py::object& values, const char* name) {
  const py::array array = py::array::ensure(values);
  if (!array) {
    PyErr_Clear();
    refuse(std::string(name) + ": no array of integers");
  }
  require_count(array, 1, name);
  if (array.size() == 0)
    return Integers(std::vector<py::ssize_t>(array.shape(), array.shape() + array.ndim()));
  const char kind = array.dtype().kind();
  if (kind != 'i' && kind != 'u') {
    refuse(formatted("{}: an array of {}; integers are wanted", name,
                     py::str(array.dtype()).cast<std::string>()));
  }
  if (array.itemsize() < 4 || py::isinstance<py::array_t<std::int32_t>>(array))
    return py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>(array);
  // Larger ones may not fit; of uint64 what does not fit int64 becomes negative, and is refused
  // too.
  const py::array_t<std::int64_t, py::array::c_style | py::array::forcecast> wide(array);
  for (py::ssize_t i = 0; i < wide.size(); ++i) {
    const std::int64_t value = wide.data()[i];
    if (value < -kMaxIndex || value > kMaxIndex)
      refuse(formatted("{}: {} needs more than 32 bits", name, value));
  }
  return py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>(array);
}

PolygonMesh mesh_of(const py::object& vertices, const py::object& faces) {
  const Doubles points = as_points(vertices, "vertices");
  PolygonMesh mesh;
  const auto positions = points_of(points);
  mesh.positions.assign(positions.begin(), positions.end());
  set_faces(faces, mesh);
  return mesh;
}

void require_indices(const PolygonMesh& mesh) {
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    for (const std::int32_t vertex : mesh.face(f)) require_vertex(vertex, mesh.vertex_count(), f);
}

py::object faces_view(std::span<const std::int32_t> offsets, std::span<const std::int32_t> vertices,
                      const py::object& owner) {
  const auto count = static_cast<py::ssize_t>(offsets.size()) - 1;
  const std::int32_t size = count > 0 ? offsets[1] : 3;
  bool alike = true;
  for (py::ssize_t f = 0; f < count && alike; ++f) alike = offsets[f + 1] - offsets[f] == size;
  if (alike) return view(vertices.data(), {count, size}, owner);
  std::vector<std::int32_t> sizes(static_cast<std::size_t>(count));
  for (std::size_t f = 0; f < sizes.size(); ++f) sizes[f] = offsets[f + 1] - offsets[f];
  return py::make_tuple(take_over(std::move(sizes), {count}),
                        view(vertices.data(), {static_cast<py::ssize_t>(vertices.size())}, owner));
}

}  // namespace planish::python
