#version 450
// Instances of a surface at one level, straight from what a Tessellation wrote: what is the same for
// all of them is a stream of vertices, what is an instance's own is found by its record.
#extension GL_GOOGLE_include_directive : require
#include "draw.glsl"

layout(location = 0) in vec2 uv;
layout(location = 1) in uvec2 drawn;  // vulkan::DrawnInstance
layout(std430, set = 0, binding = 0) readonly buffer Vertices { float vertices[]; };
layout(std430, set = 0, binding = 1) readonly buffer Before { mat4 clip_before; };
layout(location = 0) out vec3 out_position;
layout(location = 1) out vec3 out_normal;
layout(location = 2) out float out_error;
layout(location = 3) out vec2 out_uv;
layout(location = 4) out vec4 out_now;
layout(location = 5) out vec4 out_before;

vec3 at(uint i) { return vec3(vertices[i], vertices[i + 1u], vertices[i + 2u]); }

void main() {
  uint vertex = (drawn.y + uint(gl_VertexIndex)) * kCrowdFloats;
  out_position = at(vertex);
  out_normal = at(vertex + kNormalFloat);
  out_error = 0.0;  // none is measured
  out_uv = uv;
  gl_Position = out_now = draw.clip_from_world * vec4(out_position, 1.0);
  out_before = clip_before * vec4(at(vertex + kBeforeFloat), 1.0);
}
