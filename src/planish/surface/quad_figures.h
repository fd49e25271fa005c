#pragma once

// Includes nothing that has inline code: compiled for several instruction sets.
namespace planish {

/// Quads that are measured side by side.
inline constexpr int kQuadLanes = 64;

/// Triangles thinner than this (area by squared perimeter) have angles that rounding decides; they
/// arise where a boundary runs straight through the corner of a quad.
inline constexpr double kThinTriangle = 1e-6;

/// Corners of quads, one array a coordinate, and the unit normal that each quad should have.
struct QuadBatch {
  double position[4][3][kQuadLanes];
  double normal[4][3][kQuadLanes];
  double wanted[3][kQuadLanes];
};

/// What SurfaceQuality sums, of each quad.
struct QuadFigures {
  double area[kQuadLanes];
  double folded[kQuadLanes];   ///< area of corners that are turned over
  double squares[kQuadLanes];  ///< area times squared angle, in radians
  double largest[kQuadLanes];  ///< angle
  double bending[kQuadLanes];
};

/// All corners of kQuadLanes quads: 12 numbers a quad of each, x, y and z of its corners in turn.
void take_corners(const double* positions, const float* normals, QuadBatch& quads);

/// All lanes are computed; unused ones need finite numbers.
void measure_quads(const QuadBatch& quads, QuadFigures& figures);

}  // namespace planish
