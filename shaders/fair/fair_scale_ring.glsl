// Scales all control points of a vertex with sharp edges, those on its curves too;
// scale_curve_vertex() of fair/perpendicular_curve.h. The including kernel declares places, links and
// result, together.
#include "fair_walk.glsl"
void scale_ring(FairVertex vertex, float factor) {
  ring_sync();
  // The curve points that the first sector begins and the last one ends with.
  uint begins = links_at(places_at(vertex.first).corner).before;
  uint last = links_at(places_at(vertex.first + vertex.count - 1u).corner).after;
  FOR_RING(i, vertex.first, vertex.count) {
    uint corner = places_at(i).corner;
    uint before = links_at(corner).before;
    result[corner].xyz *= factor;
    if (before >= parameters.corner_count) result[before].xyz *= factor;
  }
  if (leads() && last >= parameters.corner_count && last != begins) result[last].xyz *= factor;
}
