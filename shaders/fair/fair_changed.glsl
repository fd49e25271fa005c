// Whether the last round of the cure changed a vertex; in the beginning all count as changed. The
// including kernel declares flags, whose other bits it sets meanwhile.
bool is_changed(uint vertex) {
  return parameters.start != 0u || (atomicOr(flags[vertex], 0u) & kChanged) != 0u;
}
