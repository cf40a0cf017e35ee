// Ray-box tests as texts and papers give them, in float64; tests/contestants/slab_tests.cpp has them in C++.

/** Runs `axis(origin, direction, min, max)` over the axes; it returns [entry, exit], or null for a miss. */
function fold({origin, direction, min, max}, axis, larger = Math.max, smaller = Math.min) {
  let enter = -Infinity, exit = Infinity;
  for (let k = 0; k < 3; ++k) {
    const span = axis(origin[k], direction[k], min[k], max[k]);
    if (!span) return null;
    enter = larger(enter, span[0]);
    exit = smaller(exit, span[1]);
  }
  return [enter, exit];
}

const ordered = (a, b) => a > b ? [b, a] : [a, b];
const answer = (enter, exit, hit = exit >= 0) => hit ? enter >= 0 ? enter : exit : null;

function swap(given, isOutside = (o, min, max) => o < min || o > max) {
  const span = fold(given, (o, d, min, max) => {
    if (d === 0) return isOutside(o, min, max) ? null : [-Infinity, Infinity];
    return ordered((min - o) / d, (max - o) / d);
  });
  return span && span[0] <= span[1] ? span : null;
}

function divideAndSwap(given) {
  const span = swap(given);
  return span && answer(...span);
}

/** Pairs of slabs, one after the other, as three of the texts compare them. */
function pairs(planes, accept) {
  let [enter, exit] = planes[0];
  for (const [near, far] of planes.slice(1)) {
    if (enter > far || near > exit) return null;
    if (near > enter) enter = near;
    if (far < exit) exit = far;
  }
  return accept(enter, exit) ? enter >= 0 ? enter : exit : null;
}

function williams({origin, direction, min, max}) {
  return pairs([0, 1, 2].map((k) => {
    const inverse = 1 / direction[k];
    const [near, far] = inverse < 0 ? [max[k], min[k]] : [min[k], max[k]];
    return [(near - origin[k]) * inverse, (far - origin[k]) * inverse];
  }), (enter, exit) => enter < Infinity && exit > 0);
}

/** std::max and std::min, which take the first where one is NaN. */
const larger = (a, b) => a < b ? b : a, smaller = (a, b) => b < a ? b : a;

/** planes(origin, direction, min, max) gives the t of both planes of a slab. */
function minMaxOf(given, planes) {
  const [enter, exit] = fold(given, (...slab) => {
    const [a, b] = planes(...slab);
    return [smaller(a, b), larger(a, b)];
  }, larger, smaller);
  return answer(enter, exit, exit >= larger(enter, 0));
}

const minMax = (given) => minMaxOf(given, (o, d, min, max) => [(min - o) * (1 / d), (max - o) * (1 / d)]);

/** a * b + c, rounded once: std::fma, which JavaScript lacks. */
function fused(a, b, c) {
  if (![a, b, c].every(Number.isFinite)) return a * b + c;
  const whole = (x) => {
    let exponent = 0;
    for (; !Number.isInteger(x); --exponent) x *= 2;
    return [BigInt(x), exponent];
  };
  const [[p, i], [q, j], [r, k]] = [a, b, c].map(whole), low = Math.min(i + j, k);
  return Number((p * q << BigInt(i + j - low)) + (r << BigInt(k - low))) * 2 ** low;
}

const fusedInverse = (given) => minMaxOf(given, (o, d, min, max) => [fused(min, 1 / d, -o * (1 / d)), fused(max, 1 / d, -o * (1 / d))]);

function padded({origin, direction, min, max}) {
  let enter = 0, exit = Infinity;
  for (let k = 0; k < 3; ++k) {
    const inverse = 1 / direction[k], back = inverse < 0;
    const near = ((back ? max[k] : min[k]) - origin[k]) * inverse, far = ((back ? min[k] : max[k]) - origin[k]) * inverse;
    enter = near > enter ? near : enter;
    exit = far < exit ? far : exit;
  }
  const gamma = 3 * 2 ** -53 / (1 - 3 * 2 ** -53);
  // The paper asks for hit or miss; from inside, entry is the origin.
  return enter <= exit * (1 + 2 * gamma) ? enter > 0 ? enter : exit : null;
}

function inverted(given) {
  const span = swap(given, (o, min, max) => !(o < min || o > max));
  return span && answer(...span);
}

function slide(given) {
  const span = fold(given, (o, d, min, max) => {
    if (d === 0) return o < min || o > max ? null : [-Infinity, Infinity];
    return [(min - o) / Math.abs(d), (max - o) / Math.abs(d)];
  });
  return span && span[0] <= span[1] && span[1] >= 0 ? span[0] >= 0 ? span[0] : span[1] : null;
}

function atLeastZero({origin, direction, min, max}) {
  return pairs([0, 1, 2].map((k) => [true, false].map((near) =>
    (((direction[k] >= 0) === near ? min[k] : max[k]) - origin[k]) / direction[k])), (enter, exit) => enter <= Infinity && exit >= 0);
}

function positiveEntry(given) {
  const span = swap(given);
  return span && span[1] >= 0 ? span[0] > 0 ? span[0] : span[1] : null;
}

function entryAlways(given) {
  const span = swap(given);
  return span && span[1] >= 0 ? span[0] : null;
}

function twoAxes({origin, direction, min, max}) {
  return pairs([0, 1].map((k) => ordered((min[k] - origin[k]) / direction[k], (max[k] - origin[k]) / direction[k])),
    (enter, exit) => exit >= 0 && enter <= Infinity);
}

function example(given) {
  const [enter, exit] = fold(given, (o, d, min, max) => ordered((min - o) / d, (max - o) / d),
    (a, b) => Number.isNaN(a) ? a : !(a > b) ? b : a, (a, b) => Number.isNaN(a) ? a : !(a < b) ? b : a);
  if (exit < enter || exit < 0) return null;
  return enter > 0 ? enter : exit;
}

const BOX = {min: [-2, -3, -4], max: [4, 3, 2]};

/** name, what is wrong, test(given) -> t or null for a miss, and a case where it fails. */
export const FORMULAS = [
  ["Divide and swap", "right but for rounding", divideAndSwap,
    {origin: [-1, -0.1, 0], direction: [1, 1, 0], min: [1.9, 2.5, -1], max: [2.5, 2.8, 1]}],
  ["Williams et al. 2005", "open limits: an origin on the exit face is lost", williams, {origin: [4, 0, 0], direction: [1, 0.015625, 0.015625], ...BOX}],
  ["Minimum and maximum", "0 times infinity in the plane of a face", minMax, {origin: [-10, 3, 0], direction: [1, 0, 0], ...BOX}],
  ["Fused inverse", "a slab without numbers counts as open", fusedInverse, {origin: [-10, -5, 0], direction: [1, 0, 0], ...BOX}],
  ["Ize 2013, padded", "hits boxes that the ray just passes", padded,
    {origin: [0, 0, 0], direction: [1, 1, 0], min: [1, -1, -1], max: [2, 0.9999999999999999, 1]}],
  ["Inverted parallel test", "rejects an origin between the planes", inverted, {origin: [-10, 0, 0], direction: [1, 0, 0], ...BOX}],
  ["Slide, iteration 2", "divides by |d|: the sign is lost", slide, {origin: [10, 0, 0], direction: [-1, 0, 0], ...BOX}],
  ["d >= 0 chooses the plane", "-0 takes the branch of 0", atLeastZero, {origin: [-10, 0, 0], direction: [1, -0, 0], ...BOX}],
  ["Positive entry", "an entry of 0 counts as behind", positiveEntry, {origin: [-2, 0, 0], direction: [1, 0.015625, 0.015625], ...BOX}],
  ["Always the entry", "from inside, the entry lies behind", entryAlways, {origin: [0, 0, 0], direction: [-1, -0.5, -0.25], ...BOX}],
  ["Pairs in x and y", "ignores z", twoAxes, {origin: [-10, 1, 9], direction: [1, 0.125, 0], ...BOX}],
  ["Example code in 3-D", "0 / 0 silences the test", example, {origin: [-10, 3, 0], direction: [1, -0, 0], ...BOX}],
];

const FLAT = {min: [1, 1, null], max: [3, 3, null]};
const OBLIQUE = [1, 0.015625, 0.015625];

/** name -> a ray and a box. */
export const CASES = [
  ["Figure 1: misses", {origin: [0, 2.5, 0], direction: [1, 1, 0], ...FLAT}],
  ["Figure 2: hits", {origin: [0, 0.5, 0], direction: [1, 1, 0], ...FLAT}],
  ["Figure 3: misses", {origin: [0, -2.5, 0], direction: [1, 1, 0], ...FLAT}],
  ["from the front, oblique", {origin: [-10, 0, 0], direction: OBLIQUE, ...BOX}],
  ["along +x", {origin: [-10, 0, 0], direction: [1, 0, 0], ...BOX}],
  ["along -x", {origin: [10, 0, 0], direction: [-1, 0, 0], ...BOX}],
  ["direction (1,-0,0)", {origin: [-10, 0, 0], direction: [1, -0, 0], ...BOX}],
  ["parallel, outside the slab", {origin: [-10, 5, 0], direction: [1, 0, 0], ...BOX}],
  ["in the plane y = 3 (touching)", {origin: [-10, 3, 0], direction: [1, 0, 0], ...BOX}],
  ["in the plane y = 3 with -0", {origin: [-10, 3, 0], direction: [1, -0, 0], ...BOX}],
  ["origin inside, along +x", {origin: [0, 0, 0], direction: [1, 0, 0], ...BOX}],
  ["origin inside, negative diagonal", {origin: [0, 0, 0], direction: [-1, -0.5, -0.25], ...BOX}],
  ["box behind", {origin: [10, 0, 0], direction: OBLIQUE, ...BOX}],
  ["origin on the entry face", {origin: [-2, 0, 0], direction: OBLIQUE, ...BOX}],
  ["origin on the exit face, leaving", {origin: [4, 0, 0], direction: OBLIQUE, ...BOX}],
  ["along an edge", {origin: [-10, 3, 2], direction: [1, 0, 0], ...BOX}],
  ["through a corner", {origin: [-3, -4, -5], direction: [1, 1, 1], ...BOX}],
  ["negative diagonal", {origin: [10, 1, 1], direction: [-1, -0.0625, -0.0625], ...BOX}],
];
