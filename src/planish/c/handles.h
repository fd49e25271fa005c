#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/c/editor.h"
#include "planish/c/planish.h"
#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/edit/editor.h"
#include "planish/files/mesh_file.h"
#include "planish/job/job_settings.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/queries/limit_surface.h"
#include "planish/queries/surface_queries.h"
#include "planish/solve/backend.h"
#include "planish/surface/surface_blocks.h"

namespace planish::c {

/// Sets this thread's last error to the exception that is being handled. Returns its status.
[[nodiscard]] planish_status note_exception() noexcept;

/// Runs `work` and turns what it throws into a status and this thread's last error. A template, for
/// a std::function takes memory before anything is caught.
template <class Work>
[[nodiscard]] planish_status call(const Work& work) noexcept {
  try {
    return work();
  } catch (...) {
    return note_exception();
  }
}

/// Sets this thread's last error, for a status that comes with results.
void note(const char* message, std::int64_t element) noexcept;

/// The same of what `make_message` returns; where there is no memory for that, of `short_message`:
/// results that are there are not an error of memory.
template <class MakeMessage>
void note_of_results(const MakeMessage& make_message, const char* short_message) noexcept {
  try {
    note(make_message().c_str(), -1);
  } catch (const std::bad_alloc&) {
    note(short_message, -1);
  }
}

/// Runs `work` on so many threads; 0: all.
void run_on(int thread_count, const std::function<void()>& work);

/// Throws Error{InvalidArgument} that says which function wants what.
[[noreturn]] void refuse(const std::string& message);

/// Either target may be NULL. `of`: whose warnings they are, "mesh".
void give_warning(std::span<const Warning> warnings, const char* of, std::size_t index,
                  const char** code, const char** message);

template <class Pointer>
void require(Pointer* pointer, const char* name) {
  if (pointer == nullptr) refuse(std::string(name) + " is NULL");
}

/// Throws for NULL and for more values, or pairs of them, than the library counts.
void require_list(const std::int32_t* values, std::size_t count, const char* name,
                  const char* count_name);

/// Sets the defaults of a caller's struct of `size` bytes, as it knows it, and its size.
template <class Struct>
void start(const Struct& defaults, Struct* target, std::size_t size) {
  if (target == nullptr || size < sizeof size) return;
  std::memset(target, 0, size);
  std::memcpy(target, &defaults, size < sizeof defaults ? size : sizeof defaults);
  std::memcpy(target, &size, sizeof size);
}

/// A struct of the caller's, whatever version of the header it was compiled with: what it does not
/// know stays at its default. Throws Error{InvalidArgument} for a size that no header ever had.
template <class Struct>
Struct taken(const Struct* given, void (*init)(Struct*, std::size_t), const char* name) {
  Struct own;
  init(&own, sizeof own);
  if (given == nullptr) return own;
  std::size_t size = 0;
  std::memcpy(&size, given, sizeof size);
  if (size < sizeof size + 1 || size > 4096) {
    refuse(formatted("{}.struct_size is {}; planish_..._init() sets it", name, size));
  }
  std::memcpy(&own, given, size < sizeof own ? size : sizeof own);
  own.struct_size = sizeof own;
  return own;
}

/// Fills the part of the caller's struct that it knows.
template <class Struct>
void give(const Struct& own, Struct* target, const char* name) {
  require(target, name);
  std::size_t size = 0;
  std::memcpy(&size, target, sizeof size);
  if (size < sizeof size + 1 || size > 4096) {
    refuse(formatted("{}.struct_size is {}; planish_..._init() sets it", name, size));
  }
  std::memcpy(target, &own, size < sizeof own ? size : sizeof own);
  std::memcpy(target, &size, sizeof size);
}

// What the handle of planish_options_create() holds. Its name is C's, so it stands in no namespace.

}  // namespace planish::c

struct planish_options {
  planish::Settings settings;
  std::map<std::string_view, std::string> given;  ///< texts, by names of the tables
  std::map<std::string_view, std::string> texts;  ///< for planish_options_get(), of all names
  int thread_count = 0;
  planish::WorkLimits limits;
  int (*progress)(void* user, const char* step, double fraction) = nullptr;
  void* progress_user = nullptr;
  void (*warning)(void* user, const char* code, const char* message) = nullptr;
  void* warning_user = nullptr;
  std::map<std::string_view, std::string> files;  ///< of planish_fit_file(): paths, by "report"...
  std::optional<planish::FoundCreases> sharp;     ///< for planish_verify(); empty: is looked for

  planish_options();
  /// The path that is set by that name; empty: none.
  [[nodiscard]] std::string file(std::string_view name) const {
    const auto found = files.find(name);
    return found == files.end() ? std::string() : found->second;
  }
};

namespace planish::c {

/// "options.weights": how messages call an option.
[[nodiscard]] std::string spelled(std::string_view name);

/// Those, or the defaults for NULL.
[[nodiscard]] const planish_options& options_of(const planish_options* given);

/// All settings, which do not contradict each other. Throws as check_consistent().
[[nodiscard]] const Settings& consistent_settings(const planish_options& options);
/// The same, of a mesh that is no file. Throws where something is set that is of files alone.
[[nodiscard]] const Settings& mesh_settings(const planish_options& options);

/// The caller's functions. Another result of progress() than 0 throws Error{Cancelled}.
[[nodiscard]] Callbacks callbacks_of(const planish_options& options);

// What the handles of planish.h hold. Names are C's, so they stand in no namespace.

/// Views of what rides on a mesh or a surface, as C has them. Both must stay where they are.
struct RiderViews {
  std::vector<const char*> group_names, group_materials;
  std::vector<planish_attribute> attributes;

  template <class Mesh>
  void take(const Mesh& mesh) {
    for (const FaceGroup& group : mesh.groups) {
      group_names.push_back(group.name.c_str());
      group_materials.push_back(group.material.c_str());
    }
    for (const VertexAttribute& attribute : mesh.attributes)
      attributes.push_back({attribute.name.c_str(), attribute.width, attribute.values.data()});
  }
  template <class Mesh, class Arrays>
  void give(const Mesh& mesh, Arrays& arrays) const {
    if (!mesh.uvs.empty()) arrays.uvs = &mesh.uvs[0].x;
    arrays.uv_count = mesh.uvs.size();
    if (!mesh.face_uvs.empty()) arrays.face_uvs = mesh.face_uvs.data();
    if (!mesh.colors.empty()) arrays.colors = &mesh.colors[0].x;
    arrays.group_names = group_names.data();
    arrays.group_materials = group_materials.data();
    arrays.group_count = group_names.size();
    if (!mesh.face_groups.empty()) arrays.face_groups = mesh.face_groups.data();
    arrays.attributes = attributes.data();
    arrays.attribute_count = attributes.size();
  }
};

/// What a fit keeps of its options and its mesh, and hands on to what is made of it.
struct Kept {
  int thread_count = 0;
  Settings settings;
  InputFiles inputs;  ///< of its mesh

  [[nodiscard]] std::unique_ptr<Backend> make_backend() const {
    return make_cpu_backend(
        {.solve_precision = solve_precision(settings), .thread_count = thread_count});
  }
};

}  // namespace planish::c

struct planish_mesh {
  planish::PolygonMesh mesh;
  planish::InputFiles inputs;  ///< that were read for it
  planish::c::RiderViews riders;
  std::vector<std::int32_t> face_sizes;    ///< for views
  std::vector<planish::Warning> warnings;  ///< of the reader
};

struct planish_fit {
  std::shared_ptr<planish::FittedMesh> whole;  ///< with the queries that are made of it
  planish::FittedMesh& fitted;
  planish::c::Kept kept;

  /// Of planish_fit_write() and others; PLANISH_LEVEL_AUTO by options, or by the mesh's density.
  [[nodiscard]] int settled(std::int32_t level) const {
    if (level != PLANISH_LEVEL_AUTO) return level;
    return kept.settings.levels_by_density ? fitted.density.level()
                                           : std::ranges::max(kept.settings.levels);
  }

  planish_fit() : whole(std::make_shared<planish::FittedMesh>()), fitted(*whole) {}
};

struct planish_surface {
  planish::SurfaceMesh surface;
  planish::c::RiderViews riders;
  std::vector<planish::Warning> warnings;  ///< of its making

  [[nodiscard]] planish::Callbacks callbacks() {
    planish::Callbacks result;
    result.warning = [this](const planish::Warning& warning) { warnings.push_back(warning); };
    return result;
  }
};

/// Of a fit, with a surface of its own, or of an editor, whose surface moves.
struct planish_queries {
  std::shared_ptr<const void> source;
  std::unique_ptr<const planish::LimitSurface> own_limit;
  std::unique_ptr<const planish::SurfaceQueries> own;
  const planish::SurfaceQueries* queries = nullptr;
  int thread_count = 0;
};

namespace planish::c {

/// What an editor reads and the editor, for queries may outlive its handle.
struct EditedFit {
  std::shared_ptr<const FittedMesh> first;
  Editor editor;

  EditedFit(std::shared_ptr<const FittedMesh> fitted, int level)
      : first(std::move(fitted)), editor(*first, level) {}
  EditedFit(std::shared_ptr<const FittedMesh> fitted, Editor&& made)
      : first(std::move(fitted)), editor(std::move(made)) {}
};

}  // namespace planish::c

struct planish_editor {
  std::shared_ptr<planish::c::EditedFit> edited;
  std::vector<planish_row_range> rows;  ///< of the last change
  planish::Selection selection;         ///< the last one
  planish::c::Kept kept;                ///< of the fit
};

namespace planish::c {

/// A handle around a mesh.
[[nodiscard]] std::unique_ptr<planish_mesh> new_mesh(PolygonMesh&& mesh);

}  // namespace planish::c
