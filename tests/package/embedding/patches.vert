#version 450
#extension GL_GOOGLE_include_directive : require
#include "patches.glsl"
// A patch is a corner of a face, known by its number alone. Its edges' levels follow from their ends,
// so that both sides choose the same.
layout(location = 0) out uint corner;
layout(location = 1) out vec4 outer;
layout(location = 2) out vec2 inner;

float level_of(vec3 a, vec3 b) {
  precise vec4 along = clip_from_world * vec4(a - b, 0.0);
  return clamp(ceil(edges * length(along.xy)), 1.0, 64.0);
}

// Mesa's llvmpipe (22.3) makes a patch's vertices four at a time and goes through loops but once where
// fewer are left: there, so many that none are. They are the levels' sum along the border, and
// (x - 1) (y - 1) within.
vec2 whole_groups(vec4 border, vec2 within) {
  uvec2 levels = max(uvec2(within), 2u);
  levels.y += (2u - levels.y) & 3u;
  levels.x += (1u - uint(border.x + border.y + border.z + border.w) - levels.x) & 3u;
  levels -= 4u * uvec2(greaterThan(levels, uvec2(64u)));  // beyond what there is, fewer
  return vec2(levels);
}

void main() {
  // Beyond the last corner, too, where lanes of a group would be left: levels of 0, nothing.
  corner = min(gl_VertexIndex, corner_count - 1u);
  vec3 v = position_at(corner, vec2(0.0, 0.0)), e1 = position_at(corner, vec2(1.0, 0.0));
  vec3 f = position_at(corner, vec2(1.0, 1.0)), e2 = position_at(corner, vec2(0.0, 1.0));
  outer = vec4(level_of(v, e2), level_of(v, e1), level_of(e1, f), level_of(e2, f));
  inner = max(outer.yx, outer.wz);
  if (is_software != 0u) inner = whole_groups(outer, inner);
  if (gl_VertexIndex >= corner_count) outer = vec4(0.0);
}
