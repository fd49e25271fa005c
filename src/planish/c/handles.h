#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "planish/backend/cpu_backend.h"
#include "planish/c/editor.h"
#include "planish/c/planish.h"
#include "planish/edit/editor.h"
#include "planish/files/input_files.h"
#include "planish/job/job_settings.h"
#include "planish/limit/limit_surface.h"
#include "planish/limit/surface_queries.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/surface/surface_mesh.h"

// What the handles of planish.h hold. Names are C's, so they stand in no namespace.

namespace planish::c {

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
