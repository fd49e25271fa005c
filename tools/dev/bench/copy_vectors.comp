// Copies vectors of four words, as fast as a device's memory lets a kernel.
#version 450

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) restrict readonly buffer Source { uvec4 source[]; };
layout(std430, set = 0, binding = 1) restrict writeonly buffer Target { uvec4 target[]; };
layout(push_constant) uniform Parameters { uint count; };

void main() {
  uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
  for (uint i = gl_GlobalInvocationID.x; i < count; i += stride) target[i] = source[i];
}
