#include "planish/edit/editor.h"

#include <algorithm>
#include <glm/vec4.hpp>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/edit/editor_impl.h"
#include "planish/edit/require_editable.h"

namespace planish {

Editor::Editor(const PolygonMesh& mesh, const Fit& fit, const EditorOptions& options) {
  require_editable(mesh, fit, options);
  impl_ = std::make_unique<Impl>(mesh, fit, options);
}

Editor::Editor(const FittedMesh& fitted, int level)
    : Editor(fitted, EditorOptions{level, fitted.options}) {}

Editor::Editor(const FittedMesh& fitted, const EditorOptions& options)
    : Editor(fitted.mesh, fitted.fit, options) {
  impl_->lead(fitted.added_vertices);
}

Editor::Editor(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Editor::Editor(Editor&& other) noexcept = default;
Editor& Editor::operator=(Editor&& other) noexcept = default;
Editor::~Editor() = default;

EditChange Editor::move(std::span<const std::int32_t> vertices,
                        std::span<const glm::dvec3> positions, const Callbacks& callbacks) {
  return impl_->move(vertices, positions, callbacks);
}

EditChange Editor::transform(const Selection& selection, const glm::dmat4& map,
                             const Callbacks& callbacks) {
  if (selection.vertices.size() != selection.weights.size()) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("transform: there are {} vertices and {} weights; give one each",
                          selection.vertices.size(), selection.weights.size()));
  }
  std::vector<glm::dvec3> positions(selection.vertices.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const std::int32_t vertex = selection.vertices[i];
    if (vertex < 0 || vertex >= std::ssize(points())) continue;  // refused by move()
    const glm::dvec3& from = points()[vertex];
    const glm::dvec3 to(map * glm::dvec4(from, 1.0));
    positions[i] = from + selection.weights[i] * (to - from);
  }
  return move(selection.vertices, positions, callbacks);
}

Selection Editor::select(std::span<const std::int32_t> vertices, double radius) const {
  return impl_->select(vertices, radius);
}

EditChange Editor::set_sharp(std::span<const CreaseEdge> edges,
                             std::span<const CornerVertex> corners, const Callbacks& callbacks) {
  *this = with_sharp(edges, corners, callbacks);
  return everything();
}

Editor Editor::with_sharp(std::span<const CreaseEdge> edges, std::span<const CornerVertex> corners,
                          const Callbacks& callbacks) const {
  return Editor(impl_->with_sharp(edges, corners, callbacks));
}

EditChange Editor::everything() { return impl_->all_rows(); }

EditChange Editor::undo(const Callbacks& callbacks) {
  return impl_->step(impl_->past(), impl_->future(), callbacks);
}
EditChange Editor::redo(const Callbacks& callbacks) {
  return impl_->step(impl_->future(), impl_->past(), callbacks);
}
bool Editor::can_undo() const { return !impl_->past().empty(); }
bool Editor::can_redo() const { return !impl_->future().empty(); }

EditChange Editor::settle(const Callbacks& callbacks) { return impl_->settle(callbacks); }

EditChange Editor::refit(const Callbacks& callbacks) {
  *this = refitted(callbacks);
  return everything();
}

Editor Editor::refitted(const Callbacks& callbacks) const {
  return Editor(impl_->refitted(callbacks));
}

std::span<const glm::dvec3> Editor::points() const { return impl_->points(); }
std::span<const glm::dvec3> Editor::rest_positions() const { return impl_->rest_positions(); }
double Editor::error_bound() const { return impl_->error_bound(); }
double Editor::measured_error() const { return impl_->measured_error().norms.max; }
std::span<const glm::dvec3> Editor::positions() const { return impl_->surface().positions(); }
std::span<const glm::vec3> Editor::normals() const { return impl_->surface().normals(); }
PolygonMesh Editor::mesh() const { return impl_->mesh(); }
Fit Editor::fit() const { return impl_->fit(); }
const SurfaceQueries& Editor::queries() { return impl_->queries(); }
std::unique_ptr<SurfaceBlocks> Editor::blocks(int level) const {
  return impl_->surface().surface()->level(level);
}

namespace {

bool has_tags_of(const PolygonMesh& a, const PolygonMesh& b) {
  return std::ranges::equal(a.creases, b.creases,
                            [](const CreaseEdge& x, const CreaseEdge& y) {
                              return x.v0 == y.v0 && x.v1 == y.v1 && x.sharpness == y.sharpness;
                            }) &&
         std::ranges::equal(a.corners, b.corners, [](const CornerVertex& x, const CornerVertex& y) {
           return x.vertex == y.vertex && x.sharpness == y.sharpness;
         });
}

}  // namespace

FittedMesh edited(const FittedMesh& first, const Editor& editor) {
  FittedMesh result = first;
  const auto rest = editor.rest_positions();
  result.mesh = editor.mesh();
  result.fit = editor.fit();
  result.rest_positions.assign(rest.begin(), rest.end());
  if (!has_tags_of(result.mesh, first.mesh)) {
    // What is sharp was set by hand: no rule of the first fit finds it again.
    result.uses_tags = true;
    result.split_normals = false;
    result.finds_features = false;
    result.crease_degrees.reset();
    result.found = {};
  }
  // What was measured was the surface before the moves.
  result.level_one_quality.reset();
  return result;
}

}  // namespace planish
