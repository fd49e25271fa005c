// How finely OpenSubdiv's patches are divided by tessellation, so that neighbours agree; after
// planish_osd_patches.glsl. Edges are counted from the one before corner 0: u = 0, v = 0, u = 1,
// v = 1, of triangles u = 0, v = 0, u + v = 1. A transition edge has two patches of the next level
// beyond it: `lo` is how many segments its first half has, `hi` its second half; `hi` is 0 of other
// edges.
//
// OSD_FRACTIONAL_EVEN_SPACING or OSD_FRACTIONAL_ODD_SPACING take fractional levels; without them
// spacing is equal. Vulkan leaves open where fractional spacing puts an edge's two short segments:
// transition edges expect them where Direct3D 11 has them, as hardware does and Mesa's llvmpipe.
#if defined OSD_FRACTIONAL_EVEN_SPACING
#define OSD_SPACING fractional_even_spacing
#elif defined OSD_FRACTIONAL_ODD_SPACING
#define OSD_SPACING fractional_odd_spacing
#else
#define OSD_SPACING equal_spacing
#endif

const float kOsdMostSegments = 64.0;  // that every device has

bvec4 OsdGetPatchTransitions(ivec3 param) {
  int mask = OsdGetPatchTransitionMask(param);
  ivec4 edges = OSD_PATCH_IS_TRIANGLE ? ivec4(4, 1, 2, 0) : ivec4(8, 1, 2, 4);
  return notEqual(mask & edges, ivec4(0));
}

// The tessellator's whole segments of an edge of that level.
float OsdWholeSegments(float level) {
#if defined OSD_FRACTIONAL_EVEN_SPACING
  return 2.0 * ceil(0.5 * max(level, 2.0));
#elif defined OSD_FRACTIONAL_ODD_SPACING
  return 2.0 * ceil(0.5 * (level + 1.0)) - 1.0;
#else
  return max(floor(level + 0.5), 1.0);
#endif
}

// From segments of edges, and of halves of transition edges, to the tessellator's levels.
void OsdComputeTessLevels(inout vec4 lo, inout vec4 hi, out vec4 outer, out vec2 inner) {
  vec4 both = lo + hi;
#if !defined OSD_FRACTIONAL_EVEN_SPACING && !defined OSD_FRACTIONAL_ODD_SPACING
  for (int i = 0; i < 4; ++i) {
    lo[i] = OsdWholeSegments(lo[i]);
    if (hi[i] > 0.0) hi[i] = OsdWholeSegments(hi[i]);
  }
  both = lo + hi;
#endif
  outer = both;
  // Halves have whole segments each; OsdGetTessParameterization puts them where they belong.
  for (int i = 0; i < 4; ++i)
    if (hi[i] > 0.0) outer[i] = OsdWholeSegments(lo[i]) + OsdWholeSegments(hi[i]);
#if defined OSD_FRACTIONAL_ODD_SPACING
  for (int i = 0; i < 4; ++i)
    if (hi[i] > 0.0) outer[i] += 1.0;  // two odd numbers: one segment is a point
  both = outer;
#endif
  inner = OSD_PATCH_IS_TRIANGLE ? vec2(max(max(both.x, both.y), both.z))
                                : 0.5 * vec2(both.y + both.w, both.x + both.z);
}

// A face of the mesh's first refinement gets `level` segments an edge, those of each further one
// half as many, of equal spacing.
void OsdGetTessLevelsUniform(ivec3 param, float level, out vec4 outer, out vec2 inner, out vec4 lo,
                             out vec4 hi) {
  float here = 2.0 * min(level, 0.5 * kOsdMostSegments) / float(1 << OsdGetPatchRefinementLevel(param));
  bvec4 transitions = OsdGetPatchTransitions(param);
  lo = mix(vec4(here), vec4(0.5 * here), transitions);
  hi = mix(vec4(0.0), vec4(0.5 * here), transitions);
  OsdComputeTessLevels(lo, hi, outer, inner);
}

// Segments of a line: `level` times the part of half the view's height that a sphere around it takes,
// so that neighbours agree, and lines towards the eye are divided, too. No more than half of what
// there is, as it may be half of an edge.
float OsdComputeTessLevel(mat4 clip_from_object, float level, vec3 a, vec3 b) {
  vec3 down = vec3(clip_from_object[0].y, clip_from_object[1].y, clip_from_object[2].y);
  precise vec3 across = a - b, centre = 0.5 * (a + b);
  precise float size = sqrt(across.x * across.x + across.y * across.y + across.z * across.z);
  precise float scale = sqrt(down.x * down.x + down.y * down.y + down.z * down.z);
  precise float depth = (clip_from_object[0].w * centre.x + clip_from_object[1].w * centre.y) +
                        (clip_from_object[2].w * centre.z + clip_from_object[3].w);
  precise float segments = level * size * scale / abs(depth);
  return clamp(segments, 1.0, 0.5 * kOsdMostSegments);
}

// The border's corners and the middles of its edges, from a patch's points.
vec3 OsdGetPatchCorner(vec3 p[OSD_PATCH_POINTS], int corner) {
#if OSD_PATCH_TYPE == OSD_PATCH_REGULAR
  return p[int[4](0, 3, 15, 12)[corner]];
#elif OSD_PATCH_TYPE == OSD_PATCH_GREGORY_BASIS || OSD_PATCH_TYPE == OSD_PATCH_GREGORY_TRIANGLE
  return p[5 * corner];
#elif OSD_PATCH_TYPE == OSD_PATCH_LOOP
  return p[int[3](0, 4, 14)[corner]];
#else
  return p[corner];
#endif
}
vec3 OsdGetPatchMiddle(vec3 p[OSD_PATCH_POINTS], int edge) {
#if OSD_PATCH_TYPE == OSD_PATCH_LOOP || OSD_PATCH_TYPE == OSD_PATCH_GREGORY_TRIANGLE
  return OsdEvalPatch(ivec3(0), vec2[3](vec2(0.0, 0.5), vec2(0.5, 0.0), vec2(0.5, 0.5))[edge], p)
      .position;
#elif OSD_PATCH_TYPE == OSD_PATCH_TRIANGLES
  return 0.5 * (p[edge == 2 ? 1 : 0] + p[edge == 1 ? 1 : 2]);
#else
  return OsdEvalPatch(ivec3(0),
                      vec2[4](vec2(0.0, 0.5), vec2(0.5, 0.0), vec2(1.0, 0.5), vec2(0.5, 1.0))[edge], p)
      .position;
#endif
}

// By how large edges are seen; `level` as OsdComputeTessLevel has it.
void OsdGetTessLevelsScreenSpace(ivec3 param, mat4 clip_from_object, float level,
                                 vec3 p[OSD_PATCH_POINTS], out vec4 outer, out vec2 inner,
                                 out vec4 lo, out vec4 hi) {
  bvec4 transitions = OsdGetPatchTransitions(param);
  lo = vec4(1.0);
  hi = vec4(0.0);
  int edges = OSD_PATCH_IS_TRIANGLE ? 3 : 4;
  for (int i = 0; i < edges; ++i) {
    // In the direction of growing u or v, on u + v = 1 of growing u's opposite.
    ivec2 ends = OSD_PATCH_IS_TRIANGLE ? ivec2[3](ivec2(0, 2), ivec2(0, 1), ivec2(2, 1))[min(i, 2)]
                                       : ivec2[4](ivec2(0, 3), ivec2(0, 1), ivec2(1, 2), ivec2(3, 2))[i];
    vec3 a = OsdGetPatchCorner(p, ends.x), b = OsdGetPatchCorner(p, ends.y);
    if (transitions[i]) {
      vec3 middle = OsdGetPatchMiddle(p, i);
      lo[i] = OsdComputeTessLevel(clip_from_object, level, a, middle);
      hi[i] = OsdComputeTessLevel(clip_from_object, level, b, middle);
    } else {
      lo[i] = OsdComputeTessLevel(clip_from_object, level, a, b);
    }
  }
  OsdComputeTessLevels(lo, hi, outer, inner);
}

// Where the tessellator puts point `i` of an edge of that level; between edges of the next lower and
// the next higher whole number of segments (Direct3D 11.3 functional specification, 10.10).
float OsdPlaceOnEdge(float i, float level) {
  float segments = OsdWholeSegments(level);
#if defined OSD_FRACTIONAL_EVEN_SPACING || defined OSD_FRACTIONAL_ODD_SPACING
#if defined OSD_FRACTIONAL_EVEN_SPACING
  float odd = 0.0, half_level = 0.5 * max(level, 2.0);
#else
  float odd = 1.0, half_level = 0.5 * (max(level, 1.0) + 1.0);
#endif
  float low = floor(half_level), part = half_level - low;
  if (part > 0.0) {
    bool flips = i > 0.5 * segments;
    float at = flips ? segments - i : i;
    if (2.0 * at == segments) return 0.5;
    // The point from which on there is one more: 2 n + 1 of the number without its highest bit.
    int number = int(low) - int(odd);
    float split = number < 1 ? 0.0 : float(2 * (number - (1 << findMSB(number))) + 1);
    float below = (at > split ? at - 1.0 : at) / (2.0 * low - odd);
    float place = mix(below, at / segments, part);
    return flips ? 1.0 - place : place;
  }
#endif
  return i / segments;
}

float OsdGetTessTransitionSplit(float t, float lo, float hi) {
  float first = OsdWholeSegments(lo), second = OsdWholeSegments(hi);
  // Where spacing is odd there is one more than that, and two become one point.
  float i = floor(t * (first + second) + 0.5);
  return i <= first ? 0.5 * OsdPlaceOnEdge(i, lo) : 0.5 + 0.5 * OsdPlaceOnEdge(i - first, hi);
}

// The patch's (u, v) of gl_TessCoord.
vec2 OsdGetTessParameterization(vec3 coord, vec4 lo, vec4 hi) {
  vec2 uv = coord.xy;
  if (coord.x == 0.0 && hi.x > 0.0) {
    uv.y = OsdGetTessTransitionSplit(uv.y, lo.x, hi.x);
  } else if (coord.y == 0.0 && hi.y > 0.0) {
    uv.x = OsdGetTessTransitionSplit(uv.x, lo.y, hi.y);
  } else if (OSD_PATCH_IS_TRIANGLE) {
    if (coord.z == 0.0 && hi.z > 0.0) {
      uv.x = OsdGetTessTransitionSplit(uv.x, lo.z, hi.z);
      uv.y = 1.0 - uv.x;
    }
  } else if (coord.x == 1.0 && hi.z > 0.0) {
    uv.y = OsdGetTessTransitionSplit(uv.y, lo.z, hi.z);
  } else if (coord.y == 1.0 && hi.w > 0.0) {
    uv.x = OsdGetTessTransitionSplit(uv.x, lo.w, hi.w);
  }
  return uv;
}
