#pragma once

// Includes nothing that has inline code: compiled for several instruction sets.
namespace planish {

/// Clusters of quads that are measured side by side.
inline constexpr int kTangentLanes = 32;
/// Of a vertex: position, normal, texture coordinate.
inline constexpr int kTangentNumbers = 8;

/// Clusters whose quads name alike the vertices of each. A triangle is a quad whose last two
/// vertices are one.
struct TangentQuads {
  int count;                     ///< quads of a cluster
  const unsigned char* corners;  ///< four vertices of each
  int vertex_count;
  /// [vertex][kTangentNumbers][kTangentLanes]: positions and texture coordinates from one of the
  /// cluster's own. They get scaled, by powers of two, so that their products are numbers.
  float* vertices;
  const int* cuts;  ///< [quad][kTangentLanes]: 1 where cut from corner 1 to 3, else 0
};

/// Adds to each vertex, of each triangle around it: where u grows, square to the normal, as long as
/// the triangle's angle there; and twice the triangle's area in the texture, with a sign.
/// `sums`: [vertex][4][kTangentLanes]. All lanes are computed; unused ones need finite numbers.
void measure_tangents(const TangentQuads& quads, float* sums);

}  // namespace planish
