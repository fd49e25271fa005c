#pragma once

// Includes nothing that has inline code: compiled for several instruction sets.
namespace planish {

/// Triangles whose directions are found side by side.
inline constexpr int kTangentLanes = 64;

/// Corners of triangles, one array a coordinate.
struct TangentBatch {
  double position[3][3][kTangentLanes];
  double normal[3][3][kTangentLanes];
  double uv[3][2][kTangentLanes];
};

/// Where u grows at each corner, square to its normal, as long as the triangle's angle there; and
/// twice the triangle's area in the texture, with a sign.
struct TangentSums {
  double along[3][3][kTangentLanes];
  double area[kTangentLanes];
};

/// All lanes are computed; unused ones need finite numbers.
void measure_tangents(const TangentBatch& triangles, TangentSums& sums);

}  // namespace planish
