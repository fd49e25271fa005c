#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "call.h"
#include "planish/edit/editor.h"
#include "planish/files/mesh_file.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/surface/surface_blocks.h"

namespace planish::python {

/// planish.Mesh.
struct PythonMesh {
  PolygonMesh mesh;
  InputFiles inputs{};  ///< that were read for it; copies and pickles have none
};

/// planish.Surface.
struct PythonSurface {
  SurfaceMesh surface;
  InputFiles inputs{};  ///< of its fit
};

/// planish.Fit.
struct PythonFit {
  FittedMesh fitted;
  std::string name = "mesh";  ///< of the mesh in glTF
  int threads = 0;
  Precision precision = Precision::Float;
  double seconds = 0;   ///< of fit()
  InputFiles inputs{};  ///< of its mesh
};

/// An editor with the fit that it reads: arrays and queries that it gave keep it, too.
struct PythonEdited {
  PythonEdited(std::shared_ptr<PythonFit> of, int level)
      : first(std::move(of)), editor(first->fitted, level) {}
  PythonEdited(std::shared_ptr<PythonFit> of, Editor&& made)
      : first(std::move(of)), editor(std::move(made)) {}

  std::shared_ptr<PythonFit> first;
  Editor editor;
};

/// planish.Editor. Work is done without Python's lock, so that other
/// threads may come meanwhile, and functions of the caller's that it calls.
struct PythonEditor {
  PythonEditor(std::shared_ptr<PythonFit> of, int level)
      : edited(std::make_shared<PythonEdited>(std::move(of), level)) {}

  [[nodiscard]] const PythonFit& first() const { return *edited->first; }
  [[nodiscard]] Editor& editor() const { return edited->editor; }

  /// Another one once tags have changed; set with Python's lock.
  std::shared_ptr<PythonEdited> edited;
  std::atomic<int> users = 0;  ///< that only read; kChanging: one that changes it
  static constexpr int kChanging = -1;
};

/// Stands while an editor is used. Throws Error{InvalidArgument} where another use forbids it.
class EditorUse {
 public:
  enum class Kind : std::uint8_t { Reads, Changes };
  EditorUse(PythonEditor& editor, Kind kind);
  ~EditorUse();
  EditorUse(const EditorUse&) = delete;
  EditorUse& operator=(const EditorUse&) = delete;

 private:
  PythonEditor& editor_;
};

using MeshHandle = std::shared_ptr<PythonMesh>;
using SurfaceHandle = std::shared_ptr<PythonSurface>;
using FitHandle = std::shared_ptr<PythonFit>;
using EditorHandle = std::shared_ptr<PythonEditor>;

// Each adds its part to the module.
void add_mesh(pybind11::module_& module);
void add_fit(pybind11::module_& module);
void add_limit(pybind11::module_& module);
void add_editor(pybind11::module_& module);  ///< after add_fit(): Fit.edit() is its

/// The report of the command on this fit, with its names.
[[nodiscard]] pybind11::dict report_of(const PythonFit& fit);
/// What the report has as "surface", of a level of it.
[[nodiscard]] pybind11::dict quality_of(const PythonFit& fit, int level);

/// planish.LimitSurface of an editor's surface, which follows it.
[[nodiscard]] pybind11::object limit_surface_of(const EditorHandle& editor);

/// Writes a Fit's surface (`level` splits), a Surface or a Mesh.
void write(const std::string& path, const pybind11::object& what, int level,
           const pybind11::kwargs& keywords);

/// A path of Python's: text, bytes or os.PathLike.
[[nodiscard]] std::string path_of(const pybind11::object& path);

/// All that a Mesh, a Surface or a Fit holds as bytes, for pickles of this version of planish on
/// machines alike: no format for files.
[[nodiscard]] std::string packed(const PythonMesh& mesh);
[[nodiscard]] std::string packed(const PythonSurface& surface);
[[nodiscard]] std::string packed(const PythonFit& fit);

/// The same object from them. Throws Error{UnreadableInput} for bytes of another version or kind,
/// or that end early.
void unpack(std::string_view bytes, PythonMesh& mesh);
void unpack(std::string_view bytes, PythonSurface& surface);
void unpack(std::string_view bytes, PythonFit& fit);

}  // namespace planish::python
