// The sectors between curve points at a vertex. The including kernel declares places and links.
struct CurveSector {
  uint first, count;    // places
  uint curve0, curve1;  // points of the state before and after it
};

// The sector that begins at a place before `end`; false beside a cone, around which there is none.
bool sector_from(uint first, uint end, out CurveSector sector) {
  uint last = first;
  uint after = links_at(places_at(last).corner).after;
  while (last + 1u < end && after < parameters.corner_count) {
    ++last;
    after = links_at(places_at(last).corner).after;
  }
  uint before = links_at(places_at(first).corner).before;
  sector = CurveSector(first, last + 1u - first, before, after);
  return before >= parameters.corner_count && after >= parameters.corner_count;
}
