// Of compact positions, and where they are seen from.
layout(push_constant) uniform Camera {
  mat4 clip_from_world;
  vec4 box_center, box_half;
};
vec3 world(vec4 compact) { return box_center.xyz + compact.xyz * box_half.xyz; }
