#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "planish/edit/editor.h"
#include "scene.h"

namespace planish::viewer {

/// A scene whose points are picked, dragged, tagged and taken back, by planish's Editor on the CPU:
/// each move is solved where it reaches, and picking follows. A drag is one step of undo, however
/// many moves it takes.
class EditSession {
 public:
  /// Fits the scene's mesh. Throws what fit() and Editor throw.
  explicit EditSession(const Scene& scene);
  EditSession(const EditSession&) = delete;
  EditSession& operator=(const EditSession&) = delete;

  [[nodiscard]] const Editor& editor() const { return editor_; }
  /// Of the fit, which lengths are relative to.
  [[nodiscard]] double diagonal() const { return fit_.placement.diagonal; }
  /// Where the vertices are.
  [[nodiscard]] std::span<const glm::dvec3> points() const { return editor_.points(); }
  /// The mesh whose rules the surface has: its tags, in the pose that angles at corners are of.
  [[nodiscard]] PolygonMesh rest() const;
  /// Grows whenever rest() becomes another mesh.
  [[nodiscard]] int revision() const { return revision_; }

  /// The vertex nearest to where the ray first meets the surface, of the face that it meets.
  [[nodiscard]] std::optional<std::int32_t> pick(const SurfaceRay& ray);
  /// The edge nearest to it, of that face.
  [[nodiscard]] std::optional<std::pair<std::int32_t, std::int32_t>> pick_edge(
      const SurfaceRay& ray);

  /// What moves with a drag. Throws Error{InvalidArgument} for a vertex that is not there.
  void select(std::vector<std::int32_t> vertices);
  /// Adds a vertex, or takes it away where it is selected.
  void toggle(std::int32_t vertex);
  [[nodiscard]] std::span<const std::int32_t> selected() const { return selected_; }
  [[nodiscard]] bool is_selected(std::int32_t vertex) const;
  /// How far vertices around the selected ones move along, in the mesh's units; 0: none do. Throws
  /// Error{InvalidArgument} for one that is negative or not finite.
  void set_radius(double radius);
  [[nodiscard]] double radius() const { return radius_; }
  /// All that move, with their shares.
  [[nodiscard]] Selection reached() const;

  /// A drag takes the selection, with what is around it, from where it is now. drag_to() moves it
  /// by that way from there, end_drag() makes all of it one step of undo. Throws
  /// Error{InvalidArgument} where nothing is selected, and as Editor::move().
  void begin_drag();
  void drag_to(const glm::dvec3& way);
  void end_drag();
  [[nodiscard]] bool is_dragging() const { return drag_.has_value(); }

  /// Makes an edge or a vertex sharp, or smooth again. Throws as Editor::set_sharp().
  void toggle_crease(std::int32_t v0, std::int32_t v1);
  void toggle_corner(std::int32_t vertex);

  /// False where there is nothing to take back, or to do again.
  bool undo();
  bool redo();

 private:
  /// One step: vertices and where they were, or tags as they were.
  struct Step {
    std::vector<std::int32_t> vertices;
    std::vector<glm::dvec3> positions;
    std::vector<CreaseEdge> creases;
    std::vector<CornerVertex> corners;
  };
  struct Drag {
    Selection moved;
    Step before;
  };
  [[nodiscard]] std::optional<SurfaceHit> hit(const SurfaceRay& ray);
  [[nodiscard]] Step apply(const Step& step);
  void add(Step&& before);
  bool take(std::deque<Step>& from, std::deque<Step>& to);

  PolygonMesh mesh_;
  std::shared_ptr<const FairDecisions> decisions_;  // of the fit
  Fit fit_;
  Editor editor_;
  std::vector<std::int32_t> selected_;
  double radius_ = 0;
  std::optional<Drag> drag_;
  std::deque<Step> past_, future_;
  int revision_ = 0;
};

}  // namespace planish::viewer
