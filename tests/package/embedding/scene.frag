#version 450
// Tiles of a texture with round bumps, by their normals in the surface's tangent space.
layout(location = 0) in vec3 motion;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 tangent;
layout(location = 3) in vec2 uv;
layout(location = 0) out vec4 colour;
layout(location = 1) out vec4 out_motion;
layout(location = 2) out vec4 out_texture;

void main() {
  vec2 tile = fract(uv * vec2(24.0, 12.0)) * 2.0 - 1.0;
  vec2 slope = dot(tile, tile) < 0.8 ? tile : vec2(0.0);
  vec3 n = normalize(normal), t = normalize(tangent.xyz), b = cross(n, t) * tangent.w;
  // The image's rows run against v.
  vec3 bumped = normalize(n + 0.7 * (slope.x * t - slope.y * b));
  float light = 0.2 + 0.8 * max(dot(bumped, normalize(vec3(0.4, 0.5, -0.8))), 0.0);
  colour = vec4(light * mix(vec3(0.85, 0.6, 0.4), vec3(0.5, 0.7, 0.8), uv.x), 1.0);
  out_motion = vec4(motion, tangent.w);
  out_texture = vec4(uv, t.xy);
}
