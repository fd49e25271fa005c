#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "make_scenes/implicit.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::shapes {

struct RevolveOptions {
  std::int32_t segment_count = 64;  ///< around the axis; a multiple of 4, at least 8
  std::int32_t ring_count = 119;    ///< circles along the profile between the two caps
  double cap_radius = 0.3;          ///< within it, discs of quads close the surface at the axis
};

/// Surface of revolution about the y axis, quads only, genus 0. `profile` holds (radius, height)
/// knots of a smooth curve from the axis, outward below and back to the axis above; radii rise from
/// 0 to beyond the cap at its start and fall likewise at its end. Rings lie closer where the curve
/// bends.
[[nodiscard]] PolygonMesh revolve(std::span<const glm::dvec2> profile,
                                  const RevolveOptions& options);

/// Wine goblet: foot, stem with a knop, thin-walled bowl; 8,066 vertices, genus 0, y up.
[[nodiscard]] PolygonMesh goblet();

/// Rocker arm of an engine, y up: a bored hub along z, a ribbed arm to a boss with a blind socket
/// for the push rod, another down to the valve pad. Quads only, genus 1, about 14,000 vertices.
[[nodiscard]] PolygonMesh rocker_arm();

/// The shape that it stands for: negative inside, zero on the surface.
[[nodiscard]] double rocker_arm_field(const glm::dvec3& p);

/// Bust of a composer, y up, looking along +z: face, wild hair, cravat, coat and socle. Quads only,
/// genus 0, about 16,400 vertices.
[[nodiscard]] PolygonMesh bust();

/// Its parts as distance functions; see implicit.h.
[[nodiscard]] double bust_face(const glm::dvec3& p);
[[nodiscard]] double bust_body(const glm::dvec3& p);

/// A lock of hair: a chain of balls swept into each other.
struct Lock {
  std::vector<glm::dvec3> points;
  std::vector<double> radii;
  glm::dvec3 centre;  ///< of a ball that holds it
  double reach;       ///< that ball's radius
};

/// The locks of the head, always the same.
[[nodiscard]] std::vector<Lock> bust_locks();
[[nodiscard]] double bust_hair(const glm::dvec3& p, const std::vector<Lock>& locks);

enum class Sampling { Uniform, PoissonDisk };

struct ScanOptions {
  Sampling sampling = Sampling::Uniform;
  std::int32_t point_count = 200'000;
  double tolerance = 1e-4;  ///< of simplification, a fraction of the diagonal; 0 keeps every point
  double least_angle = -1;  ///< of its triangles, as in SimplifyOptions
  bool pair_quads = false;
  std::uint32_t seed = 1;
};

/// What a scanner and planish make of a shape: its surface sampled, every point moved onto the zero
/// set of `field` if there is one and rounded to 1e-6, the points meshed and simplified. Uneven
/// triangles, as simplification leaves them. Throws as reconstruct().
[[nodiscard]] PolygonMesh scan(const PolygonMesh& shape, const Field& field, const Mesher& mesher,
                               const ScanOptions& options = {});

/// The rocker arm scanned: a scene that needs a mesher, and changes with the simplifier.
inline constexpr const char* kScanFile = "rocker_arm_scan.obj";
[[nodiscard]] PolygonMesh scanned_rocker_arm(const Mesher& mesher);

}  // namespace planish::shapes
