// Positions, normals and tangents in the formats of a host's vertices; the including kernel defines
// POSITIONS and ATTRIBUTES, arrays of uint where they go, and declares kPositionFormat,
// kNormalFormat and kTangentFormat. Rounding is written out: what packHalf2x16 and its like do with
// halves of a unit is the driver's.

#define WRITE_FLOATS(to, place, v)        \
  to[place] = floatBitsToUint((v).x);      \
  to[place + 1u] = floatBitsToUint((v).y); \
  to[place + 2u] = floatBitsToUint((v).z);

// The nearest whole number of units, of `largest` to one, as a word.
uint whole_units(float x, float largest) {
  return uint(int(floor(clamp(x, -1.0, 1.0) * largest + 0.5)));
}
uint pair_of(uint low, uint high) { return (low & 0xffffu) | (high << 16u); }
uint snorm_pair(float low, float high) {
  return pair_of(whole_units(low, 32767.0), whole_units(high, 32767.0));
}

// To 11 binary digits, to even where two are as near, so that the conversion is exact.
float half_digits(float x) {
  uint bits = floatBitsToUint(x);
  return uintBitsToFloat((bits + 0xfffu + ((bits >> 13u) & 1u)) & ~0x1fffu);
}

void write_position(uint place, vec3 position) {
  if (kPositionFormat == kFormatFloat3) {
    WRITE_FLOATS(POSITIONS, place, position)
    return;
  }
  precise vec3 own = position - vec3(parameters.center_x, parameters.center_y, parameters.center_z);
  own *= vec3(parameters.scale_x, parameters.scale_y, parameters.scale_z);
  if (kPositionFormat == kFormatHalf4) {
    POSITIONS[place] = packHalf2x16(vec2(half_digits(own.x), half_digits(own.y)));
    POSITIONS[place + 1u] = packHalf2x16(vec2(half_digits(own.z), 1.0));
  } else {
    POSITIONS[place] = snorm_pair(own.x, own.y);
    POSITIONS[place + 1u] = snorm_pair(own.z, 1.0);
  }
}

// Cigolle et al., A Survey of Efficient Representations for Independent Unit Vectors, JCGT 2014:
// onto the octahedron, whose lower half is folded outwards. Zero where there is no normal.
vec2 octahedral(vec3 n) {
  float size = abs(n.x) + abs(n.y) + abs(n.z);
  if (!(size > 0.0)) return vec2(0.0);
  vec2 p = n.xy / size;
  if (n.z >= 0.0) return p;
  return vec2((1.0 - abs(p.y)) * (p.x >= 0.0 ? 1.0 : -1.0),
              (1.0 - abs(p.x)) * (p.y >= 0.0 ? 1.0 : -1.0));
}

uint ten_bits(vec3 n) {
  return (whole_units(n.x, 511.0) & 0x3ffu) | (whole_units(n.y, 511.0) & 0x3ffu) << 10u |
         (whole_units(n.z, 511.0) & 0x3ffu) << 20u;
}

void write_normal(uint place, vec3 n) {
  if (kNormalFormat == kFormatFloat3) {
    WRITE_FLOATS(ATTRIBUTES, place, n)
  } else if (kNormalFormat == kFormatOctahedral16) {
    vec2 p = octahedral(n);
    ATTRIBUTES[place] = snorm_pair(p.x, p.y);
  } else {
    ATTRIBUTES[place] = ten_bits(n);
  }
}

// Two bits with a sign say on which side of it v grows.
void write_tangent(uint place, vec3 tangent, float side) {
  if (kTangentFormat == kFormatFloat4) {
    WRITE_FLOATS(ATTRIBUTES, place, tangent)
    ATTRIBUTES[place + 3u] = floatBitsToUint(side);
  } else {
    ATTRIBUTES[place] = ten_bits(tangent) | (side < 0.0 ? 3u : 1u) << 30u;
  }
}
