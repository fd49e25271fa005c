#include "arrays.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "call.h"
#include "planish/core/error.h"
#include "planish/files/shared/attributes.h"

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

namespace {

constexpr py::ssize_t kWidestAttribute = 1024;

void add_creases(const py::object& given, PolygonMesh& mesh) {
  const Integers edges = as_integers(given, "crease_edges");
  if (edges.size() > 0 && (edges.ndim() != 2 || edges.shape(1) != 2))
    refuse("crease_edges: integers of shape (m, 2) are wanted");
  for (py::ssize_t i = 0; i + 1 < edges.size(); i += 2)
    mesh.creases.push_back({edges.data()[i], edges.data()[i + 1]});
}

std::vector<std::int32_t> list_of(const py::object& given, const char* name) {
  const Integers values = as_integers(given, name);
  if (values.ndim() != 1) refuse(std::string(name) + ": integers of shape (n,) are wanted");
  return {values.data(), values.data() + values.size()};
}

void require_length(std::size_t length, std::int64_t wanted, const char* name, const char* of) {
  if (static_cast<std::int64_t>(length) == wanted) return;
  refuse(formatted("{}: {} entries where the mesh has {} {}", name, length, wanted, of));
}

void require_below(std::span<const std::int32_t> numbers, std::size_t count, std::int32_t least,
                   const char* name) {
  const auto wrong = std::ranges::find_if(numbers, [&](std::int32_t number) {
    return number < least || number >= static_cast<std::int64_t>(count);
  });
  if (wrong == numbers.end()) return;
  refuse(formatted("{}: entry {} is {} of {}", name, wrong - numbers.begin(), *wrong, count));
}

// Finite, and no more than float32 holds where `is_float`.
void require_finite(const Doubles& rows, const std::string& name, bool is_float) {
  const py::ssize_t width = rows.ndim() == 2 ? rows.shape(1) : 1;
  for (py::ssize_t i = 0; i < rows.size(); ++i) {
    const double value = rows.data()[i];
    if (std::isfinite(is_float ? static_cast<float>(value) : value)) continue;
    refuse(formatted("{}: entry {} is {}; finite numbers are wanted", name, i / width,
                     shortest(value)));
  }
}

// Each corner of a mesh has that of its vertex where no others are named.
void add_uvs(const py::object& given, const py::object& corners, PolygonMesh& mesh) {
  if (given.is_none()) refuse("face_uvs: name texture coordinates; give uvs");
  const Doubles uvs = as_rows(given, "uvs", 2, 2);
  require_finite(uvs, "uvs", false);
  for (py::ssize_t i = 0; i + 1 < uvs.size(); i += 2)
    mesh.uvs.emplace_back(uvs.data()[i], uvs.data()[i + 1]);
  if (corners.is_none()) {
    if (std::ssize(mesh.uvs) == std::ssize(mesh.face_vertices) &&
        mesh.uvs.size() != mesh.positions.size()) {
      for (std::int32_t c = 0; c < std::ssize(mesh.uvs); ++c) mesh.face_uvs.push_back(c);
      return;
    }
    require_length(mesh.uvs.size(), mesh.vertex_count(), "uvs",
                   "vertices; name others by face_uvs");
    mesh.face_uvs = mesh.face_vertices;
    return;
  }
  mesh.face_uvs = list_of(corners, "face_uvs");
  require_length(mesh.face_uvs.size(), std::ssize(mesh.face_vertices), "face_uvs",
                 "corners of faces");
  require_below(mesh.face_uvs, mesh.uvs.size(), -1, "face_uvs");
}

void add_colors(const py::object& given, PolygonMesh& mesh) {
  const bool is_bytes = py::array::ensure(given) &&
                        py::isinstance<py::array_t<std::uint8_t>>(py::array::ensure(given));
  const Doubles colors = as_rows(given, "colors", 3, 4);
  require_length(static_cast<std::size_t>(colors.shape(0)), mesh.vertex_count(), "colors",
                 "vertices");
  require_finite(colors, "colors", true);
  const py::ssize_t width = colors.shape(1);
  mesh.colors.reserve(mesh.positions.size());
  for (py::ssize_t v = 0; v < colors.shape(0); ++v) {
    glm::dvec4 color(0, 0, 0, is_bytes ? 255 : 1);
    for (py::ssize_t k = 0; k < width; ++k) color[static_cast<int>(k)] = colors.at(v, k);
    mesh.colors.push_back(is_bytes ? linear_of_srgb(color / 255.0) : glm::vec4(color));
  }
}

std::string text_of(const py::handle& value, const std::string& name) {
  if (!py::isinstance<py::str>(value)) refuse(name + ": text is wanted");
  return value.cast<std::string>();
}

void add_groups(const py::object& given, const py::object& faces, PolygonMesh& mesh) {
  if (given.is_none() || faces.is_none())
    refuse("groups, face_groups: names and a number for each face belong together; give both");
  for (const py::handle group : given) {
    if (py::isinstance<py::str>(group)) {
      mesh.groups.push_back({text_of(group, "groups"), {}});
    } else {
      const auto pair = py::reinterpret_borrow<py::sequence>(group);
      if (!PySequence_Check(group.ptr()) || pair.size() != 2)
        refuse("groups: names, or tuples (name, material), are wanted");
      mesh.groups.push_back({text_of(pair[0], "groups"), text_of(pair[1], "groups")});
    }
  }
  mesh.face_groups = list_of(faces, "face_groups");
  require_length(mesh.face_groups.size(), mesh.face_count(), "face_groups", "faces");
  require_below(mesh.face_groups, mesh.groups.size(), 0, "face_groups");
}

void add_attributes(const py::object& given, PolygonMesh& mesh) {
  if (!py::isinstance<py::dict>(given)) refuse("attributes: a dict of arrays is wanted");
  for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(given)) {
    const std::string name = text_of(key, "attributes");
    const std::string place = "attributes[\"" + name + "\"]";
    const Doubles rows =
        as_rows(py::reinterpret_borrow<py::object>(value), place.c_str(), 0, kWidestAttribute);
    require_length(static_cast<std::size_t>(rows.shape(0)), mesh.vertex_count(), place.c_str(),
                   "vertices");
    const auto width = static_cast<int>(rows.ndim() == 2 ? rows.shape(1) : 1);
    VertexAttribute& made =
        mesh.attributes.emplace_back(attribute_of_size(name, width, mesh.positions.size()));
    std::transform(rows.data(), rows.data() + rows.size(), made.values.begin(),
                   [](double number) { return static_cast<float>(number); });
  }
  require_attributes(mesh.attributes);
}

}  // namespace

void MeshArguments::add_to(PolygonMesh& mesh) const {
  if (!crease_edges.is_none()) add_creases(crease_edges, mesh);
  if (!corner_vertices.is_none())
    for (const std::int32_t vertex : list_of(corner_vertices, "corner_vertices"))
      mesh.corners.push_back({vertex});
  const auto replace = [](bool has, const char* name) {
    if (has) refuse(std::string(name) + ": the mesh has its own; leave them out");
  };
  if (!uvs.is_none() || !face_uvs.is_none()) {
    replace(!mesh.face_uvs.empty(), "uvs");
    add_uvs(uvs, face_uvs, mesh);
  }
  if (!colors.is_none()) {
    replace(!mesh.colors.empty(), "colors");
    add_colors(colors, mesh);
  }
  if (!groups.is_none() || !face_groups.is_none()) {
    replace(!mesh.face_groups.empty(), "groups");
    add_groups(groups, face_groups, mesh);
  }
  if (!attributes.is_none()) add_attributes(attributes, mesh);
}

const char* mesh_keywords() {
  return R"(    crease_edges: integers (m, 2), edges that stay sharp; corner_vertices: integers (n,).
    uvs: numbers (k, 2), texture coordinates; face_uvs: integers, one for each corner of the faces,
        of its uvs or -1; left out, uvs are one for each vertex or one for each corner.
    colors: numbers (n, 3) or (n, 4), linear from 0 to 1; of uint8 sRGB from 0 to 255.
    groups: names, or tuples (name, material); face_groups: integers (m,), the group of each face.
    attributes: a dict of names and numbers (n,) or (n, k): float32; on the surface they go smoothly from vertex to vertex, within those given.
)";
}

py::dict attributes_view(std::span<const VertexAttribute> attributes, const py::object& owner) {
  py::dict result;
  for (const VertexAttribute& attribute : attributes) {
    std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(attribute.count())};
    if (attribute.width > 1) shape.push_back(attribute.width);
    result[py::str(attribute.name)] = view(attribute.values.data(), shape, owner);
  }
  return result;
}

py::list groups_list(std::span<const FaceGroup> groups) {
  py::list result;
  for (const FaceGroup& group : groups) {
    const auto text = [](const std::string& bytes) {
      return py::reinterpret_steal<py::object>(
          PyUnicode_DecodeUTF8(bytes.data(), static_cast<Py_ssize_t>(bytes.size()), "replace"));
    };
    result.append(py::make_tuple(text(group.name), text(group.material)));
  }
  return result;
}

}  // namespace planish::python
