#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "keywords.h"
#include "planish/core/error.h"
#include "planish/core/words.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/files/write_surface.h"
#include "planish/job/fit_file.h"
#include "planish/pipeline/asset_attributes.h"
#include "planish/pipeline/verify_cage.h"
#include "planish/reconstruct/mesher_process.h"
#include "planish/reconstruct/reconstruct.h"

namespace py = pybind11;

namespace planish::python {
namespace {

FileFormat require_format(const std::string& path, FormatUse use) {
  const auto format = format_of(path);
  if (!format || !serves(*format, use))
    refuse(
        formatted("{}: {} is wanted", visible(std::string_view(path)), extensions_in_words(use)));
  return *format;
}

void write_the_mesh(const std::string& path, const PolygonMesh& mesh, const InputFiles& inputs) {
  write_mesh(path, require_format(path, FormatUse::WriteMesh), mesh, {.inputs = &inputs});
}

void write_the_surface(const std::string& path, const SurfaceMesh& surface,
                       const InputFiles& inputs) {
  const FileFormat format = require_format(path, FormatUse::WriteSurfaceFile);
  require_apart(inputs, path, format);
  GltfOptions options;
  const auto attributes = add_attributes(*blocks_of(surface, {}), options.fields, {});
  if (info_of(format).is_gltf) {
    write_gltf(path, surface, options);
  } else {
    write_surface(path, format, surface, {}, options.fields);
  }
}

py::array points_array(PointCloud&& cloud) {
  for (glm::dvec3& point : cloud.points) point += cloud.origin;
  const auto count = static_cast<py::ssize_t>(cloud.points.size());
  auto* const kept = new std::vector<glm::dvec3>(std::move(cloud.points));
  const py::capsule owner(
      kept, [](void* pointer) { delete static_cast<std::vector<glm::dvec3>*>(pointer); });
  return py::array_t<double>({count, py::ssize_t{3}}, kept->empty() ? nullptr : &(*kept)[0].x,
                             owner);
}

MeshHandle read_the_mesh(const py::object& path, bool split_normals, const std::string& textures) {
  const std::string file = path_of(path);
  const FileReach reach = reach_argument(textures);
  auto made = std::make_shared<PythonMesh>();
  MeshFile read;
  run_released({}, [&](const Callbacks&) {
    read = planish::read_mesh(std::filesystem::path(file),
                              {.split_normals_crease = split_normals, .reach = reach});
  });
  warn(read.warnings);
  made->mesh = std::move(read.mesh);
  made->inputs.add(file, {}, reach);
  return made;
}

// Values of as many floats each.
template <class Value>
py::array_t<float> floats_of(const std::vector<Value>& values) {
  constexpr auto kWidth = static_cast<py::ssize_t>(sizeof(Value) / sizeof(float));
  return py::array_t<float>({static_cast<py::ssize_t>(values.size()), kWidth},
                            values.empty() ? nullptr : &values[0].x);
}

// What the file has of reconstruct()'s keywords.
py::dict point_keywords(const PointCloud& cloud) {
  py::dict keywords;
  if (!cloud.normals.empty()) keywords["normals"] = floats_of(cloud.normals);
  if (!cloud.colors.empty()) keywords["colors"] = floats_of(cloud.colors);
  if (cloud.attributes.empty()) return keywords;
  py::dict attributes;
  for (const VertexAttribute& attribute : cloud.attributes)
    attributes[py::str(attribute.name)] = py::array_t<float>(
        static_cast<py::ssize_t>(attribute.values.size()), attribute.values.data());
  keywords["attributes"] = attributes;
  return keywords;
}

// Adds what the keywords give of each point.
void add_to_points(const py::object& normals, const py::object& colors,
                   const py::object& attributes, PointCloud& cloud) {
  PolygonMesh mesh;
  mesh.positions = std::move(cloud.points);
  MeshArguments riders;
  riders.colors = colors;
  riders.attributes = attributes;
  riders.add_to(mesh);
  cloud.points = std::move(mesh.positions);
  cloud.colors = std::move(mesh.colors);
  cloud.attributes = std::move(mesh.attributes);
  if (normals.is_none()) return;
  const Doubles rows = as_rows(normals, "normals", 3, 3);
  if (rows.shape(0) != std::ssize(cloud.points))
    refuse(
        formatted("normals: {} for {}", rows.shape(0), counted(std::ssize(cloud.points), "point")));
  for (py::ssize_t i = 0; i < rows.shape(0); ++i)
    cloud.normals.emplace_back(rows.at(i, 0), rows.at(i, 1), rows.at(i, 2));
}

MeshHandle reconstruct_points(const py::object& points, double tolerance,
                              std::int64_t target_vertices, bool quads, const std::string& spacing,
                              const py::object& normals, const py::object& colors,
                              const py::object& attributes, const py::object& progress,
                              const py::object& cancelled) {
  const Doubles values = as_points(points, "points");
  if (spacing != "adaptive" && spacing != "even")
    refuse("spacing: \"" + spacing + "\"; one of adaptive, even is wanted");
  const auto program = find_mesher_program();
  if (!program) {
    throw MissingProgram(
        "points need the program planish-reconstruct, which is neither on PATH nor named by the "
        "environment variable PLANISH_RECONSTRUCT; Debian's package planish has it, and a build "
        "with CGAL makes it");
  }
  const auto given = points_of(values);
  PointCloud cloud = cloud_of({given.begin(), given.end()}, "points");
  add_to_points(normals, colors, attributes, cloud);
  auto made = std::make_shared<PythonMesh>();
  run_released({progress, cancelled}, [&](const Callbacks& callbacks) {
    ReconstructOptions options;
    options.tolerance = tolerance;
    options.target_vertices = target_vertices;
    options.pair_quads = quads;
    options.spacing = spacing == "even" ? Spacing::Even : Spacing::Adaptive;
    options.callbacks = callbacks;
    made->mesh = std::move(reconstruct(cloud, mesher_process(*program), options).mesh);
  });
  return made;
}

Verification verify_mesh(const MeshHandle& cage, const MeshHandle& given,
                         const py::object& sharp_edges, const py::object& sharp_corners,
                         const py::kwargs& rest) {
  const FitArguments arguments = fit_arguments(rest, "verify");
  VerifyOptions options = verify_options(arguments.settings);
  FoundCreases found;
  if (!sharp_edges.is_none()) {
    const Integers edges = as_integers(sharp_edges, "sharp_edges");
    if (edges.ndim() != 2 || edges.shape(1) != 2)
      refuse("sharp_edges: integers of shape (n, 2) are wanted");
    for (py::ssize_t i = 0; i < edges.shape(0); ++i)
      found.edges.push_back({edges.at(i, 0), edges.at(i, 1)});
  }
  if (!sharp_corners.is_none()) {
    const Integers corners = as_integers(sharp_corners, "sharp_corners");
    if (corners.ndim() != 1) refuse("sharp_corners: integers of shape (n,) are wanted");
    found.corners.assign(corners.data(), corners.data() + corners.size());
  }
  if (!sharp_edges.is_none() || !sharp_corners.is_none()) options.found = &found;
  Verification result;
  run_released(
      arguments.callbacks,
      [&](const Callbacks&) { result = verify_cage(cage->mesh, given->mesh, options); },
      arguments.threads);
  return result;
}

void add_mesh_class(py::module_& module) {
  py::class_<PythonMesh, MeshHandle> type(
      module, "Mesh", "Polygons of any size, counter-clockwise seen from outside.");
  const std::string text =
      "vertices: numbers (n, 3). faces: integers (m, k); or a tuple (sizes, indices); or a list of "
      "faces. Raises InvalidArgument for shapes, UnusableMesh for an index that names no "
      "vertex.\n" +
      std::string(mesh_keywords());
  const py::none none;
  type.def(py::init([](const py::object& vertices, const py::object& faces,
                       const py::object& crease_edges, const py::object& corner_vertices,
                       const py::object& uvs, const py::object& face_uvs, const py::object& colors,
                       const py::object& groups, const py::object& face_groups,
                       const py::object& attributes) {
             auto made = std::make_shared<PythonMesh>();
             made->mesh = mesh_of(vertices, faces);
             require_indices(made->mesh);
             MeshArguments{crease_edges, corner_vertices, uvs,         face_uvs,
                           colors,       groups,          face_groups, attributes}
                 .add_to(made->mesh);
             return made;
           }),
           py::arg("vertices"), py::arg("faces"), py::kw_only(), py::arg("crease_edges") = none,
           py::arg("corner_vertices") = none, py::arg("uvs") = none, py::arg("face_uvs") = none,
           py::arg("colors") = none, py::arg("groups") = none, py::arg("face_groups") = none,
           py::arg("attributes") = none, text.c_str())
      .def_property_readonly(
          "vertices",
          [](const py::object& self) {
            const PolygonMesh& mesh = self.cast<PythonMesh&>().mesh;
            return view(mesh.positions.empty() ? nullptr : &mesh.positions[0].x,
                        {mesh.vertex_count(), 3}, self);
          },
          "float64 (n, 3), a read-only view.")
      .def_property_readonly(
          "faces",
          [](const py::object& self) {
            const PolygonMesh& mesh = self.cast<PythonMesh&>().mesh;
            return faces_view(mesh.face_offsets, mesh.face_vertices, self);
          },
          "int32 (m, k) where all faces have k corners, else (sizes, indices).")
      .def_property_readonly(
          "offsets",
          [](const py::object& self) {
            const PolygonMesh& mesh = self.cast<PythonMesh&>().mesh;
            return view(mesh.face_offsets.data(), {mesh.face_count() + 1}, self);
          },
          "int32 (m + 1,): the corners of face f are indices[offsets[f]:offsets[f + 1]].")
      .def_property_readonly(
          "indices",
          [](const py::object& self) {
            const PolygonMesh& mesh = self.cast<PythonMesh&>().mesh;
            return view(mesh.face_vertices.data(),
                        {static_cast<py::ssize_t>(mesh.face_vertices.size())}, self);
          },
          "int32: the vertices of all faces, one after another.")
      .def_property_readonly(
          "crease_edges",
          [](const PythonMesh& self) {
            std::vector<std::int32_t> edges;
            for (const CreaseEdge& crease : self.mesh.creases)
              edges.insert(edges.end(), {crease.v0, crease.v1});
            const auto count = static_cast<py::ssize_t>(edges.size()) / 2;
            return take_over(std::move(edges), {count, 2});
          },
          "int32 (c, 2): edges that stay sharp.")
      .def("__repr__", [](const PythonMesh& self) {
        return formatted("<planish.Mesh: {}, {}>", counted(self.mesh.vertex_count(), "vertex"),
                         counted(self.mesh.face_count(), "face"));
      });
  add_riders(type, [](const py::object& self) -> const PolygonMesh& {
    return self.cast<PythonMesh&>().mesh;
  });
  add_pickle<PythonMesh>(type, &packed, &unpack);
}

void add_verification(py::module_& module) {
  py::class_<Verification>(module, "Verification",
                           "How far given vertices are from the surface of a cage.")
      .def_readonly("confirmed", &Verification::confirmed, "max_error is at most the tolerance.")
      .def_property_readonly(
          "max_error", [](const Verification& v) { return v.error.max; },
          "Of the bounding box's diagonal.")
      .def_property_readonly(
          "rms_error", [](const Verification& v) { return v.error.rms; },
          "Of the bounding box's diagonal.")
      .def_readonly("worst_vertex", &Verification::worst_vertex, "Index of a given vertex.")
      .def_readonly("vertex_count", &Verification::vertex_count, "Of the given mesh, repaired.");
}

}  // namespace

std::string path_of(const py::object& path) {
  const py::object bytes = py::module_::import("os").attr("fsencode")(path);
  return py::cast<std::string>(bytes);
}

void write(const std::string& path, const py::object& what, const py::object& level,
           const py::kwargs& keywords) {
  const Settings settings =
      write_arguments(keywords, level.is_none() ? std::nullopt : std::optional(level.cast<int>()));
  if (py::isinstance<PythonFit>(what)) {
    const auto fit = what.cast<FitHandle>();
    const auto backend =
        make_cpu_backend({.solve_precision = fit->precision, .thread_count = fit->threads});
    const InputFiles inputs = fit->inputs;
    std::vector<Warning> warnings;
    run_released({}, [&](const Callbacks& callbacks) {
      (void)write_fitted_surface(path, fit->fitted, *backend,
                                 {.settings = settings,
                                  .name = fit->name,
                                  .callbacks = collecting(callbacks, warnings),
                                  .inputs = &inputs});
    });
    warn(warnings);
  } else if (py::isinstance<PythonSurface>(what)) {
    const auto surface = what.cast<SurfaceHandle>();
    const InputFiles inputs = surface->inputs;
    run_released({}, [&](const Callbacks&) { write_the_surface(path, surface->surface, inputs); });
  } else if (py::isinstance<PythonMesh>(what)) {
    const auto mesh = what.cast<MeshHandle>();
    const InputFiles inputs = mesh->inputs;
    run_released({}, [&](const Callbacks&) { write_the_mesh(path, mesh->mesh, inputs); });
  } else {
    throw py::type_error("write() takes a Fit, a Surface or a Mesh");
  }
}

void add_mesh(py::module_& module) {
  add_mesh_class(module);
  add_verification(module);
  module.def(
      "read", &read_the_mesh, py::arg("path"), py::kw_only(), py::arg("split_normals") = false,
      py::arg("textures") = "beside",
      "The mesh in an OBJ, PLY, OFF, STL, glTF or GLB file, by extension. With split_normals "
      "edges where the file splits its normals are creases. textures: \"anywhere\" follows what "
      "the file names out of its folder. UserWarning "
      "where something was passed "
      "over or mended. Raises UnreadableInput, InvalidArgument for an extension.");
  module.def(
      "read_points",
      [](const py::object& path, bool keywords) -> py::object {
        PointCloud cloud;
        const std::string file = path_of(path);
        run_released({}, [&](const Callbacks&) {
          cloud = planish::read_points(std::filesystem::path(file));
        });
        warn(cloud.warnings);
        if (!keywords) return points_array(std::move(cloud));
        const py::dict given = point_keywords(cloud);
        return py::make_tuple(points_array(std::move(cloud)), given);
      },
      py::arg("path"), py::kw_only(), py::arg("keywords") = false,
      "The points in a PLY, XYZ, PTS, PCD, LAS or PTX file: float64 (n, 3). `keywords`: a tuple of "
      "these and of what the file has of reconstruct()'s keywords, {\"normals\": float32 (n, 3), "
      "\"colors\": float32 (n, 4), \"attributes\": {name: float32 (n,)}}. UserWarning where "
      "something was passed over.");
  const std::string write_text =
      "Writes the surface of a Fit (`level` splits; None: 2, of a dense mesh 1) or a Surface as "
      "glTF, GLB, OBJ, PLY, OFF, STL "
      "or USD text, a Fit also as STEP, or a Mesh as OBJ, PLY, OFF or USD text, by extension. An "
      "old file stays until the new one is whole. Files that read() read for it are never written "
      "over. Raises UnwritableOutput, InvalidArgument.\n" +
      keywords_text(is_write_keyword);
  module.def(
      "write",
      [](const py::object& path, const py::object& what, const py::object& level,
         const py::kwargs& keywords) { write(path_of(path), what, level, keywords); },
      py::arg("path"), py::arg("what"), py::kw_only(), py::arg("level") = py::none(),
      write_text.c_str());
  module.def(
      "reconstruct", &reconstruct_points, py::arg("points"), py::kw_only(),
      py::arg("tolerance") = 1e-4, py::arg("target_vertices") = 0, py::arg("quads") = true,
      py::arg("spacing") = "adaptive", py::arg("normals") = py::none(),
      py::arg("colors") = py::none(), py::arg("attributes") = py::none(),
      py::arg("progress") = py::none(), py::arg("cancelled") = py::none(),
      "A mesh near every one of these points, numbers (n, 3): within `tolerance` of the "
      "diagonal. `normals` of the points, (n, 3), turn open sheets; `colors` and `attributes`, "
      "as fit() takes them, come to the mesh's vertices. Needs the program planish-reconstruct. "
      "Raises MissingProgram without it, "
      "UnusableMesh for points that span no surface.");
  module.def(
      "verify", &verify_mesh, py::arg("cage").none(false), py::arg("given").none(false),
      py::kw_only(), py::arg("sharp_edges") = py::none(), py::arg("sharp_corners") = py::none(),
      "How far the vertices of the mesh `given` are from the surface of the control mesh "
      "`cage`, by limit points in double. Further keywords are those of fit() that shaped "
      "the surface, sharp_edges and sharp_corners those of the Fit; `method` is \"progressive\" "
      "unless it is given. Raises UnusableMesh for "
      "a cage of another mesh.");
}

}  // namespace planish::python
