#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "options.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/surface/surface_mesh.h"

namespace planish::python {

/// planish.Mesh.
struct PythonMesh {
  PolygonMesh mesh;
};

/// planish.Surface.
struct PythonSurface {
  SurfaceMesh surface;
};

/// planish.Fit.
struct PythonFit {
  FittedMesh fitted;
  std::string name = "mesh";  ///< of the mesh in glTF
  int threads = 0;
  Precision precision = Precision::Float;
  double seconds = 0;  ///< of fit()
};

using MeshHandle = std::shared_ptr<PythonMesh>;
using SurfaceHandle = std::shared_ptr<PythonSurface>;
using FitHandle = std::shared_ptr<PythonFit>;

// Each adds its part to the module.
void add_mesh(pybind11::module_& module);
void add_fit(pybind11::module_& module);
void add_limit(pybind11::module_& module);

/// The report of the command on this fit, with its names.
[[nodiscard]] pybind11::dict report_of(const PythonFit& fit);
/// What the report has as "surface", of a level of it.
[[nodiscard]] pybind11::dict quality_of(const PythonFit& fit, int level);

/// Writes a Fit's surface (`level` splits), a Surface or a Mesh.
void write(const std::string& path, const pybind11::object& what, int level);

/// A path of Python's: text, bytes or os.PathLike.
[[nodiscard]] std::string path_of(const pybind11::object& path);

}  // namespace planish::python
