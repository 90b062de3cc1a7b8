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

/** What draws in the next frame, however often it is asked to. @param {() => void} draw */
export function perFrame(draw) {
  let isDue = false;
  return () => {
    if (!isDue) requestAnimationFrame(() => {
      isDue = false;
      draw();
    });
    isDue = true;
  };
}

const COPY_MS = 400, COPIED_MS = 1500; // what the clipboard may take, and how long the button says what happened

/** Copy a text, or show it where a page may not.
 * @param {HTMLElement} button that says what happened @param {string} text
 * @param {string} about the text, where it is shown */
export async function copy(button, text, about) {
  const usual = button.dataset.usual ??= button.textContent ?? "";
  button.textContent = "Copying";
  try {
    await Promise.race([navigator.clipboard.writeText(text), new Promise((_, refuse) => setTimeout(refuse, COPY_MS))]);
    button.textContent = "Copied";
  } catch {
    prompt(about, text);
  }
  setTimeout(() => { button.textContent = usual; }, COPIED_MS);
}
