#version 450
#extension GL_GOOGLE_include_directive : require
#include "view.glsl"
#include "planish_osd_patches.glsl"
#include "planish_osd_tessellation.glsl"

layout(OSD_PATCH_DOMAIN, OSD_SPACING, cw) in;
layout(std430, set = 0, binding = 0) readonly buffer Params { int params[]; };
layout(location = 0) in vec3 points[];
layout(location = 1) patch in vec4 lo;
layout(location = 2) patch in vec4 hi;
layout(xfb_buffer = 0, xfb_stride = 60) out;
layout(location = 0, xfb_offset = 0) out vec3 place;  // the patch, u, v
layout(location = 1, xfb_offset = 12) out vec3 position;
layout(location = 2, xfb_offset = 24) out vec3 du;
layout(location = 3, xfb_offset = 36) out vec3 dv;
layout(location = 4, xfb_offset = 48) out vec3 normal;

void main() {
  int at = 3 * (first_patch + gl_PrimitiveID);
  ivec3 param = ivec3(params[at], params[at + 1], params[at + 2]);
  vec2 uv = OsdGetTessParameterization(gl_TessCoord, lo, hi);
  vec3 p[OSD_PATCH_POINTS];
  for (int i = 0; i < OSD_PATCH_POINTS; ++i) p[i] = points[i];
  OsdPatchPoint point = OsdEvalPatch(param, uv, p);
  place = vec3(float(first_patch + gl_PrimitiveID), uv);
  position = point.position;
  du = point.du;
  dv = point.dv;
  normal = point.normal;
  gl_Position = clip_from_object * vec4(point.position, 1.0);
}
