'use strict';
// Unpacks LZMA, as `xz --format=lzma` writes it with the size set in its header: a quarter less to carry than what
// browsers unpack by themselves. By the specification of the LZMA SDK; its names.
function unlzma(input) {
  const header = new DataView(input.buffer, input.byteOffset);
  const lc = input[0] % 9, lp = Math.floor(input[0] / 9) % 5, pb = Math.floor(input[0] / 45);
  const output = new Uint8Array(header.getUint32(5, true));
  const half = (count) => new Uint16Array(count).fill(1024);
  // The range decoder: probabilities of 11 bits.
  let at = 18, range = 0xffffffff, code = header.getUint32(14);
  const shift = () => {
    if (range >= 0x1000000) return;
    range = (range << 8) >>> 0;
    code = ((code << 8) | input[at++]) >>> 0;
  };
  const bit = (probabilities, i) => {
    const bound = (range >>> 11) * probabilities[i];
    const is = code >= bound;
    if (is) {
      range -= bound;
      code -= bound;
      probabilities[i] -= probabilities[i] >> 5;
    } else {
      range = bound;
      probabilities[i] += (2048 - probabilities[i]) >> 5;
    }
    shift();
    return is ? 1 : 0;
  };
  const direct = (count) => {
    let value = 0;
    for (; count > 0; --count) {
      range >>>= 1;
      const is = code >= range;
      if (is) code -= range;
      value = 2 * value + (is ? 1 : 0);
      shift();
    }
    return value;
  };
  const tree = (probabilities, from, bits) => {
    let m = 1;
    for (let i = 0; i < bits; ++i) m = 2 * m + bit(probabilities, from + m);
    return m - (1 << bits);
  };
  const reverse = (probabilities, from, bits) => {
    let m = 1, value = 0;
    for (let i = 0; i < bits; ++i) {
      const is = bit(probabilities, from + m);
      m = 2 * m + is;
      value += is << i;
    }
    return value;
  };
  const length = () => {
    const choice = half(2), low = half(128), mid = half(128), high = half(256);
    return (place) => {
      if (!bit(choice, 0)) return 2 + tree(low, 8 * place, 3);
      return bit(choice, 1) ? 18 + tree(high, 0, 8) : 10 + tree(mid, 8 * place, 3);
    };
  };
  const literals = half(0x300 << (lc + lp));
  const isMatch = half(192), isRep = half(12), isRepG0 = half(12), isRepG1 = half(12), isRepG2 = half(12), isRep0Long = half(192);
  const matchLength = length(), repLength = length();
  const slots = half(256), distances = half(128), align = half(16);
  const distance = (size) => {
    const slot = tree(slots, 64 * Math.min(size - 2, 3), 6);
    if (slot < 4) return slot;
    const bits = (slot >> 1) - 1;
    const first = ((2 | (slot & 1)) << bits) >>> 0;
    if (slot < 14) return first + reverse(distances, first - slot, bits);
    return first + 16 * direct(bits - 4) + reverse(align, 0, 4);
  };
  let state = 0, [rep0, rep1, rep2, rep3] = [0, 0, 0, 0];
  for (let to = 0; to < output.length;) {
    const place = to & ((1 << pb) - 1);
    if (!bit(isMatch, 16 * state + place)) {
      const before = to ? output[to - 1] : 0;
      const from = 0x300 * (((to & ((1 << lp) - 1)) << lc) + (before >> (8 - lc)));
      let symbol = 1;
      if (state >= 7) {
        let match = output[to - rep0 - 1], same = true;
        while (same && symbol < 256) {
          const top = match >> 7;
          match = (match << 1) & 255;
          const is = bit(literals, from + ((1 + top) << 8) + symbol);
          symbol = 2 * symbol + is;
          same = top === is;
        }
      }
      while (symbol < 256) symbol = 2 * symbol + bit(literals, from + symbol);
      output[to++] = symbol & 255;
      state = state < 4 ? 0 : state < 10 ? state - 3 : state - 6;
      continue;
    }
    let size;
    if (bit(isRep, state)) {
      if (!bit(isRepG0, state)) {
        if (!bit(isRep0Long, 16 * state + place)) {
          output[to] = output[to - rep0 - 1];
          ++to;
          state = state < 7 ? 9 : 11;
          continue;
        }
      } else if (!bit(isRepG1, state)) {
        [rep0, rep1] = [rep1, rep0];
      } else if (!bit(isRepG2, state)) {
        [rep0, rep1, rep2] = [rep2, rep0, rep1];
      } else {
        [rep0, rep1, rep2, rep3] = [rep3, rep0, rep1, rep2];
      }
      size = repLength(place);
      state = state < 7 ? 8 : 11;
    } else {
      [rep1, rep2, rep3] = [rep0, rep1, rep2];
      size = matchLength(place);
      state = state < 7 ? 7 : 10;
      rep0 = distance(size);
    }
    for (const end = to + size; to < end; ++to) output[to] = output[to - rep0 - 1];
  }
  return output;
}
