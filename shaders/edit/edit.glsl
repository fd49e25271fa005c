// What the kernels of edits have in common.
layout(local_size_x = 64) in;
layout(push_constant) uniform Parameters { EditParameters parameters; };

uint lane_count() { return gl_NumWorkGroups.x * kChunkRows; }
// Of a slot's list of stale rows.
uint stale_head(uint slot) { return slot * kStaleWords; }
uint stale_list(uint slot) {
  return parameters.slot_count * kStaleWords + slot * parameters.most_stale;
}
uint groups_of(uint lanes) {
  return min((lanes + (kChunkRows - 1u)) / kChunkRows, parameters.max_groups);
}
