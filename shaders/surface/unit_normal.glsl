// The normal and the tangent of a surface point from its derivatives.
#ifndef PLANISH_UNIT_NORMAL
#define PLANISH_UNIT_NORMAL

// |du x dv| below this part of |du||dv| has no direction that rounding has not made.
const float kParallel = 1e-6;

// Along du x dv; zero where it is undefined.
vec3 unit_normal(vec3 du, vec3 dv) {
  // Scaled to unit size first, so that the products neither vanish nor overflow.
  float u = max(max(abs(du.x), abs(du.y)), abs(du.z));
  float v = max(max(abs(dv.x), abs(dv.y)), abs(dv.z));
  vec3 normal = vec3(0.0);
  if (u > 0.0 && v > 0.0) {
    precise vec3 a = du / u;
    precise vec3 b = dv / v;
    precise vec3 c = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    float size = sqrt(dot(c, c));
    if (size >= kParallel * sqrt(dot(a, a)) * sqrt(dot(b, b))) normal = c / size;
  }
  return normal;
}

// The part of a direction that is square to the normal; any that is where none is left.
vec3 unit_tangent(vec3 along, vec3 normal) {
  float size = max(max(abs(along.x), abs(along.y)), abs(along.z));
  vec3 tangent = size > 0.0 ? along / size : vec3(0.0);
  tangent -= normal * dot(normal, tangent);
  float square = dot(tangent, tangent);
  if (square > kParallel) return tangent / sqrt(square);
  vec3 sizes = abs(normal);
  vec3 any = sizes.x <= sizes.y && sizes.x <= sizes.z ? vec3(1.0, 0.0, 0.0)
             : sizes.y <= sizes.z                     ? vec3(0.0, 1.0, 0.0)
                                                      : vec3(0.0, 0.0, 1.0);
  return normalize(any - normal * dot(normal, any));
}
#endif
