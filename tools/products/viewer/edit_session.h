#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/edit/editor.h"
#include "planish/pipeline/settings.h"
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

/// What the mouse does to a session, in a window and by a script alike. Places are in parts of the
/// picture, (0, 0) its upper left, (1, 1) its lower right.
class EditHand {
 public:
  explicit EditHand(EditSession& session) : session_(session) {}

  /// The vertex under the place: of the face that is seen there, or, beside the surface, one whose
  /// handle is less than 1.5 % of the height away.
  [[nodiscard]] std::optional<std::int32_t> vertex_at(const OrbitCamera& camera, float aspect,
                                                      const glm::vec2& place);
  /// Takes hold of the vertex there, so that drag() moves it with the place; it becomes the
  /// selection unless it belongs to it. `adds`: it joins the selection, or leaves it, and is not
  /// held. Returns it.
  std::optional<std::int32_t> press(const OrbitCamera& camera, float aspect, const glm::vec2& place,
                                    bool adds);
  [[nodiscard]] bool is_holding() const { return held_.has_value(); }
  /// The held vertex goes to that place, at its distance along the view; the selection goes along.
  void drag(const OrbitCamera& camera, float aspect, const glm::vec2& place);
  void release();
  /// Toggles the edge under the place; false where there is none.
  bool toggle_crease(const OrbitCamera& camera, float aspect, const glm::vec2& place);

 private:
  struct Held {
    glm::dvec3 start;  // of the vertex
    glm::vec2 from;    // the place that was pressed
    glm::vec2 handle;  // the vertex's place then
    bool has_moved = false;
  };
  EditSession& session_;
  std::optional<Held> held_;
};

/// What files of an edited scene say of it.
struct SaveOptions {
  FitSettings settings;  ///< of the scene; files have the axes of its input
  std::string source;    ///< the input's file
  int level = 2;         ///< of surfaces
};
[[nodiscard]] SaveOptions save_options(const Scene& scene);

enum class SavedPart { Mesh, Cage, Surface };

/// Writes the mesh with its moved points and tags (.obj, .ply, .off, .usda), the cage, which
/// `planish verify` takes against such a mesh, or the surface (.glb, .gltf). Throws
/// Error{InvalidArgument} for another extension, Error{UnwritableOutput}.
void save(const EditSession& session, SavedPart part, const std::filesystem::path& path,
          const SaveOptions& options);

/// All three: PREFIX.obj, PREFIX_cage.obj and PREFIX.glb. Returns what was written, for people.
std::string save_all(const EditSession& session, const std::string& prefix,
                     const SaveOptions& options);

}  // namespace planish::viewer
