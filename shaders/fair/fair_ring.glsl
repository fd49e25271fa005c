// The ring of a vertex in its tangent plane. The including kernel declares vertices, places, given
// and offsets.
#include "fair_plane.glsl"
#include "fair_walk.glsl"

// A control point nearer to an edge of its wedge than this part of the other edge is not safely
// inside.
const float kLeastSafeCoordinate = 0.02;
const float kRegularCoordinate = 1.0 / 6.0;
#define INFINITE uintBitsToFloat(0x7f800000u)

struct RingCorner {
  vec2 next, previous;  // edges beside it
  vec2 offset;          // of the control point
};

struct Ring {
  FairVertex vertex;
  vec3 origin;
  Frame frame;
  vec2 mean;  // of the control points
};

vec2 ring_offset(Ring ring, uint i) {
  return project(ring.frame, offsets_at(places_at(ring.vertex.first + i).corner).xyz);
}
RingCorner ring_corner(Ring ring, uint i) {
  FairPlace place = places_at(ring.vertex.first + i);
  return RingCorner(project(ring.frame, given_at(place.next).xyz - ring.origin),
                    project(ring.frame, given_at(place.previous).xyz - ring.origin),
                    project(ring.frame, offsets_at(place.corner).xyz));
}

Ring ring_of(uint v, vec3 normal) {
  Ring ring = Ring(vertices_at(v), given_at(v).xyz, frame_of(normal), vec2(0.0));
  FOR_RING(i, 0u, ring.vertex.count) ring.mean += ring_offset(ring, i);
  ring.mean = ring_sum(ring.mean) / float(ring.vertex.count);
  return ring;
}

// Counts a coordinate from the least one on, so that the imbalance grows to infinity there instead
// of jumping; regular ones stay as they are.
float above_least(float coordinate) {
  const float kScale = kRegularCoordinate / (kRegularCoordinate - kLeastSafeCoordinate);
  return kScale * (coordinate - kLeastSafeCoordinate);
}

// How far the mean of the control points lies out of balance; imbalance() of fair/vertex_polygon.h.
float imbalance(Ring ring) {
  float worst = 0.0;
  FOR_RING(i, 0u, ring.vertex.count) {
    RingCorner corner = ring_corner(ring, i);
    Wedge own = wedge_of(corner.offset, corner.next, corner.previous);
    if (!own.valid || own.along_next <= kLeastSafeCoordinate ||
        own.along_previous <= kLeastSafeCoordinate) {
      worst = INFINITE;
      break;
    }
    Wedge mean = wedge_of(ring.mean, corner.next, corner.previous);
    float ratio = max(abs(mean.along_next) / above_least(own.along_next),
                      abs(mean.along_previous) / above_least(own.along_previous));
    // Straight corners too grow to infinity instead of jumping.
    worst = max(worst, ratio / wedge_share(corner.next, corner.previous));
  }
  return ring_max(worst);
}
