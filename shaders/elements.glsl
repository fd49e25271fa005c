// Elements of kLength floats, in pieces of up to four. The including kernel declares source_at() and
// target[].

// Floats of an element, and from one element to the next.
layout(constant_id = 3) const uint kLength = 3u;
layout(constant_id = 4) const uint kSourceStride = kPointFloats;
layout(constant_id = 5) const uint kTargetStride = kPointFloats;

// `left`: floats from `at` to the element's end.
vec4 source_piece(uint at, uint left) {
  vec4 piece = vec4(0.0);
  piece.x = source_at(at);
  if (left > 1u) piece.y = source_at(at + 1u);
  if (left > 2u) piece.z = source_at(at + 2u);
  if (left > 3u) piece.w = source_at(at + 3u);
  return piece;
}

// OpenSubdiv's sums begin at 0, which no addition of zeros makes -0; compilers may leave it out.
void write_piece(vec4 piece, uint at, uint left) {
  piece = mix(piece, vec4(0.0), equal(piece, vec4(0.0)));
  target[at] = piece.x;
  if (left > 1u) target[at + 1u] = piece.y;
  if (left > 2u) target[at + 2u] = piece.z;
  if (left > 3u) target[at + 3u] = piece.w;
}
