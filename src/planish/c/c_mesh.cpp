#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <string>

#include "planish/c/handles.h"
#include "planish/c/planish.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/words.h"
#include "planish/files/mesh_file.h"

namespace planish::c {
namespace {

constexpr std::size_t kMaxCount = std::numeric_limits<std::int32_t>::max();

void require_count(std::size_t count, const void* array, const char* name) {
  if (count > kMaxCount) refuse(formatted("{}: {} elements are more than 2^31 - 1", name, count));
  if (count > 0 && array == nullptr) refuse(formatted("{} is NULL, with {} elements", name, count));
}

void require_vertex(std::int32_t vertex, std::size_t count, const char* what, std::size_t index) {
  if (vertex >= 0 && static_cast<std::size_t>(vertex) < count) return;
  throw Error(ErrorCode::UnusableMesh,
              formatted("{} {} names vertex {} of {}", what, index, vertex, count),
              static_cast<std::int64_t>(index));
}

void require_counts(const planish_mesh_arrays& arrays) {
  require_count(arrays.vertex_count, arrays.positions, "positions");
  require_count(arrays.corner_count, arrays.face_vertices, "face_vertices");
  if (arrays.face_count > kMaxCount) refuse("face_count is more than 2^31 - 1");
  require_count(arrays.crease_count, arrays.crease_edges, "crease_edges");
  require_count(arrays.sharp_corner_count, arrays.corner_vertices, "corner_vertices");
  if (arrays.face_sizes == nullptr && arrays.face_count > 0 && arrays.corners_per_face < 1)
    refuse(formatted("face_sizes is NULL and corners_per_face is {}", arrays.corners_per_face));
}

std::int32_t face_size(const planish_mesh_arrays& arrays, std::size_t face) {
  return arrays.face_sizes != nullptr ? arrays.face_sizes[face] : arrays.corners_per_face;
}

void require_faces(const planish_mesh_arrays& arrays) {
  std::size_t end = 0;
  for (std::size_t f = 0; f < arrays.face_count; ++f) {
    const std::int32_t size = face_size(arrays, f);
    if (size < 0 || static_cast<std::size_t>(size) > arrays.corner_count - end) {
      refuse(formatted("face {} has {} corners, and {} of corner_count are left", f, size,
                       arrays.corner_count - end));
    }
    end += static_cast<std::size_t>(size);
    for (std::size_t c = end - static_cast<std::size_t>(size); c < end; ++c)
      require_vertex(arrays.face_vertices[c], arrays.vertex_count, "face", f);
  }
  if (end != arrays.corner_count) {
    refuse(
        formatted("corner_count is {}, and the faces have {} corners", arrays.corner_count, end));
  }
}

void add_faces(const planish_mesh_arrays& arrays, PolygonMesh& mesh) {
  mesh.face_offsets.reserve(arrays.face_count + 1);
  for (std::size_t f = 0; f < arrays.face_count; ++f)
    mesh.face_offsets.push_back(mesh.face_offsets.back() + face_size(arrays, f));
  mesh.face_vertices.assign(arrays.face_vertices, arrays.face_vertices + arrays.corner_count);
}

void require_numbers(const std::int32_t* numbers, std::size_t length, std::size_t count,
                     std::int32_t least, const char* name) {
  for (std::size_t i = 0; i < length; ++i)
    if (numbers[i] < least || numbers[i] >= static_cast<std::int64_t>(count))
      refuse(formatted("{}[{}] is {} of {}", name, i, numbers[i], count));
}

void add_groups(const planish_mesh_arrays& arrays, PolygonMesh& mesh) {
  require_count(arrays.group_count, arrays.group_names, "group_names");
  if (arrays.group_count == 0) return;
  require_count(arrays.face_count, arrays.face_groups, "face_groups");
  require_numbers(arrays.face_groups, arrays.face_count, arrays.group_count, 0, "face_groups");
  for (std::size_t i = 0; i < arrays.group_count; ++i) {
    require(arrays.group_names[i], "a name in group_names");
    const char* const material =
        arrays.group_materials != nullptr ? arrays.group_materials[i] : nullptr;
    mesh.groups.push_back({arrays.group_names[i], material != nullptr ? material : ""});
  }
  mesh.face_groups.assign(arrays.face_groups, arrays.face_groups + arrays.face_count);
}

void add_attributes(const planish_mesh_arrays& arrays, PolygonMesh& mesh) {
  constexpr std::int32_t kWidest = 1024;
  require_count(arrays.attribute_count, arrays.attributes, "attributes");
  for (std::size_t i = 0; i < arrays.attribute_count; ++i) {
    const planish_attribute& given = arrays.attributes[i];
    require(given.name, "the name of an attribute");
    if (given.width < 1 || given.width > kWidest)
      refuse(formatted("attribute \"{}\" has a width of {}; 1 to 1024 is wanted",
                       visible(std::string_view(given.name)), given.width));
    require_count(arrays.vertex_count, given.values, "the values of an attribute");
    const std::size_t count = memory_size(std::uint64_t{sizeof(float)} * arrays.vertex_count *
                                              static_cast<std::uint64_t>(given.width),
                                          "the values of an attribute") /
                              sizeof(float);
    mesh.attributes.push_back({given.name, {given.values, given.values + count}, given.width});
  }
  require_attributes(mesh.attributes);
}

void add_riders(const planish_mesh_arrays& arrays, PolygonMesh& mesh) {
  require_count(arrays.uv_count, arrays.uvs, "uvs");
  if (arrays.face_uvs != nullptr) {
    require_numbers(arrays.face_uvs, arrays.corner_count, arrays.uv_count, -1, "face_uvs");
    for (std::size_t i = 0; i < arrays.uv_count; ++i)
      mesh.uvs.emplace_back(arrays.uvs[2 * i], arrays.uvs[2 * i + 1]);
    mesh.face_uvs.assign(arrays.face_uvs, arrays.face_uvs + arrays.corner_count);
  } else if (arrays.uv_count > 0) {
    refuse(formatted("face_uvs is NULL, with {} texture coordinates", arrays.uv_count));
  }
  if (arrays.colors != nullptr)
    for (std::size_t v = 0; v < arrays.vertex_count; ++v) {
      const float* c = arrays.colors + 4 * v;
      mesh.colors.emplace_back(c[0], c[1], c[2], c[3]);
    }
  add_groups(arrays, mesh);
  add_attributes(arrays, mesh);
}

PolygonMesh mesh_of(const planish_mesh_arrays& arrays) {
  require_counts(arrays);
  require_faces(arrays);
  PolygonMesh mesh;
  add_faces(arrays, mesh);
  mesh.positions.reserve(arrays.vertex_count);
  for (std::size_t v = 0; v < arrays.vertex_count; ++v) {
    const double* p = arrays.positions + 3 * v;
    mesh.positions.emplace_back(p[0], p[1], p[2]);
  }
  for (std::size_t i = 0; i < arrays.crease_count; ++i) {
    const std::int32_t* edge = arrays.crease_edges + 2 * i;
    require_vertex(edge[0], arrays.vertex_count, "crease", i);
    require_vertex(edge[1], arrays.vertex_count, "crease", i);
    mesh.creases.push_back({edge[0], edge[1]});
  }
  for (std::size_t i = 0; i < arrays.sharp_corner_count; ++i) {
    require_vertex(arrays.corner_vertices[i], arrays.vertex_count, "corner", i);
    mesh.corners.push_back({arrays.corner_vertices[i]});
  }
  add_riders(arrays, mesh);
  return mesh;
}

}  // namespace

std::unique_ptr<planish_mesh> new_mesh(PolygonMesh&& mesh) {
  auto handle = std::make_unique<planish_mesh>();
  handle->face_sizes.reserve(static_cast<std::size_t>(mesh.face_count()));
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    handle->face_sizes.push_back(mesh.face_size(f));
  handle->mesh = std::move(mesh);
  handle->riders.take(handle->mesh);
  return handle;
}

}  // namespace planish::c

using namespace planish::c;

void planish_mesh_arrays_init(planish_mesh_arrays* arrays, size_t struct_size) {
  start({}, arrays, struct_size);
}

planish_status planish_mesh_create(const planish_mesh_arrays* arrays, planish_mesh** mesh) {
  return call([&] {
    require(arrays, "arrays");
    require(mesh, "mesh");
    *mesh = new_mesh(mesh_of(taken(arrays, planish_mesh_arrays_init, "arrays"))).release();
    return PLANISH_OK;
  });
}

planish_status planish_mesh_read(const char* path, planish_mesh** mesh) {
  return call([&] {
    require(path, "path");
    require(mesh, "mesh");
    planish::MeshFile file = planish::read_mesh(planish::path_of(path));
    std::unique_ptr<planish_mesh> made = new_mesh(std::move(file.mesh));
    made->warnings = std::move(file.warnings);
    made->inputs.add(planish::path_of(path));
    *mesh = made.release();
    return PLANISH_OK;
  });
}

size_t planish_mesh_warning_count(const planish_mesh* mesh) {
  return mesh == nullptr ? 0 : mesh->warnings.size();
}

planish_status planish_mesh_warning(const planish_mesh* mesh, size_t index, const char** code,
                                    const char** message) {
  return call([&] {
    require(mesh, "mesh");
    give_warning(mesh->warnings, "mesh", index, code, message);
    return PLANISH_OK;
  });
}

planish_status planish_mesh_write(const planish_mesh* mesh, const char* path) {
  return call([&] {
    require(mesh, "mesh");
    require(path, "path");
    const auto format = planish::format_of(planish::path_of(path));
    if (!format || !planish::serves(*format, planish::FormatUse::WriteMesh)) {
      refuse(planish::visible(std::string_view(path)) + ": meshes are written as " +
             planish::extensions_in_words(planish::FormatUse::WriteMesh));
    }
    const planish::InputFiles inputs = mesh->inputs;  // other threads may write the mesh, too
    planish::write_mesh(planish::path_of(path), *format, mesh->mesh, {.inputs = &inputs});
    return PLANISH_OK;
  });
}

planish_status planish_mesh_view(const planish_mesh* mesh, planish_mesh_arrays* arrays) {
  return call([&] {
    require(mesh, "mesh");
    planish_mesh_arrays own;
    planish_mesh_arrays_init(&own, sizeof own);
    own.vertex_count = mesh->mesh.positions.size();
    own.positions = own.vertex_count > 0 ? &mesh->mesh.positions[0].x : nullptr;
    own.face_sizes = mesh->face_sizes.data();
    own.face_count = mesh->face_sizes.size();
    own.face_vertices = mesh->mesh.face_vertices.data();
    own.corner_count = mesh->mesh.face_vertices.size();
    mesh->riders.give(mesh->mesh, own);
    give(own, arrays, "arrays");
    return PLANISH_OK;
  });
}

void planish_mesh_free(planish_mesh* mesh) { delete mesh; }
