// What the kernels of the cure share; fair/fold_cure.cpp.

vec3 unit_or_zero(vec3 v) {
  float size = safe_length(v);
  return size > 0.0 ? v / size : vec3(0.0);
}

// Between a normal of any length and a unit vector; -1 where the normal is zero.
float cosine_of(vec3 normal, vec3 reference) {
  float size = safe_length(normal);
  return size > 0.0 ? dot(normal / size, reference) : -1.0;
}
