#version 450
#extension GL_GOOGLE_include_directive : require
#include "camera.glsl"
layout(location = 0) in vec4 position;
layout(location = 1) in vec4 last_position;
layout(location = 2) in vec2 octahedral;
layout(location = 3) in vec4 tangent;
layout(location = 4) in vec2 uv;
layout(location = 0) out vec3 out_motion;
layout(location = 1) out vec3 out_normal;
layout(location = 2) out vec4 out_tangent;
layout(location = 3) out vec2 out_uv;
invariant gl_Position;

void main() {
  vec3 n = vec3(octahedral, 1.0 - abs(octahedral.x) - abs(octahedral.y));
  if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
  out_motion = world(position) - world(last_position);
  out_normal = normalize(n);
  out_tangent = tangent;
  out_uv = uv;
  gl_Position = clip_from_world * vec4(world(position), 1.0);
}
