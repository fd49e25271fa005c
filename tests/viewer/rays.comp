#version 460
// The first triangle that each ray meets: how far, and which.
#extension GL_EXT_ray_query : require

layout(local_size_x = 64) in;
layout(set = 0, binding = 0) uniform accelerationStructureEXT scene;
layout(std430, set = 0, binding = 1) readonly buffer Rays { vec4 rays[]; };  // origin, direction
layout(std430, set = 0, binding = 2) writeonly buffer Hits { float hits[]; };  // below 0: none

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (2u * i >= rays.length()) return;
  rayQueryEXT query;
  rayQueryInitializeEXT(query, scene, gl_RayFlagsOpaqueEXT, 0xffu, rays[2u * i].xyz, 0.0,
                        rays[2u * i + 1u].xyz, 1e6);
  while (rayQueryProceedEXT(query)) {
  }
  bool meets = rayQueryGetIntersectionTypeEXT(query, true) ==
               gl_RayQueryCommittedIntersectionTriangleEXT;
  hits[i] = meets ? rayQueryGetIntersectionTEXT(query, true) : -1.0;
}
