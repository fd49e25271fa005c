#pragma once

#include <pybind11/pybind11.h>

#include <memory>

#include "planish/backend/backend.h"
#include "planish/pipeline/fit_mesh.h"
#include "work.h"

namespace planish::python {

/// What fit() takes behind the mesh.
struct FitArguments {
  MeshFitOptions mesh;
  bool split_normals = false;  ///< of fit_file() alone
  Precision precision = Precision::Float;
  int threads = 0;
  PythonCallbacks callbacks;
  pybind11::object crease_edges = pybind11::none(), corner_vertices = pybind11::none();

  [[nodiscard]] std::unique_ptr<Backend> make_backend() const;
};

/// Takes what it knows out of the keywords. Throws Error{InvalidArgument} for values, and TypeError
/// for keywords that remain.
[[nodiscard]] FitArguments fit_arguments(pybind11::kwargs keywords, const char* function);

/// Adds the tagged edges (m, 2) and vertices (n,). Throws Error{InvalidArgument}.
void add_tags(const FitArguments& arguments, PolygonMesh& mesh);

/// What the fit's keywords mean, for docstrings.
extern const char* const kFitKeywords;

}  // namespace planish::python
