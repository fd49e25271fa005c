#version 450
// The control cage's edges as strips of some pixels' width, six vertices each.
#extension GL_GOOGLE_include_directive : require
#include "draw.glsl"

layout(set = 0, binding = kControlBinding) readonly buffer Control { vec4 control[]; };
layout(set = 0, binding = kEdgesBinding) readonly buffer Edges { uint edges[]; };

void main() {
  const vec2 corners[6] = {vec2(0, -1), vec2(1, -1), vec2(1, 1), vec2(0, -1), vec2(1, 1), vec2(0, 1)};
  vec2 corner = corners[gl_VertexIndex];
  vec4 a = draw.clip_from_world * vec4(control[edges[2u * gl_InstanceIndex]].xyz, 1.0);
  vec4 b = draw.clip_from_world * vec4(control[edges[2u * gl_InstanceIndex + 1u]].xyz, 1.0);
  vec2 along = (b.xy / b.w - a.xy / a.w) * draw.viewport;
  vec2 direction = dot(along, along) > 0.0 ? normalize(along) : vec2(1.0, 0.0);
  vec2 across = vec2(-direction.y, direction.x) * draw.width / draw.viewport;
  vec4 end = corner.x == 0.0 ? a : b;
  gl_Position = vec4(end.xy + corner.y * across * end.w, end.z, end.w);
}
