// The tangent plane at a vertex, and points of it between two edges.
struct Frame {
  vec3 tangent1, tangent2, normal;
};

// Based on: Duff et al., "Building an orthonormal basis, revisited", 2017.
Frame frame_of(vec3 n) {
  float sign = n.z < 0.0 ? -1.0 : 1.0;
  float a = -1.0 / (sign + n.z);
  float b = n.x * n.y * a;
  return Frame(vec3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
               vec3(b, sign + n.y * n.y * a, -n.y), n);
}
vec2 project(Frame frame, vec3 v) { return vec2(dot(v, frame.tangent1), dot(v, frame.tangent2)); }
vec3 lift(Frame frame, vec2 p) { return p.x * frame.tangent1 + p.y * frame.tangent2; }

// A point as along_next * next + along_previous * previous.
struct Wedge {
  float along_next, along_previous;
  bool valid;  // the wedge opens counter-clockwise, by more than a sliver
};
const float kSliverSine = 1e-3;

// Zero of equal vectors on every device, as all differences of products here: one that is fused with a
// product leaves the other's rounding.
float turn(vec2 a, vec2 b) {
  precise float product = a.x * b.y - a.y * b.x;
  return product;
}

// How far a wedge is to be trusted: 0 where it is not valid, 1 from twice the sliver's angle on.
float wedge_share(vec2 next, vec2 previous) {
  float size = length(next) * length(previous);
  return size > 0.0 ? clamp(turn(next, previous) / (kSliverSine * size) - 1.0, 0.0, 1.0) : 0.0;
}

Wedge wedge_of(vec2 point, vec2 next, vec2 previous) {
  float determinant = turn(next, previous);
  if (!(determinant > kSliverSine * (length(next) * length(previous))))
    return Wedge(0.0, 0.0, false);
  return Wedge(turn(point, previous) / determinant, turn(next, point) / determinant, true);
}
