#include <chrono>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "keywords.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/job/fit_file.h"
#include "planish/measure/figures.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/statistics.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/fit_report.h"
#include "planish/surface/quality_sum.h"

namespace py = pybind11;

namespace planish::python {
namespace {

// As `planish fit --report` has it: numbers that are none become None.
py::object python_of(const nlohmann::ordered_json& json) {
  using Json = nlohmann::ordered_json;
  return py::module_::import("json").attr("loads")(
      json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

nlohmann::ordered_json input_of(const FittedMesh& fitted) {
  const PreparedMesh& prepared = *fitted.fit.prepared;
  const FoldedEdges folds = folded_edges(fitted.mesh, *prepared.topology);
  return input_json(fitted.figures(), statistics(prepared), folds.count, folds.area);
}

py::dict timing_of(const PythonFit& fit) {
  const FitTiming& timing = fit.fitted.fit.timing;
  py::dict result;
  result["check"] = timing.check;
  result["topology"] = timing.topology;
  result["stencils"] = timing.stencils;
  result["upload"] = timing.upload;
  result["solve"] = timing.solve;
  result["total"] = 1e3 * fit.seconds;
  return result;
}

}  // namespace

py::dict report_of(const PythonFit& fit) {
  py::dict report, tool;
  tool["name"] = "planish";
  tool["version"] = PLANISH_VERSION;
  report["tool"] = tool;
  report["input"] = python_of(input_of(fit.fitted));
  report["solve"] = python_of(solve_json(fit.fitted.figures()));
  report["timing_ms"] = timing_of(fit);
  report["warnings"] = python_of(warnings_json(fit.fitted.warnings));
  return report;
}

py::dict quality_of(const PythonFit& fit, int level) {
  const FittedMesh& fitted = fit.fitted;
  SurfaceQuality quality;
  run_released(
      {},
      [&](const Callbacks& callbacks) {
        require_level(level);
        const SurfaceMeter meter(fitted.mesh, fitted.fit, fitted.evaluate_options());
        quality = meter.at(level, callbacks);
        if (level == kBendingLevel) return;
        const SurfaceQuality* const known = fitted.chosen_quality();
        quality.bending = known ? known->bending : meter.at(kBendingLevel, callbacks).bending;
      },
      fit.threads);
  return py::dict(python_of(quality_json(quality, level)));
}

namespace {

FitHandle new_fit(const FitArguments& arguments) {
  auto made = std::make_shared<PythonFit>();
  made->threads = arguments.threads;
  made->precision = solve_precision(arguments.settings);
  return made;
}

FitHandle fit_arrays(const py::object& vertices, const py::object& faces,
                     const py::kwargs& keywords) {
  const auto start = std::chrono::steady_clock::now();
  const FitArguments arguments = fit_arguments(keywords, "fit");
  PolygonMesh mesh;
  InputFiles inputs;
  if (py::isinstance<PythonMesh>(vertices)) {
    if (!faces.is_none()) refuse("faces: a Mesh has its own; leave them out");
    mesh = vertices.cast<PythonMesh&>().mesh;
    inputs = vertices.cast<PythonMesh&>().inputs;
  } else if (faces.is_none()) {
    refuse("faces: are missing; fit() takes vertices and faces, or a Mesh");
  } else {
    mesh = mesh_of(vertices, faces);
  }
  arguments.mesh.add_to(mesh);
  FitHandle made = new_fit(arguments);
  made->inputs = std::move(inputs);
  const auto backend = arguments.make_backend();
  run_released(arguments.callbacks, [&](const Callbacks& callbacks) {
    MeshFitOptions options = mesh_fit_options(arguments.settings);
    options.fit.callbacks = callbacks;
    made->fitted = fit_mesh(std::move(mesh), "mesh", *backend, options);
  });
  made->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return made;
}

FitHandle fit_files(const py::object& input, const py::object& output, const py::object& levels,
                    const py::object& cage, const py::object& report, const py::object& page,
                    const py::object& source, py::kwargs keywords) {
  const auto start = std::chrono::steady_clock::now();
  keywords["levels"] = levels;
  FitArguments arguments = fit_arguments(std::move(keywords), "fit_file");
  arguments.mesh.visit([](const char* name, const py::object& value) {
    if (!value.is_none()) refuse(std::string(name) + ": belongs to fit(); a file has its own");
  });
  const std::filesystem::path from = path_of(input), to = path_of(output);
  FitFileOptions options;
  options.settings = arguments.settings;
  if (!cage.is_none()) options.cage = path_of(cage);
  if (!report.is_none()) options.report = path_of(report);
  if (!page.is_none()) options.page = path_of(page);
  if (!source.is_none()) options.source = path_of(source);
  options.limits = arguments.limits;
  FitHandle made = new_fit(arguments);
  const auto backend = arguments.make_backend();
  options.backend = backend.get();
  run_released(arguments.callbacks, [&](const Callbacks& callbacks) {
    options.callbacks = callbacks;
    made->fitted = fit_file(from, to, options).fitted;
  });
  made->name = visible(from.stem());
  made->inputs.add(from, {}, arguments.settings.textures);
  made->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return made;
}

py::list fit_many(const py::iterable& inputs, const py::object& folder, const py::object& levels,
                  const std::string& extension, const py::object& pages, py::kwargs keywords) {
  keywords["levels"] = levels;
  FitArguments arguments = fit_arguments(std::move(keywords), "fit_files");
  arguments.mesh.visit([](const char* name, const py::object& value) {
    if (!value.is_none()) refuse(std::string(name) + ": belongs to fit(); a file has its own");
  });
  std::vector<std::filesystem::path> from;
  for (const py::handle input : inputs)
    from.push_back(path_of(py::reinterpret_borrow<py::object>(input)));
  const std::filesystem::path to = path_of(folder);
  FitFilesOptions options{.settings = arguments.settings, .extension = extension};
  if (!pages.is_none()) options.pages = path_of(pages);
  options.limits = arguments.limits;
  const auto backend = arguments.make_backend();
  options.backend = backend.get();
  std::vector<std::string> failures;
  run_released(arguments.callbacks, [&](const Callbacks& callbacks) {
    options.callbacks = callbacks;
    failures = fit_files(from, to, options);
  });
  py::list made;
  for (const std::string& failure : failures)
    made.append(failure.empty() ? py::object(py::none()) : py::object(py::str(visible(failure))));
  return made;
}

SurfaceHandle evaluate_fit(const FitHandle& fit, const py::object& level,
                           const py::object& progress, const py::object& cancelled) {
  auto made = std::make_shared<PythonSurface>();
  std::vector<Warning> warnings;
  const int splits = level.is_none() ? fit->fitted.density.level() : level.cast<int>();
  run_released({progress, cancelled}, [&](const Callbacks& callbacks) {
    EvaluateOptions options = fit->fitted.evaluate_options(splits);
    options.callbacks = collecting(callbacks, warnings);
    const auto backend =
        make_cpu_backend({.solve_precision = fit->precision, .thread_count = fit->threads});
    made->surface = evaluate(fit->fitted.mesh, fit->fitted.fit, *backend, options);
  });
  made->inputs = fit->inputs;
  warn(warnings);
  return made;
}

SurfaceHandle tessellate_fit(const FitHandle& fit, double chord_error, double angle,
                             const py::object& progress, const py::object& cancelled) {
  if (fit->fitted.options.scheme != Scheme::DooSabin)
    refuse("tessellate: is of Doo-Sabin surfaces; fit with scheme=\"doo-sabin\"");
  auto made = std::make_shared<PythonSurface>();
  std::vector<Warning> warnings;
  run_released(
      {progress, cancelled},
      [&](const Callbacks& callbacks) {
        made->surface = tessellate(fit->fitted, {.chord_error = chord_error,
                                                 .angle = angle,
                                                 .callbacks = collecting(callbacks, warnings)});
      },
      fit->threads);
  made->inputs = fit->inputs;
  warn(warnings);
  return made;
}

MeshHandle cage_of(const FitHandle& fit) {
  auto made = std::make_shared<PythonMesh>();
  const FittedMesh& fitted = fit->fitted;
  made->mesh = control_cage(fitted.mesh, fitted.fit, fitted.options.sharp);
  made->inputs = fit->inputs;
  return made;
}

py::object surface_faces(const py::object& self) {
  const SurfaceMesh& surface = self.cast<PythonSurface&>().surface;
  if (!surface.face_offsets.empty())
    return faces_view(surface.face_offsets, surface.face_vertices, self);
  return view(surface.face_vertices.data(), {surface.face_count(), 4}, self);
}

py::object surface_quads(const py::object& self) {
  const SurfaceMesh& surface = self.cast<PythonSurface&>().surface;
  if (surface.face_offsets.empty())
    return view(surface.face_vertices.data(), {surface.face_count(), 4}, self);
  refuse(surface.is_triangles() ? "quads: the surface has triangles; take faces"
                                : "quads: level 0 has the mesh's polygons; take faces");
}

template <class Value>
py::object rows_view(const RawVector<Value>& rows, const py::object& self) {
  return view(rows.empty() ? nullptr : &rows[0].x, {static_cast<py::ssize_t>(rows.size()), 3},
              self);
}

void add_surface_class(py::module_& module) {
  py::class_<PythonSurface, SurfaceHandle> type(
      module, "Surface", "A tessellation whose every vertex lies on the limit surface.");
  type.def_property_readonly(
          "positions",
          [](const py::object& self) {
            return rows_view(self.cast<PythonSurface&>().surface.positions, self);
          },
          "float64 (n, 3) in the mesh's unit, a read-only view.")
      .def_property_readonly(
          "normals",
          [](const py::object& self) {
            return rows_view(self.cast<PythonSurface&>().surface.normals, self);
          },
          "float32 (n, 3) of unit length, exact but for the last bits.")
      .def_property_readonly("quads", &surface_quads,
                             "int32 (m, 4). Raises InvalidArgument at level 0 and for triangles.")
      .def_property_readonly("faces", &surface_faces,
                             "int32 (m, k) where all faces have k corners, else (sizes, indices).")
      .def_property_readonly(
          "base_vertices",
          [](const py::object& self) {
            const SurfaceMesh& surface = self.cast<PythonSurface&>().surface;
            return view(surface.base_vertices.data(),
                        {static_cast<py::ssize_t>(surface.base_vertices.size())}, self);
          },
          "int32 (b,): position i < b is the limit point of this vertex of fit.mesh.")
      .def_property_readonly(
          "level", [](const PythonSurface& self) { return self.surface.level; }, "Splits.")
      .def("__repr__", [](const PythonSurface& self) {
        return formatted("<planish.Surface: level {}, {}, {}>", self.surface.level,
                         counted(std::ssize(self.surface.positions), "vertex"),
                         counted(self.surface.face_count(), "face"));
      });
  add_riders(type, [](const py::object& self) -> const SurfaceMesh& {
    return self.cast<PythonSurface&>().surface;
  });
  add_pickle<PythonSurface>(type, &packed, &unpack);
}

void add_fit_class(py::module_& module) {
  py::class_<PythonFit, FitHandle> type(module, "Fit",
                                        "The smooth surface through the vertices of a mesh.");
  type.def_property_readonly("cage", &cage_of,
                             "The control mesh; of the fair method that of the next level.")
      .def_property_readonly(
          "mesh",
          [](const FitHandle& self) {
            auto made = std::make_shared<PythonMesh>();
            made->mesh = self->fitted.mesh;
            made->inputs = self->inputs;
            return made;
          },
          "What was fitted: the given mesh, repaired and tagged.")
      .def_property_readonly(
          "method",
          [](const PythonFit& self) {
            const bool fair = self.fitted.options.method == InterpolationMethod::Fair;
            return fair ? "fair" : "progressive";
          },
          "\"progressive\" or \"fair\".")
      .def_property_readonly(
          "sharp_edges",
          [](const py::object& self) {
            const auto& edges = self.cast<PythonFit&>().fitted.found.edges;
            const std::int32_t* first = edges.empty() ? nullptr : edges.front().data();
            return view(first, {static_cast<py::ssize_t>(edges.size()), 2}, self);
          },
          "int32 (n, 2): vertices of the mesh at edges that were found to be sharp, for verify().")
      .def_property_readonly(
          "sharp_corners",
          [](const py::object& self) {
            const auto& corners = self.cast<PythonFit&>().fitted.found.corners;
            return view(corners.data(), {static_cast<py::ssize_t>(corners.size())}, self);
          },
          "int32 (n,): vertices of the mesh that were found to be corners, for verify().")
      .def_property_readonly(
          "converged",
          [](const PythonFit& self) { return self.fitted.fit.interpolation.converged; },
          "Whether the tolerance was reached.")
      .def_property_readonly(
          "max_error",
          [](const PythonFit& self) { return self.fitted.fit.interpolation.error.max; },
          "Of a vertex from the surface, as a fraction of the bounding box's diagonal.")
      .def_property_readonly("report", &report_of,
                             "What the command reports, with its names: tool, input, solve, "
                             "timing_ms (milliseconds), warnings.")
      .def("evaluate", &evaluate_fit, py::arg("level") = py::none(), py::kw_only(),
           py::arg("progress") = py::none(), py::arg("cancelled") = py::none(),
           "The surface after `level` splits, 0 to 6; None: 2, of a dense mesh 1. Raises "
           "InvalidArgument, OutOfMemory before "
           "memory is taken, Cancelled.")
      .def("tessellate", &tessellate_fit, py::kw_only(), py::arg("chord_error") = 0.0,
           py::arg("angle") = 0.0, py::arg("progress") = py::none(),
           py::arg("cancelled") = py::none(),
           "Triangles as fine as the surface is curved: within chord_error of it, a fraction of "
           "the bounding box's diagonal, and turning by at most so many degrees, but where a "
           "UserWarning says so; 0: any, but not "
           "both. Watertight where the mesh is. Raises InvalidArgument, OutOfMemory before memory "
           "is taken, Cancelled.")
      .def("quality", &quality_of, py::arg("level") = 2,
           "The \"surface\" of a report: folded area, deviation of normals in degrees, bending, "
           "which is that of level 1 whatever the level.")
      .def("__repr__", [](const PythonFit& self) {
        return formatted("<planish.Fit: {}, {}", counted(self.fitted.mesh.vertex_count(), "vertex"),
                         self.fitted.fit.interpolation.converged ? "converged>" : "not converged>");
      });
  add_pickle<PythonFit>(type, &packed, &unpack);
}

}  // namespace

void add_fit(py::module_& module) {
  add_surface_class(module);
  add_fit_class(module);
  const std::string fit_text =
      std::string(
          "The smooth surface through the vertices of a mesh.\n\n"
          "fit(vertices, faces, **options) or fit(mesh, **options) -> Fit\n\n"
          "    vertices: numbers (n, 3). faces: integers (m, k); or a tuple (sizes, "
          "indices);\n        or a list of faces.\n") +
      mesh_keywords() + fit_keywords().substr(1) +
      "\n\nNot reaching the tolerance is a result: see Fit.converged. Raises UnusableMesh,\n"
      "InvalidArgument, OutOfMemory, Cancelled. The same as `planish fit --device cpu`, to the "
      "last "
      "bit.";
  module.def("fit", &fit_arrays, py::arg("vertices"), py::arg("faces") = py::none(),
             fit_text.c_str());
  const std::string file_text =
      std::string(
          "From file to file: reads a mesh, points or a glTF, fits, and writes the surface and, "
          "where\nnamed, its cage, a report and a page.\n\nfit_file(input, output, levels=None, "
          "cage=None, *, report=None, page=None, source=None, **options) -> Fit\n\n"
          "    report: JSON of what was done, as planish fit --report writes.\n"
          "    page: HTML to look at, as planish fit --page writes.\n"
          "    source: mesh that the surface is compared with; None: the input.\n"
          "    memory_limit, output_limit: bytes; point_limit: of the input; time_limit: seconds "
          "of\n        processor time. For hosts that run the work of others; 0: none.\n") +
      fit_keywords() + file_keywords() +
      "\n\nRaises what read(), fit(), reconstruct() and write() raise.";
  module.def("fit_file", &fit_files, py::arg("input"), py::arg("output"),
             py::arg("levels") = py::none(), py::arg("cage") = py::none(), py::kw_only(),
             py::arg("report") = py::none(), py::arg("page") = py::none(),
             py::arg("source") = py::none(), file_text.c_str());
  const std::string files_text =
      std::string(
          "Many files one after another, each into a folder under its name, and where named a page "
          "of\neach with index.html, a contact sheet, the worst first.\n\nfit_files(inputs, "
          "folder, "
          "levels=None, *, extension=\"glb\", pages=None, **options) -> list\n\n"
          "    pages: folder of the pages.\n"
          "    memory_limit, output_limit, point_limit, time_limit: of each, see fit_file().\n") +
      fit_keywords() + file_keywords() +
      "\n\nReturns of each input None, or the message of what was wrong with it: others are done.";
  module.def("fit_files", &fit_many, py::arg("inputs"), py::arg("folder"),
             py::arg("levels") = py::none(), py::kw_only(), py::arg("extension") = "glb",
             py::arg("pages") = py::none(), files_text.c_str());
}

}  // namespace planish::python
