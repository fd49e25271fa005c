// The list grows; the including kernel declares flags[], velocity[] and work[].

// True where the row was not yet in the list.
bool wake(uint row) {
  // Most have been woken before: a look is cheaper than an exchange.
  if ((flags[row] & kRowListed) != 0u || (atomicOr(flags[row], kRowListed) & kRowListed) != 0u)
    return false;
  velocity[row] = vec4(0.0);
  uint place = atomicAdd(work[kEditRows], 1u);
  work[parameters.first_listed + place] = row;
  atomicMax(work[kEditForRows], groups_of(place + 1u));
  return true;
}
