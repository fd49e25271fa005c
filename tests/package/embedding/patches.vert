#version 450
#extension GL_GOOGLE_include_directive : require
#include "patches.glsl"
// A patch is a corner of a face, known by its number alone. Its edges' levels follow from their ends,
// so that both sides choose the same.
layout(location = 0) out uint corner;
layout(location = 1) out vec4 levels;

float level_of(vec3 a, vec3 b) {
  precise vec4 along = clip_from_world * vec4(a - b, 0.0);
  return clamp(ceil(edges * length(along.xy)), 1.0, 64.0);
}

void main() {
  corner = gl_VertexIndex;
  vec3 v = position_at(corner, vec2(0.0, 0.0)), e1 = position_at(corner, vec2(1.0, 0.0));
  vec3 f = position_at(corner, vec2(1.0, 1.0)), e2 = position_at(corner, vec2(0.0, 1.0));
  levels = vec4(level_of(v, e2), level_of(v, e1), level_of(e1, f), level_of(e2, f));
}
