// What viser's page lacks for keys and screen readers. All else of the page is done without a script.
"use strict";
const labelOf = element => {
  while (element && !element.querySelector("label")) element = element.parentElement;
  return element ? element.querySelector("label").textContent : "";
};
const set = (element, name, value) => element.getAttribute(name) === value || element.setAttribute(name, value);
const ICONS = {"list-search": "Commands", adjustments: "Settings", "arrow-back": "Back to the controls"};
const NUMBER = "input[inputmode]";
const FOLDER = ".mantine-Paper-root[data-with-border]>.mantine-Paper-root:first-child";

// A slider's thumb and number box get the name and the range that stand around them; icons get names, folders a role
const describe = () => {
  for (const thumb of document.querySelectorAll("[role=slider]")) {
    const name = labelOf(thumb);
    const box = thumb.closest(".mantine-Slider-root").parentElement.querySelector(NUMBER);
    const range = ["min", "max"].map(end => thumb.getAttribute(`aria-value${end}`).replace("-", "−")).join(" … ");
    set(thumb, "aria-label", name);
    if (box) {
      set(box, "aria-label", `${name}, ${range}`);
      set(box, "placeholder", range);
    }
  }
  for (const [icon, name] of Object.entries(ICONS))
    for (const drawing of document.querySelectorAll(`button .tabler-icon-${icon}`))
      set(drawing.closest("button"), "aria-label", name);
  for (const folder of document.querySelectorAll(FOLDER)) {
    set(folder, "role", "button");
    set(folder, "tabindex", "0");
    set(folder, "aria-expanded", String(!folder.querySelector(".tabler-icon-chevron-down")));
  }
};
let waits = false;
const later = () => {
  if (waits) return;
  waits = true;
  setTimeout(() => { waits = false; describe(); }, 100);
};
new MutationObserver(later).observe(document, {childList: true, subtree: true});

// After a choice in a list the keys are the page's again, and Tab goes on from there
const LIST = "input[aria-haspopup=listbox]";
const leave = list => {
  if (!list.matches(LIST) || list.getAttribute("aria-expanded") === "true") return;
  const row = list.closest(".mantine-Flex-root");
  row.tabIndex = -1;
  row.focus();
};

document.addEventListener("keydown", event => {
  const here = event.target;
  if (here.matches(FOLDER) && (event.key === "Enter" || event.key === " ")) {
    event.preventDefault();
    event.stopPropagation();  // Space plays elsewhere
    here.click();
  }
  const card = event.key === "Escape" && document.querySelector(":popover-open");
  if (card) {
    event.stopPropagation();  // Escape is a key of the page, too
    card.hidePopover();
  }
  if (event.key === "Enter" && here.matches(LIST)) setTimeout(leave, 0, here);
}, true);
document.addEventListener("click", event => {
  if (event.target.closest("[role=option]")) setTimeout(() => leave(document.activeElement));
  if (event.detail && event.target.closest("button,[role=tab]"))
    document.activeElement.blur();  // by a pointer: Space plays
});

// A number box that is left without a number shows its value again, and one out of its range says which that is
let value = "";
document.addEventListener("focusin", event => { if (event.target.matches(NUMBER)) value = event.target.value; });
document.addEventListener("input", event => {
  const box = event.target;
  const thumb = box.matches(NUMBER) && box.closest(".mantine-Flex-root").querySelector("[role=slider]");
  if (!thumb) return;
  const [low, high] = ["min", "max"].map(end => Number(thumb.getAttribute(`aria-value${end}`)));
  const out = box.value !== "" && !(low <= Number(box.value) && Number(box.value) <= high);
  box.setCustomValidity(out ? `From ${box.placeholder.replace("…", "to")}` : "");
  if (out) box.reportValidity();
}, true);
document.addEventListener("focusout", event => {
  const box = event.target;
  if (!box.matches(NUMBER)) return;
  box.setCustomValidity("");
  if (/\d/.test(box.value)) return;
  Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(box, value);
  box.dispatchEvent(new Event("input", {bubbles: true}));
});

// A link to a state: what the page's address asks for is told once, and is then gone from it, so that a reload goes on
const asked = new URLSearchParams(location.search).get("s");
const followLink = () => {
  const place = document.querySelector("[data-link]");
  if (!place) return false;
  fetch(place.dataset.link + encodeURIComponent(asked), {credentials: "same-origin"});
  history.replaceState(null, "", location.pathname);
  return true;
};
if (asked) {
  const waiting = new MutationObserver(() => followLink() && waiting.disconnect());
  waiting.observe(document, {childList: true, subtree: true});
}

document.addEventListener("click", event => {
  const button = event.target.closest(".vi-copy");
  if (!button) return;
  const text = button.parentElement.querySelector("pre");
  getSelection().selectAllChildren(text);
  const copied = navigator.clipboard ? navigator.clipboard.writeText(text.textContent)
    : Promise.resolve(document.execCommand("copy"));  // without https there is no other
  copied.then(() => { button.textContent = "Copied"; setTimeout(() => { button.textContent = "Copy"; }, 1500); });
});
