// OpenSubdiv's patches as shader code, in any stage: their limit points with derivatives, from the
// control points that a Far::PatchTable names. Before it is included, OSD_PATCH_TYPE says which, by
// the number of Far::PatchDescriptor::Type:
//   3 QUADS, 4 TRIANGLES, 5 LOOP, 6 REGULAR, 9 GREGORY_BASIS, 10 GREGORY_TRIANGLE
// Functions have OpenSubdiv's names where they do what OpenSubdiv's do. Names that begin with Osd,
// OSD_ and kOsd are taken; OpenSubdiv's own patch basis source (GetPatchBasisShaderSource) may stand
// beside it, its drawing source, whose place it takes, may not.
//
// A patch's (u, v) run over [0, 1], those of triangles with u + v <= 1. Derivatives are by its
// face's, as Osd::CpuEvaluator's are.
//
// Where patches of one level and type share an edge, positions are the same bits for both, if the
// tessellation has (1 - t) on one side where it has t on the other, which Vulkan promises. So sums
// run in an order that does not tell the sides apart, and are `precise`.

#define OSD_PATCH_QUADS 3
#define OSD_PATCH_TRIANGLES 4
#define OSD_PATCH_LOOP 5
#define OSD_PATCH_REGULAR 6
#define OSD_PATCH_GREGORY_BASIS 9
#define OSD_PATCH_GREGORY_TRIANGLE 10

// OSD_PATCH_CONTROL_POINTS: of the index buffer. OSD_PATCH_POINTS: what a patch is evaluated from.
#if OSD_PATCH_TYPE == OSD_PATCH_QUADS
#define OSD_PATCH_CONTROL_POINTS 4
#define OSD_PATCH_POINTS 4
#elif OSD_PATCH_TYPE == OSD_PATCH_TRIANGLES
#define OSD_PATCH_CONTROL_POINTS 3
#define OSD_PATCH_POINTS 3
#elif OSD_PATCH_TYPE == OSD_PATCH_LOOP
#define OSD_PATCH_CONTROL_POINTS 12
#define OSD_PATCH_POINTS 15
#elif OSD_PATCH_TYPE == OSD_PATCH_REGULAR
#define OSD_PATCH_CONTROL_POINTS 16
#define OSD_PATCH_POINTS 16
#elif OSD_PATCH_TYPE == OSD_PATCH_GREGORY_BASIS
#define OSD_PATCH_CONTROL_POINTS 20
#define OSD_PATCH_POINTS 20
#elif OSD_PATCH_TYPE == OSD_PATCH_GREGORY_TRIANGLE
#define OSD_PATCH_CONTROL_POINTS 18
#define OSD_PATCH_POINTS 18
#else
#error OSD_PATCH_TYPE is no type of patches that are drawn
#endif
#if OSD_PATCH_TYPE == OSD_PATCH_TRIANGLES || OSD_PATCH_TYPE == OSD_PATCH_LOOP || \
    OSD_PATCH_TYPE == OSD_PATCH_GREGORY_TRIANGLE
#define OSD_PATCH_IS_TRIANGLE true
#define OSD_PATCH_DOMAIN triangles
#else
#define OSD_PATCH_IS_TRIANGLE false
#define OSD_PATCH_DOMAIN quads
#endif

// A patch's parameters: words 3 i, 3 i + 1 and 3 i + 2 of the patch parameter buffer, as
// Far::PatchParam packs them. Single-crease patches are not told from others.
int OsdGetPatchFaceId(ivec3 param) { return param.x & 0xfffffff; }
int OsdGetPatchTransitionMask(ivec3 param) { return (param.x >> 28) & 0xf; }
int OsdGetPatchRefinementLevel(ivec3 param) { return param.y & 0xf; }
int OsdGetPatchFaceLevel(ivec3 param) { return 1 << ((param.y & 0xf) - ((param.y >> 4) & 1)); }
int OsdGetPatchBoundaryMask(ivec3 param) { return (param.y >> 7) & 0x1f; }
ivec2 OsdGetPatchFaceUV(ivec3 param) {
  return ivec2((param.y >> 22) & 0x3ff, (param.y >> 12) & 0x3ff);
}
bool OsdGetPatchIsTriangleRotated(ivec3 param) {
  ivec2 uv = OsdGetPatchFaceUV(param);
  return uv.x + uv.y >= OsdGetPatchFaceLevel(param);
}

// The place on the (Ptex) face: its u and v, the face's level and number, both with a half on top.
vec4 OsdInterpolatePatchCoord(vec2 uv, ivec3 param) {
  float level = float(OsdGetPatchFaceLevel(param));
  vec2 at = (uv + vec2(OsdGetPatchFaceUV(param))) / level;
  if (OSD_PATCH_IS_TRIANGLE && OsdGetPatchIsTriangleRotated(param)) at = 1.0 - at;
  return vec4(at, level + 0.5, float(OsdGetPatchFaceId(param)) + 0.5);
}

struct OsdPatchPoint {
  vec3 position;
  vec3 du, dv;  // by the face's u and v
  vec3 normal;  // along du x dv; zero where even the patch's neighbourhood has none
};

// `other` is along the normal, where du and dv are not.
OsdPatchPoint OsdMakePatchPoint(ivec3 param, vec3 position, vec3 du, vec3 dv, vec3 other) {
  vec3 normal = cross(du, dv);
  if (dot(normal, normal) <= 1e-10 * dot(du, du) * dot(dv, dv)) normal = other;
  float size = length(normal);
  normal = size > 0.0 ? normal / size : vec3(0.0);
  float scale = float(1 << OsdGetPatchRefinementLevel(param));
  if (OSD_PATCH_IS_TRIANGLE && OsdGetPatchIsTriangleRotated(param)) scale = -scale;
  return OsdPatchPoint(position, scale * du, scale * dv, normal);
}

#if OSD_PATCH_TYPE == OSD_PATCH_QUADS

OsdPatchPoint OsdEvalPatch(ivec3 param, vec2 uv, vec3 p[4]) {
  vec2 st = 1.0 - uv;
  precise vec3 low = st.x * p[0] + uv.x * p[1], high = st.x * p[3] + uv.x * p[2];
  precise vec3 left = st.y * p[0] + uv.y * p[3], right = st.y * p[1] + uv.y * p[2];
  bool is_side = uv.x == 0.0 || uv.x == 1.0;
  precise vec3 position = is_side ? st.x * left + uv.x * right : st.y * low + uv.y * high;
  return OsdMakePatchPoint(param, position, right - left, high - low,
                           cross(p[2] - p[0], p[3] - p[1]));
}

#elif OSD_PATCH_TYPE == OSD_PATCH_TRIANGLES

OsdPatchPoint OsdEvalPatch(ivec3 param, vec2 uv, vec3 p[3]) {
  float w = (1.0 - uv.x) - uv.y;
  precise vec3 position = w * p[0] + uv.x * p[1] + uv.y * p[2];
  return OsdMakePatchPoint(param, position, p[1] - p[0], p[2] - p[0], vec3(0.0));
}

#elif OSD_PATCH_TYPE == OSD_PATCH_REGULAR || OSD_PATCH_TYPE == OSD_PATCH_GREGORY_BASIS

// Two steps of de Casteljau's: the ends of the line that the curve's point divides.
void OsdHalveBezier(float t, vec3 a, vec3 b, vec3 c, vec3 d, out vec3 low, out vec3 high) {
  precise float s = 1.0 - t;
  precise float ss = s * s, st = 2.0 * (s * t), tt = t * t;
  precise vec3 first = (ss * a + tt * c) + st * b;
  precise vec3 second = (ss * b + tt * d) + st * c;
  low = first;
  high = second;
}

// Of a bicubic Bezier patch, rows of u.
OsdPatchPoint OsdEvalPatchBezier(ivec3 param, vec2 uv, vec3 p[16]) {
  vec3 low[4], high[4];
  OsdHalveBezier(uv.x, p[0], p[1], p[2], p[3], low[0], high[0]);
  OsdHalveBezier(uv.x, p[4], p[5], p[6], p[7], low[1], high[1]);
  OsdHalveBezier(uv.x, p[8], p[9], p[10], p[11], low[2], high[2]);
  OsdHalveBezier(uv.x, p[12], p[13], p[14], p[15], low[3], high[3]);
  vec3 a, b, c, d;  // at (0, 0), (1, 0), (0, 1), (1, 1) of the last step's quad
  OsdHalveBezier(uv.y, low[0], low[1], low[2], low[3], a, c);
  OsdHalveBezier(uv.y, high[0], high[1], high[2], high[3], b, d);
  precise vec2 st = 1.0 - uv;
  precise vec3 left = st.y * a + uv.y * c, right = st.y * b + uv.y * d;
  precise vec3 position = st.x * left + uv.x * right;
  vec3 dv = (st.x * c + uv.x * d) - (st.x * a + uv.x * b);
  return OsdMakePatchPoint(param, position, 3.0 * (right - left), 3.0 * dv, cross(d - a, c - b));
}

#if OSD_PATCH_TYPE == OSD_PATCH_REGULAR

OsdPatchPoint OsdEvalPatch(ivec3 param, vec2 uv, vec3 p[16]) {
  return OsdEvalPatchBezier(param, uv, p);
}

// Bezier point k of a uniform cubic B-spline's segment; at a sharp end the curve ends in b or c.
vec3 OsdBezierOfBSpline(int k, bool sharp_low, bool sharp_high, vec3 a, vec3 b, vec3 c, vec3 d) {
  if (k == 0 && sharp_low) return b;
  if (k == 3 && sharp_high) return c;
  precise vec3 point = k == 0   ? (a + c) * (1.0 / 6.0) + b * (4.0 / 6.0)
                       : k == 1 ? b * (4.0 / 6.0) + c * (2.0 / 6.0)
                       : k == 2 ? b * (2.0 / 6.0) + c * (4.0 / 6.0)
                                : (b + d) * (1.0 / 6.0) + c * (4.0 / 6.0);
  return point;
}

// Point `id` of OSD_PATCH_POINTS from the patch's control points: a bicubic Bezier patch. Borders
// first across, then along, corners all around.
vec3 OsdComputePatchPoint(ivec3 param, int id, vec3 cv[16]) {
  int mask = OsdGetPatchBoundaryMask(param);
  bvec4 sharp = notEqual(mask & ivec4(8, 2, 1, 4), ivec4(0));  // u = 0, u = 1, v = 0, v = 1
  int i = id & 3, j = id >> 2;
  bool u_ends = i == 0 || i == 3, v_ends = j == 0 || j == 3;
  bool u_sharp = (i == 0 && sharp.x) || (i == 3 && sharp.y);
  bool v_sharp = (j == 0 && sharp.z) || (j == 3 && sharp.w);
  if (u_ends && v_ends && !u_sharp && !v_sharp) {
    int at = (j == 0 ? 4 : 8) + (i == 0 ? 1 : 2);
    precise vec3 corners = (cv[at - 5] + cv[at + 5]) + (cv[at - 3] + cv[at + 3]);
    precise vec3 edges = (cv[at - 4] + cv[at + 4]) + (cv[at - 1] + cv[at + 1]);
    precise vec3 point = (corners + 4.0 * edges + 16.0 * cv[at]) * (1.0 / 36.0);
    return point;
  }
  // The first direction is v on a border of v, or where a corner is sharp in v.
  bool v_first = v_ends && (!u_ends || v_sharp) && !u_sharp;
  int first = v_first ? 4 : 1, second = v_first ? 1 : 4;
  bvec4 sharp_first = v_first ? sharp.zwxy : sharp;
  int k = v_first ? j : i, l = v_first ? i : j;
  vec3 lines[4];
  for (int line = 0; line < 4; ++line) {
    int at = second * line;
    lines[line] = OsdBezierOfBSpline(k, sharp_first.x, sharp_first.y, cv[at], cv[at + first],
                                     cv[at + 2 * first], cv[at + 3 * first]);
  }
  return OsdBezierOfBSpline(l, sharp_first.z, sharp_first.w, lines[0], lines[1], lines[2],
                            lines[3]);
}

#else

// Between two inner points of a corner, by how near the sides are.
vec3 OsdInnerPoint(float a, float b, vec3 at_a, vec3 at_b) {
  float sum = a + b;
  float part = sum > 0.0 ? a / sum : 0.0;
  return part * at_a + (1.0 - part) * at_b;
}

// C. Loop, S. Schaefer, T. Ni, I. Castano, "Approximating Subdivision Surfaces with Gregory Patches
// for Hardware Tessellation", 2009. Derivatives are those of the Bezier patch at (u, v), as
// OpenSubdiv takes them.
OsdPatchPoint OsdEvalPatch(ivec3 param, vec2 uv, vec3 p[20]) {
  vec2 st = 1.0 - uv;
  vec3 inner[4];
  inner[0] = OsdInnerPoint(uv.x, uv.y, p[3], p[4]);
  inner[1] = OsdInnerPoint(uv.y, st.x, p[8], p[9]);
  inner[2] = OsdInnerPoint(st.y, uv.x, p[18], p[19]);
  inner[3] = OsdInnerPoint(st.x, st.y, p[13], p[14]);
  return OsdEvalPatchBezier(
      param, uv,
      vec3[16](p[0], p[1], p[7], p[5], p[2], inner[0], inner[1], p[6], p[16], inner[2], inner[3],
               p[12], p[15], p[17], p[11], p[10]));
}

#endif

#else

// Of a Bezier triangle of degree 3 with corners a (w = 1), d (u = 1) and h (v = 1).
vec3 OsdEvalCubicTriangle(vec3 uvw, vec3 a, vec3 ab, vec3 ba, vec3 d, vec3 dh, vec3 hd, vec3 h,
                          vec3 ha, vec3 ah, vec3 middle) {
  precise float u = uvw.x, v = uvw.y, w = uvw.z;
  precise float uu = u * u, vv = v * v, ww = w * w;
  precise vec3 corners = (ww * w) * a + (uu * u) * d + (vv * v) * h;
  precise vec3 low = (ww * u) * ab + (uu * w) * ba, right = (uu * v) * dh + (vv * u) * hd,
               left = (vv * w) * ha + (ww * v) * ah;
  precise vec3 sum = corners + 3.0 * ((low + right) + left) + (6.0 * (u * v * w)) * middle;
  return sum;
}

// Of a quartic Bezier triangle, rows of u: 5, 4, 3, 2 and 1 points.
OsdPatchPoint OsdEvalPatchBezierTriangle(ivec3 param, vec2 uv, vec3 p[15]) {
  precise vec3 uvw = vec3(uv, (1.0 - uv.x) - uv.y);
  vec3 a = OsdEvalCubicTriangle(uvw, p[0], p[1], p[2], p[3], p[7], p[10], p[12], p[9], p[5], p[6]);
  vec3 b = OsdEvalCubicTriangle(uvw, p[1], p[2], p[3], p[4], p[8], p[11], p[13], p[10], p[6], p[7]);
  vec3 c = OsdEvalCubicTriangle(uvw, p[5], p[6], p[7], p[8], p[11], p[13], p[14], p[12], p[9],
                                p[10]);
  precise vec3 position = uvw.x * b + uvw.y * c + uvw.z * a;
  // Where they lie on a line: the inner triangle.
  return OsdMakePatchPoint(param, position, 4.0 * (b - a), 4.0 * (c - a),
                           cross(p[7] - p[6], p[10] - p[6]));
}

#if OSD_PATCH_TYPE == OSD_PATCH_GREGORY_TRIANGLE

vec3 OsdInnerPoint(float a, float b, vec3 at_a, vec3 at_b) {
  float sum = a + b;
  return sum > 0.0 ? (a / sum) * at_a + (b / sum) * at_b : at_a;
}

OsdPatchPoint OsdEvalPatch(ivec3 param, vec2 uv, vec3 p[18]) {
  float w = (1.0 - uv.x) - uv.y;
  vec3 first = OsdInnerPoint(uv.x, uv.y, p[3], p[4]), second = OsdInnerPoint(uv.y, w, p[8], p[9]);
  vec3 third = OsdInnerPoint(w, uv.x, p[13], p[14]);
  return OsdEvalPatchBezierTriangle(
      param, uv,
      vec3[15](p[0], p[1], p[15], p[7], p[5], p[2], first, second, p[6], p[17], third, p[16],
               p[11], p[12], p[10]));
}

#else

OsdPatchPoint OsdEvalPatch(ivec3 param, vec2 uv, vec3 p[15]) {
  return OsdEvalPatchBezierTriangle(param, uv, p);
}

// Whatever their order.
vec3 OsdSumOfThree(vec3 a, vec3 b, vec3 c) {
  vec3 low = min(min(a, b), c), high = max(max(a, b), c);
  precise vec3 sum = (low + high) + max(min(a, b), min(max(a, b), c));
  return sum;
}

// The quartic box spline's points around corners 4, 5 and 8, one turn after another.
const int kOsdCorner[3] = int[3](4, 5, 8), kOsdBefore[3] = int[3](0, 6, 10),
          kOsdAcross[3] = int[3](1, 9, 7), kOsdBehind[3] = int[3](2, 11, 3);
// What a Bezier point is, and of which corner or edge: 0 a corner, 1 to 3 along its edge, 4 inside.
const int kOsdKind[15] = int[15](0, 1, 2, 3, 0, 3, 4, 4, 1, 2, 4, 2, 1, 3, 0);
const int kOsdTurn[15] = int[15](0, 0, 0, 0, 1, 2, 0, 1, 1, 2, 2, 1, 2, 1, 2);

// Point `id` of OSD_PATCH_POINTS from the patch's control points: a quartic Bezier triangle.
vec3 OsdComputePatchPoint(ivec3 param, int id, vec3 cv[12]) {
  int mask = OsdGetPatchBoundaryMask(param);
  int kind_of_mask = mask >> 3, edges = mask & 7, corners = 0;
  if (kind_of_mask == 1) {
    corners = edges;
    edges = 0;
  } else if (kind_of_mask == 2) {
    corners = ((edges & 1) << 2) | (edges >> 1);  // opposite to the edge
  }
  bool sharp[3] = bool[3]((edges & 1) != 0, (edges & 2) != 0, (edges & 4) != 0);
  bool tip[3] = bool[3]((corners & 1) != 0, (corners & 2) != 0, (corners & 4) != 0);
  // Beyond a boundary points go on as they do inside.
  vec3 all[12] = cv;
  for (int r = 0; r < 3; ++r) {
    int next = (r + 1) % 3, last = (r + 2) % 3;
    vec3 v = cv[kOsdCorner[r]], w = cv[kOsdCorner[next]], x = cv[kOsdCorner[last]];
    if (sharp[r]) all[kOsdAcross[r]] = v + w - x;
  }
  int r = kOsdTurn[id], next = (r + 1) % 3, last = (r + 2) % 3, kind = kOsdKind[id];
  vec3 v = cv[kOsdCorner[r]], w = cv[kOsdCorner[next]], x = cv[kOsdCorner[last]];
  vec3 across = all[kOsdAcross[r]], before = all[kOsdBefore[r]], left = all[kOsdAcross[last]],
       right = all[kOsdAcross[next]], behind = all[kOsdBehind[r]], around = all[kOsdBehind[last]];
  precise vec3 point;
  if (kind == 0) {
    if (sharp[r] && sharp[last]) return v;
    vec3 a = tip[r] ? across : sharp[r] ? w : x;
    vec3 b = tip[r] ? left : sharp[r] ? around : before;
    if (tip[r] || sharp[r] || sharp[last]) {
      point = (a + b) * (1.0 / 6.0) + v * (4.0 / 6.0);
    } else {
      point = 0.5 * v + (1.0 / 12.0) * OsdSumOfThree(before + x, across + left, w + around);
    }
  } else if (kind == 2) {
    point = sharp[r] ? 0.5 * (v + w) : (v + w) * (1.0 / 3.0) + (x + across) * (1.0 / 6.0);
  } else if (kind == 4) {
    point = ((left + across) + 10.0 * v + 6.0 * (w + x)) * (1.0 / 24.0);
  } else {
    // From the nearer end.
    bool ahead = kind == 1;
    vec3 near = ahead ? v : w, far = ahead ? w : v;
    vec3 beyond = ahead ? around : all[kOsdBefore[next]];
    vec3 one = ahead ? before : behind, other = ahead ? left : right;
    bool is_tip = ahead ? tip[r] : tip[next], ends = ahead ? sharp[last] : sharp[next];
    if (sharp[r]) {
      point = ends ? 0.75 * near + 0.25 * far : (beyond + 16.0 * near + 7.0 * far) * (1.0 / 24.0);
    } else {
      if (is_tip) one = near + across - far;
      point = ((one + other) + 12.0 * near + 4.0 * far + 3.0 * (x + across)) * (1.0 / 24.0);
    }
  }
  return point;
}

#endif

#endif

#if OSD_PATCH_CONTROL_POINTS == OSD_PATCH_POINTS && OSD_PATCH_TYPE != OSD_PATCH_REGULAR
vec3 OsdComputePatchPoint(ivec3 param, int id, vec3 cv[OSD_PATCH_POINTS]) { return cv[id]; }
#endif
