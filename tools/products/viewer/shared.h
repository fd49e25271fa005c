// What C++ and the viewer's shaders must agree on.
#ifdef __cplusplus
#pragma once
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
namespace planish::viewer::shared {
using uint = std::uint32_t;
using glm::mat4;
using glm::vec2;
using glm::vec3;
using glm::vec4;
#define VIEWER_CONSTANT inline constexpr
#else
#define VIEWER_CONSTANT const
#endif

// Bindings of the one descriptor set.
VIEWER_CONSTANT uint kGivenBinding = 0u;     // 3 floats a vertex of the mesh
VIEWER_CONSTANT uint kControlBinding = 1u;   // 4 floats a control point
VIEWER_CONSTANT uint kVerticesBinding = 2u;  // kVertexFloats a vertex of the surface
VIEWER_CONSTANT uint kUsedBinding = 3u;      // of each used vertex its place among the given
VIEWER_CONSTANT uint kEdgesBinding = 4u;     // 2 control points a cage edge
VIEWER_CONSTANT uint kOffsetsBinding = 5u;   // of each vertex of the surface its first row below
VIEWER_CONSTANT uint kNearestBinding = 6u;   // used vertices
VIEWER_CONSTANT uint kBindingCount = 7u;

// The second set is what planish_surface.glsl reads, of tessellation alone.
VIEWER_CONSTANT uint kSurfaceSet = 1u;
VIEWER_CONSTANT uint kWordsBinding = 0u;
VIEWER_CONSTANT uint kLinksBinding = 1u;
VIEWER_CONSTANT uint kStateBinding = 2u;
VIEWER_CONSTANT uint kSurfaceGivenBinding = 3u;
VIEWER_CONSTANT uint kWeightsBinding = 4u;
VIEWER_CONSTANT uint kSurfaceBindingCount = 5u;

// What tessellation may leave between the surface and its triangles, seen at a right angle.
VIEWER_CONSTANT float kChordPixels = 0.25f;
VIEWER_CONSTANT float kMostSegments =
    64.0f;  // of an edge, which every device with tessellation has

// A vertex of the surface: position, normal and error.
VIEWER_CONSTANT uint kVertexFloats = 7u;
VIEWER_CONSTANT uint kNormalFloat = 3u;
VIEWER_CONSTANT uint kErrorFloat = 6u;

// Of a crowd: position, normal and the position in the frame before.
VIEWER_CONSTANT uint kCrowdFloats = 9u;
VIEWER_CONSTANT uint kBeforeFloat = 6u;

VIEWER_CONSTANT uint kErrorGroup = 64u;  // invocations of a work group of vertex_error.comp

VIEWER_CONSTANT float kBoardSquares = 16.0f;  // of textured.frag, from 0 to 1 of u and of v

// Push constants of all draws.
struct DrawParameters {
  mat4 clip_from_world;
  vec3 eye;
  float diagonal;  // of the mesh; errors are shown relative to it
  vec3 key;        // unit direction to the main light
  uint heat;       // 1: colours by error
  vec2 viewport;   // pixels
  float width;     // of lines and dots, in pixels
  float alpha;
  uint face_count;   // of the surface
  uint is_software;  // 1: a CPU plays the device
};

// Colours of errors, relative to the diagonal, logarithmic from 10^kHeatLowest to 10^kHeatHighest:
// from dark to light, so that they tell in grey too.
VIEWER_CONSTANT float kHeatLowest = -7.0f;
VIEWER_CONSTANT float kHeatHighest = -1.0f;
VIEWER_CONSTANT uint kHeatStopCount = 5u;
VIEWER_CONSTANT vec3 kHeatStops[kHeatStopCount] = {
    vec3(0.16f, 0.12f, 0.53f), vec3(0.50f, 0.07f, 0.62f), vec3(0.80f, 0.28f, 0.47f),
    vec3(0.97f, 0.58f, 0.25f), vec3(0.96f, 0.95f, 0.35f)};

#ifdef __cplusplus
static_assert(sizeof(DrawParameters) == 120);
}  // namespace planish::viewer::shared
#undef VIEWER_CONSTANT
#endif
