#include "attributes.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "arrays.h"
#include "errors.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/files/shared/srgb.h"

namespace py = pybind11;

namespace planish::python {
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
