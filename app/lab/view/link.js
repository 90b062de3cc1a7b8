/**
 * The address at which the page of viewimit opens in the lab's state: MessagePack, in a Zstandard frame that compresses
 * nothing, in base 64. The page reads it as it reads its own links.
 */

const DEGREE = Math.PI / 180, FORM = "1"; // the first character of the page's links

/**
 * @param {import("./address.js").State} state
 * @param {string} scene as the page's settings name it: a shipped one, or the text of a scene file
 * @param {string[]} layouts of body points that the scene has there
 */
export function pageLink(state, scene, layouts) {
  const degrees = (/** @type {number[]} */ angles) => angles.map(v => Number((v / DEGREE).toFixed(6)));
  const points = layouts.includes(String(state.points)) ? state.points : Math.min(...layouts.map(Number));
  const settings = {
    scene, points, demonstrator_deg: degrees(state.demonstrator), start_deg: degrees(state.start),
    transfer: state.transfer, servo: state.servo, noise_px: state.noisePx,
    missing: state.missing, seed: state.seed, frames: 1, rectify: "off",
  };
  const script = {settings, deeds: state.steps ? [["s", state.steps]] : []};
  const text = btoa(String.fromCharCode(...frame(packed({script}))));
  return FORM + text.replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

/** MessagePack of plain data. @param {unknown} value @returns {number[]} bytes */
function packed(value) {
  if (typeof value === "string") {
    const bytes = [...new TextEncoder().encode(value)];
    return [0xda, bytes.length >> 8, bytes.length & 255, ...bytes];
  }
  if (typeof value === "number") {
    const view = new DataView(new ArrayBuffer(9));
    if (Number.isInteger(value) && value >= 0 && value < 2 ** 32) {
      view.setUint8(0, 0xce);
      view.setUint32(1, value);
      return [...new Uint8Array(view.buffer, 0, 5)];
    }
    view.setUint8(0, 0xcb);
    view.setFloat64(1, value);
    return [...new Uint8Array(view.buffer)];
  }
  if (Array.isArray(value)) return [0xdc, value.length >> 8, value.length & 255, ...value.flatMap(packed)];
  const entries = Object.entries(/** @type {object} */ (value));
  const fields = entries.flatMap(([name, each]) => [...packed(name), ...packed(each)]);
  return [0xde, entries.length >> 8, entries.length & 255, ...fields];
}

/** A Zstandard frame (RFC 8878) of one block as it is. @param {number[]} bytes fewer than 64 kB */
function frame(bytes) {
  const size = bytes.length, header = size << 3 | 1; // the last block, raw
  const content = size < 256 ? [0x20, size] : [0x60, size - 256 & 255, size - 256 >> 8];
  return [0x28, 0xb5, 0x2f, 0xfd, ...content, header & 255, header >> 8 & 255, header >> 16 & 255, ...bytes];
}
