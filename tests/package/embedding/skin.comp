#version 450
// The given points of a frame: rest points between two bones.
layout(local_size_x = 64) in;
layout(push_constant) uniform Bones {
  vec4 rows[6];  // of two 3 x 4 matrices
  uint count;
};
layout(std430, set = 0, binding = 0) readonly buffer Rest { float rest[]; };
layout(std430, set = 0, binding = 1) writeonly buffer Given { float given[]; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  vec4 p = vec4(rest[3u * i], rest[3u * i + 1u], rest[3u * i + 2u], 1.0);
  float weight = clamp(0.5 + 0.25 * p.x, 0.0, 1.0);
  for (uint k = 0u; k < 3u; ++k) given[3u * i + k] = dot(mix(rows[k], rows[3u + k], weight), p);
}
