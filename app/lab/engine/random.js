/** numpy's `default_rng(seed)`, bit for bit: SeedSequence and PCG64 (O'Neill 2014), and its ziggurat (Marsaglia & Tsang
 * 2000) for normal numbers. So a seed spoils the same images here and in Python. */

const MASK_64 = (1n << 64n) - 1n, MASK_128 = (1n << 128n) - 1n;
const MULTIPLIER = 47026247687942121848144207491837523525n;
const LAYERS = 256, TAIL = 3.6541528853610087963519472518, LAYER_AREA = 0.0049286732339746519;

/** Of each layer of the ziggurat: its width over 2^52, the density at its edge, and below which draws need no test. */
const ZIGGURAT = (() => {
  const width = new Float64Array(LAYERS), density = new Float64Array(LAYERS), sure = new Float64Array(LAYERS), scale = 2 ** 52;
  let edge = TAIL;
  width[255] = edge / scale;
  density[255] = Math.exp(-0.5 * edge * edge);
  sure[0] = Math.floor(edge * density[255] / LAYER_AREA * scale);
  width[0] = LAYER_AREA / density[255] / scale;
  density[0] = 1;
  for (let i = 254; i > 0; i--) {
    const next = Math.sqrt(-2 * Math.log(LAYER_AREA / edge + density[i + 1]));
    sure[i + 1] = Math.floor(next / edge * scale);
    width[i] = next / scale;
    density[i] = Math.exp(-0.5 * next * next);
    edge = next;
  }
  return {width, density, sure};
})();

/** SeedSequence(seed).generate_state(4, uint64). @param {number[]} seed integers from 0 to 2^53 */
function seedState(seed) {
  const words = seed.flatMap(value => {
    const found = [value >>> 0];
    for (let rest = Math.floor(value / 2 ** 32); rest > 0; rest = Math.floor(rest / 2 ** 32)) found.push(rest >>> 0);
    return found;
  });
  let constant = 0x43b0d7e5;
  const hash = (/** @type {number} */ value) => {
    value ^= constant;
    constant = Math.imul(constant, 0x931e8875);
    value = Math.imul(value, constant);
    return value ^ value >>> 16;
  };
  const mix = (/** @type {number} */ x, /** @type {number} */ y) => {
    const value = Math.imul(0xca01f9dd, x) - Math.imul(0x4973f715, y) | 0;
    return value ^ value >>> 16;
  };
  const pool = [0, 1, 2, 3].map(i => hash(words[i] ?? 0));
  for (let from = 0; from < 4; from++) for (let to = 0; to < 4; to++)
    if (from !== to) pool[to] = mix(pool[to], hash(pool[from]));
  for (const word of words.slice(4)) for (let to = 0; to < 4; to++) pool[to] = mix(pool[to], hash(word));
  constant = 0x8b51f9dd;
  const halves = Array.from({length: 8}, (_, i) => {
    let value = pool[i % 4] ^ constant;
    constant = Math.imul(constant, 0x58f38ded);
    value = Math.imul(value, constant);
    return BigInt((value ^ value >>> 16) >>> 0);
  });
  return [0, 2, 4, 6].map(k => halves[k] | halves[k + 1] << 32n);
}

export class Generator {
  /** @param {number[]} seed as numpy takes it: [7, 0] for default_rng([7, 0]) */
  constructor(seed) {
    const [high, low, streamHigh, streamLow] = seedState(seed);
    this.increment = (streamHigh << 64n | streamLow) << 1n & MASK_128 | 1n;
    this.state = this.increment + (high << 64n | low) & MASK_128;
    this.#advance();
  }

  #advance() { this.state = this.state * MULTIPLIER + this.increment & MASK_128; }

  /** The next 64 bits. */
  next() {
    this.#advance();
    const folded = (this.state >> 64n ^ this.state) & MASK_64, turn = this.state >> 122n;
    return (folded >> turn | folded << (64n - turn & 63n)) & MASK_64;
  }

  /** Uniform in [0, 1). */
  random() { return Number(this.next() >> 11n) / 2 ** 53; }

  /** Standard normal. */
  normal() {
    const {width, density, sure} = ZIGGURAT;
    for (;;) {
      const bits = this.next(), layer = Number(bits & 255n), size = Number(bits >> 9n & 0xfffffffffffffn);
      const x = (bits >> 8n & 1n ? -1 : 1) * size * width[layer];
      if (size < sure[layer]) return x;
      if (layer === 0) for (;;) {
        const beyond = -Math.log1p(-this.random()) / TAIL, test = -Math.log1p(-this.random());
        if (test + test > beyond * beyond) return Math.floor(size / 256) & 1 ? -(TAIL + beyond) : TAIL + beyond;
      }
      if ((density[layer - 1] - density[layer]) * this.random() + density[layer] < Math.exp(-0.5 * x * x)) return x;
    }
  }
}

/** Numbers from 0 to 1 that a seed gives (mulberry32). @param {number} seed */
export function draws(seed) {
  let state = seed * 0x9e3779b1 | 0;
  return () => {
    state = state + 0x6d2b79f5 | 0;
    let t = Math.imul(state ^ state >>> 15, 1 | state);
    t = t + Math.imul(t ^ t >>> 7, 61 | t) ^ t;
    return ((t ^ t >>> 14) >>> 0) / 2 ** 32;
  };
}
