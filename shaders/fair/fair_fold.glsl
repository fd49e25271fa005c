// Finding what is turned over; fair/fold_repair.h. The including kernel declares owners, given,
// result, flags and counts.
// Cosine between a limit normal and the mesh's below which an element is turned over.
const float kLeastCosine = 0.5;

vec3 control_point(uint corner) { return given_at(owners_at(corner)).xyz + result_at(corner).xyz; }

// Whether a normal of any length is within `cosine` of the unit vector `reference`.
bool agrees(vec3 normal, vec3 reference, float cosine) {
  return dot(normal, reference) >= cosine * safe_length(normal);
}
