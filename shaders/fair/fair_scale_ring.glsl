// Scales all control points of a vertex with sharp edges, those on its curves too;
// scale_curve_vertex() of fair/perpendicular_curve.h. The including kernel declares places, links and
// result.
void scale_ring(FairVertex vertex, float factor) {
  uint begins = kNone, last = kNone;  // curve points that the first sector begins and the last ends with
  for (uint i = vertex.first; i < vertex.first + vertex.count; ++i) {
    uint corner = places_at(i).corner;
    FairLinks beside = links_at(corner);
    result[corner].xyz *= factor;
    last = beside.after;
    if (beside.before < parameters.corner_count) continue;
    result[beside.before].xyz *= factor;
    if (begins == kNone) begins = beside.before;
  }
  if (last >= parameters.corner_count && last != begins) result[last].xyz *= factor;
}
