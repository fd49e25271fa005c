#version 450
#extension GL_GOOGLE_include_directive : require
#include "view.glsl"
#include "planish_osd_patches.glsl"
#include "planish_osd_tessellation.glsl"

layout(std430, set = 0, binding = 0) readonly buffer Params { int params[]; };
layout(vertices = OSD_PATCH_POINTS) out;
layout(location = 0) in vec3 control_points[];
layout(location = 0) out vec3 points[];
layout(location = 1) patch out vec4 lo;
layout(location = 2) patch out vec4 hi;

void main() {
  int at = 3 * (first_patch + gl_PrimitiveID);
  ivec3 param = ivec3(params[at], params[at + 1], params[at + 2]);
  vec3 cv[OSD_PATCH_CONTROL_POINTS];
  for (int i = 0; i < OSD_PATCH_CONTROL_POINTS; ++i) cv[i] = control_points[i];
  points[gl_InvocationID] = OsdComputePatchPoint(param, gl_InvocationID, cv);
  barrier();
  if (gl_InvocationID != 0) return;
  vec3 p[OSD_PATCH_POINTS];
  for (int i = 0; i < OSD_PATCH_POINTS; ++i) p[i] = points[i];
  vec4 outer, from, to;
  vec2 inner;
  if (by_screen)
    OsdGetTessLevelsScreenSpace(param, clip_from_object, level, p, outer, inner, from, to);
  else
    OsdGetTessLevelsUniform(param, level, outer, inner, from, to);
  lo = from;
  hi = to;
  for (int i = 0; i < 4; ++i) gl_TessLevelOuter[i] = outer[i];
  for (int i = 0; i < 2; ++i) gl_TessLevelInner[i] = inner[i];
}
