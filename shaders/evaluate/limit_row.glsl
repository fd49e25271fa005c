// What a row of the output is made of; the including kernel declares target[].

#include "surface/unit_normal.glsl"

void write_vector(uint place, vec3 v) {
  target[place] = v.x;
  target[place + 1u] = v.y;
  target[place + 2u] = v.z;
}
