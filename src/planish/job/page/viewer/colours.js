// Colours of maps, all to be told apart by colour-blind eyes and quiet where all is well: YlGnBu by
// ColorBrewer (Apache-2.0), vik by Fabio Crameri (MIT), and grey to vermilion.

const STOPS = 12;

function colours(text) {
  return text.split(' ').map((hex) => [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255));
}

/** STOPS colours evenly along a list of them. */
function evenly(list) {
  return Array.from({ length: STOPS }, (_, stop) => {
    const place = stop / (STOPS - 1) * (list.length - 1);
    const i = Math.min(Math.floor(place), list.length - 2);
    return list[i].map((from, k) => from + (list[i + 1][k] - from) * (place - i));
  });
}

const MAPS = {
  amount: evenly(colours('ffffd9 edf8b1 c7e9b4 7fcdbb 41b6c4 1d91c0 225ea8 253494 081d58')),
  signed: evenly(colours('001260 023e7d 1d6e9c 71a7c4 c9dde7 eacebd d39774 be6533 8b2706 590007')),
  share: evenly(colours('d4d4d4 df8140 de7028 da6818 d86310 d76009 d65e04 d55e00')),
};

/** Of a board of squares. */
const CHECKS_DARK = [0.13, 0.35, 0.55], CHECKS_LIGHT = [0.95, 0.93, 0.88];

/** Three significant digits, written as the figures below the view are (page.h). */
function figure(x) {
  if (x === 0) return '0';
  const size = Math.abs(Number(x.toPrecision(3)));
  if (size >= 1e3 && size < 1e6) return Number(x.toPrecision(3)).toLocaleString('en-US');
  const exponent = Math.floor(Math.log10(Math.abs(Number(x.toPrecision(3)))));
  if (exponent >= -4 && exponent < 3) return String(Number(x.toPrecision(3)));
  const [digits, power] = Number(x.toPrecision(3)).toExponential().split('e');
  return `${digits}e${power[0]}${power.slice(1).padStart(2, '0')}`;
}
