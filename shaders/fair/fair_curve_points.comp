// The curve points at corners, and at darts, where they stand between the corners beside them.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ_STORED(0, FairCurvePoint, curve_points);
READ(1, vec4, given)
READ(2, vec4, points)
UPDATE(3, vec4, result);

void main() {
  FOR_ELEMENTS(s) {
    FairCurvePoint place = curve_points[s];
    uint target = parameters.place + s;
    if (place.kind == kCorner && parameters.darts_only == 0u)
      result[target] = vec4((points_at(place.other).xyz - given_at(place.vertex).xyz) / 4.0, 0.0);
    else if (place.kind == kDart)
      result[target] =
          vec4((result[place.after].xyz + result[place.before].xyz) / 2.0, 0.0);
  }
}
