/** What is computed once, and kept as long as what it was computed for. */

const kept = /** @type {WeakMap<object, Map<string, {key: string, value: any}>>} */ (new WeakMap());

/** @template T @param {object} owner @param {string} name of what is computed @param {() => T} compute
 * @param {string} [key] once it differs, it is computed again @returns {T} */
export function once(owner, name, compute, key = "") {
  const known = kept.get(owner) ?? new Map();
  kept.set(owner, known);
  if (known.get(name)?.key !== key) known.set(name, {key, value: compute()});
  return known.get(name).value;
}
