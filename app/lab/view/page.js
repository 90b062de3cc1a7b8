/** What every page in one file does: find its elements, unpack its data, say what went wrong. */

/** @param {string} id @returns {any} */
export const byId = id => document.getElementById(id);

/** The data that an element's text holds. @param {string} id */
export function unpacked(id) {
  const bytes = Uint8Array.from(atob(byId(id).textContent), c => c.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate")));
}

/** @param {string} why */
export function fault(why) {
  byId("fault").textContent = why;
  byId("fault").hidden = false;
}
