#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planish/job/page/render.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::render {

/// What is drawn: a triangle mesh with normals.
struct RenderMesh {
  glm::dvec3 origin{0};  ///< that positions are from, in the scene's coordinates
  std::vector<glm::vec3> positions, normals;
  std::vector<std::uint32_t> indices;
  std::vector<float> values;  ///< of the attribute that was asked for, one a vertex; else none
};

/// All meshes of the default scene of a GLB that planish wrote, compressed or not, where their
/// nodes place them, from where the first one stands; with the numbers of an attribute
/// (_MEAN_CURVATURE and the like) if it is named. Throws Error{UnreadableInput} for anything else,
/// Error{OutOfMemory}.
[[nodiscard]] RenderMesh read_glb(const std::filesystem::path& path,
                                  const std::string& attribute = {});

/// The magnitude that 19 of 20 of these do not exceed, NaN left out; 1 where that is 0.
[[nodiscard]] float usual_magnitude(const std::vector<float>& values);

/// How fast the normal turns at each vertex, in radians over the bounding-box diagonal: the mean
/// over the edges of its triangles.
[[nodiscard]] std::vector<float> curvature_of(const RenderMesh& mesh);

/// A point that is lit: its light counts from the side that `normal` points to.
struct LitPoint {
  glm::vec3 position, normal;
};

/// A studio: a broad soft light above the camera's left, a weaker one on its right, an even room
/// and a bright floor. The mesh casts soft shadows; light that it throws back is left out.
class DomeLight {
 public:
  DomeLight(const RenderMesh& mesh, const Camera& camera);

  /// Irradiance at each point, 1 being that of a free point which faces the main light.
  [[nodiscard]] std::vector<float> irradiance(const std::vector<LitPoint>& points) const;
  /// The same without the mesh in the way.
  [[nodiscard]] float free_irradiance(const glm::vec3& normal) const;

  /// Direction to the middle of the main light.
  [[nodiscard]] const glm::vec3& key() const { return key_; }

 private:
  struct Lamp {
    glm::vec3 direction;
    float power;
  };
  void add_cone(const glm::vec3& axis, float half_angle_degrees, int count, float power);

  const RenderMesh& mesh_;
  std::vector<Lamp> lamps_;
  glm::vec3 key_;
  glm::vec3 centre_;
  float radius_;
  float unit_ = 1;
};

/// What stands in VisibilityBuffer::what for overlays.
inline constexpr std::uint32_t kEdgeSample = VisibilityBuffer::kNothing - 1;
inline constexpr std::uint32_t kVertexSample = VisibilityBuffer::kNothing - 2;

struct OverlayOptions {
  float edge_width = 5, vertex_width = 20;  ///< in samples; 0 for none
  float lift =
      2e-3f;  ///< towards the eye, as a fraction of the distance: lines on the surface show
};

/// Draws the edges and vertices of `mesh` where the surface does not hide them.
void draw_overlay(const PolygonMesh& mesh, const Camera& camera, const OverlayOptions& options,
                  VisibilityBuffer& buffer);

enum class Look {
  Clay,     ///< a matt light material
  Stripes,  ///< reflection lines: they are smooth where the surface's normals are
  Heat,     ///< colours by curvature
  Values,   ///< colours by the mesh's values, see signed_colour()
};

struct PictureOptions {
  int width = 1200, height = 900;
  ViewOptions view;
  Look look = Look::Clay;
  glm::vec3 colour{0.81f, 0.82f, 0.84f};  ///< sRGB
  float scale = 1;                     ///< of Look::Values: what the ends of the colours stand for
  bool wire = false;                   ///< the edges of the surface's quads
  std::optional<PolygonMesh> overlay;  ///< drawn as edges and vertices
  OverlayOptions overlay_options;
};

/// 8-bit sRGB, three bytes a pixel, top row first.
[[nodiscard]] std::vector<std::uint8_t> draw_picture(const RenderMesh& mesh,
                                                     const PictureOptions& options);

}  // namespace planish::render
