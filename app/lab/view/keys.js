/** Keys of the whole page, but where something on it takes them for itself. */

/** @param {Record<string, () => void>} keys what each does, letters in lower case @param {() => boolean} isOn */
export function listen(keys, isOn) {
  document.addEventListener("keydown", event => {
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key, {target} = event;
    if (event.defaultPrevented || !isOn() || !(key in keys) || !(target instanceof Element)) return;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (target.matches("select, input[type=number]") || document.querySelector("dialog[open], :popover-open")) return;
    if (target.matches("input") && /^(Arrow|Home|End|Page)/.test(key)) return;
    if (key === " " && target.matches("button, summary, input[type=checkbox]")) return;
    event.preventDefault();
    keys[key]();
  });
}
