#version 450
// As many segments as keep triangles within kChordPixels of the surface. Those of an edge follow from
// the edge alone, so that both sides choose the same.
#extension GL_GOOGLE_include_directive : require
#include "patches.glsl"

// A patch's one point, which is its corner's number and its levels: a lane a patch, where invocations
// for a patch's edges would leave most lanes of a group idle.
layout(location = 0) out uint corner;
layout(location = 1) out vec4 outer;
layout(location = 2) out vec2 inner;

// Of a chord that is off by that much, near points that far before the eye. A curve's error falls with
// the square of its segments.
float segments(vec3 off, float depth) {
  vec3 down = vec3(draw.clip_from_world[0].y, draw.clip_from_world[1].y, draw.clip_from_world[2].y);
  precise float square = off.x * off.x + off.y * off.y + off.z * off.z;
  precise float scale = 0.5 * draw.viewport.y *
                        sqrt(down.x * down.x + down.y * down.y + down.z * down.z);
  precise float pixels = scale * sqrt(square) / max(depth, 1e-20);
  return clamp(ceil(sqrt(pixels / kChordPixels)), 1.0, kMostSegments);
}

float depth_of(vec3 point) {
  precise float depth = draw.clip_from_world[0].w * point.x + draw.clip_from_world[1].w * point.y +
                        draw.clip_from_world[2].w * point.z + draw.clip_from_world[3].w;
  return depth;
}

// One loop makes all points: drivers put functions in wherever they are called.
vec3 points[25];  // 5 v + u, in quarters

// Of every step-th point from the first; a parabola is off by 3/4 of the most at a quarter.
float segments_along(uint first, uint step) {
  vec3 a = points[first], b = points[first + 4u * step];
  vec3 near = points[first + step], far = points[first + 3u * step];
  precise vec3 near_off = (near - (0.75 * a + 0.25 * b)) * (4.0 / 3.0);
  precise vec3 far_off = (far - (0.25 * a + 0.75 * b)) * (4.0 / 3.0);
  float depth = min(min(depth_of(a), depth_of(b)), min(depth_of(near), depth_of(far)));
  return max(segments(near_off, depth), segments(far_off, depth));
}

// Mesa's llvmpipe (22.3) makes a patch's vertices four at a time and goes through loops but once where
// fewer are left: there, so many that none are. They are the levels' sum along the border, and
// (x - 1) (y - 1) within.
vec2 whole_groups(vec4 border, vec2 within) {
  uvec2 levels = max(uvec2(within), 2u);
  levels.y += (2u - levels.y) & 3u;
  levels.x += (1u - uint(border.x + border.y + border.z + border.w) - levels.x) & 3u;
  // Beyond what there is, fewer.
  levels -= 4u * uvec2(greaterThan(levels, uvec2(kMostSegments)));
  return vec2(levels);
}

void main() {
  uint end = gl_InstanceIndex;  // of the draw's corners; what is beyond has levels of 0: nothing
  corner = min(gl_VertexIndex, end - 1u);
  // Where one of the two is an even quarter.
  for (uint i = 0u; i < 25u; ++i) {
    uint u = i % 5u, v = i / 5u;
    if ((u & v & 1u) == 0u) points[i] = patch_position(corner, 0.25 * vec2(u, v));
  }
  outer = vec4(segments_along(0u, 5u), segments_along(0u, 1u), segments_along(4u, 5u),
               segments_along(20u, 1u));
  // Within, as the borders, the lines through the middle and the twist want it.
  float nearest = min(min(depth_of(points[0]), depth_of(points[4])),
                      min(depth_of(points[20]), depth_of(points[24])));
  float twist = segments(0.25 * ((points[0] - points[4]) + (points[24] - points[20])), nearest);
  inner = vec2(max(max(outer.y, outer.w), max(segments_along(10u, 1u), twist)),
               max(max(outer.x, outer.z), max(segments_along(2u, 5u), twist)));
  if (draw.is_software != 0u) inner = whole_groups(outer, inner);
  if (gl_VertexIndex >= end) outer = vec4(0.0);
}
