// What viser's page lacks for keys, screen readers and the stylesheet; and clicks in drawings, sent by the page's own
// connection. What a browser may lack is in limits.js, which comes before it.
"use strict";
// viser's worker has the connection. An action is sent at once, and again until a text widget that nobody sees shows its
// number: so each is taken once, in its order, also if the connection was lost
const LABEL = "vi-actions", AGAIN_MS = 2000, WATCHES_AFTER_MS = 4000, LOAD = Math.random().toString(36).slice(2);
const MOST_CHARS = 12000;  // of a message
let wire = null, box = "", acted = 0, unsaid = [], again = 0, isDue = false;
const say = () => {
  clearTimeout(again);
  if (!unsaid.length || !wire || !box) return;
  let chars = 0;
  const fits = unsaid.findIndex(([, , value], k) => k && (k === 60 || (chars += value.length + 40) > MOST_CHARS));
  const value = JSON.stringify({load: LOAD, acts: fits < 0 ? unsaid : unsaid.slice(0, fits)});
  wire.postMessage({type: "send", message: {type: "GuiUpdateMessage", uuid: box, updates: {value}}});
  again = setTimeout(say, AGAIN_MS);
};
const act = (control, value) => {
  unsaid.push([++acted, control, String(value)]);
  if (!isDue) queueMicrotask(() => { isDue = false; say(); });
  isDue = true;
};
const taken = last => {
  const before = unsaid.length;
  redone.push(...unsaid.filter(([number]) => number <= Number(last)));
  unsaid = unsaid.filter(([number]) => number > Number(last));
  if (unsaid.length && unsaid.length < before) say();
};
// What the tab keeps is handed back first, on each connection: then come clicks that were made since it was kept, and that
// the lost connection may have swallowed
const searched = new URLSearchParams(location.search);
const OWN_FIELDS = /^(present|websocket)(=|$)/;  // of the address: the others are of a link
const asked = location.search.slice(1).split("&").filter(field => field && !OWN_FIELDS.test(field)).join("&");
const kept = new TabSession(() => sessionStorage, `viewimit:${location.pathname}`, asked);
let keptBox = "", redone = [], sentProblem = "";
const handBack = () => {
  const left = [...redone, ...unsaid].filter(([number, control]) => number > kept.acted && !REPORTED.includes(control));
  unsaid = redone = [];
  act("session", kept.text);
  tellBrowser();
  for (const [, control, value] of left) act(control, value);
  sentProblem = "";
  tellProblem();
};
const tellProblem = () => { if (kept.problem !== sentProblem) act("unsaved", sentProblem = kept.problem); };
const keep = sent => {
  if (!sent) return;
  kept.take(sent);
  redone = redone.filter(([number]) => number > kept.acted);
  const page = new URL(location.href);
  const fields = [page.searchParams.has("present") ? "present" : "", kept.address];
  const search = fields.filter(Boolean).map((one, k) => (k ? "&" : "?") + one).join("");
  if (page.search !== search) history.replaceState(history.state, "", page.pathname + search);
  tellProblem();
};
const heard = message => {
  if (message.type === "GuiTextMessage" && message.props.label === LABEL) {
    box = message.uuid;
    if (!isConnected) setTimeout(watchSpeed, WATCHES_AFTER_MS, () => act("flat", 1));
    connected();
    handBack();
  } else if (message.type === "GuiTextMessage" && message.props.label === "vi-session") {
    keptBox = message.uuid;
    keep(message.value);
  } else if (message.type === "GuiUpdateMessage" && message.uuid === keptBox && "value" in message.updates) {
    keep(message.updates.value);
  } else if (message.type === "GuiUpdateMessage" && message.uuid === box && "value" in message.updates) {
    taken(message.updates.value);
  }
};
window.Worker = class extends Worker {
  postMessage(data, ...rest) {
    if (data && data.type === "set_server" && !wire) {
      wire = this;
      const page = new URL(location.href);
      if (page.searchParams.has("websocket")) {  // viser writes it under a sub-path; it is no part of what one shares
        page.searchParams.delete("websocket");
        history.replaceState(history.state, "", page);
      }
      const path = page.pathname.replace(/[^/]*$/, "");  // below which a proxy has the page: the server cannot know it
      const server = page.origin.replace(/^http/, "ws") + path + (path === "/" ? "" : `?at=${encodeURIComponent(path)}`);
      data = {...data, server};
      this.addEventListener("message", ({data: {type, messages}}) => {
        if (type === "connected") box = "";
        if (type === "message_batch") messages.forEach(heard);
      });
    }
    return super.postMessage(data, ...rest);
  }
};
document.addEventListener("click", event => {
  const link = event.target.closest("a[data-do]");
  if (!link) return;
  event.preventDefault();
  const [control, ...value] = link.dataset.do.split("/");
  act(control, value.join("/"));
});
// A click in a field of a drawing stands for the values at its place: across, and up where it has a second range
document.addEventListener("click", ({target, clientX, clientY}) => {
  const field = target.closest("[data-field]");
  if (!field || performance.now() < settledAt) return;  // a click at what stood there before would go astray
  const {left, bottom, width, height} = field.getBoundingClientRect();
  const [from, to, low, high] = field.dataset.values.split(",").map(Number);
  const across = from + (to - from) * (clientX - left) / width, up = low + (high - low) * (bottom - clientY) / height;
  act(field.dataset.field, high === undefined ? Math.round(across) : `${up.toFixed(1)},${across.toFixed(1)}`);
});
// What the browser knows, and reports to the page's server: at first, after a restart of the server, and as it changes
const MEDIA = Object.entries({
  dark: "(prefers-color-scheme:dark)",
  still: "(prefers-reduced-motion:reduce)",
}).map(([control, query]) => [control, matchMedia(query)]);
for (const [control, media] of MEDIA) media.addEventListener("change", () => act(control, Number(media.matches)));
const REPORTED = [...MEDIA.map(([control]) => control), "unseen", "truth", "session", "unsaved"];
const tellBrowser = () => {
  for (const [control, media] of MEDIA) act(control, Number(media.matches));
  sentUnseen = "none";
  tellUnseen();
  if (presenting()) tellPresenting();
};
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
  const page = document.getElementById("root");
  if (page) set(page, "role", "main");
  for (const folder of document.querySelectorAll(FOLDER)) {
    set(folder, "role", "button");
    set(folder, "tabindex", "0");
    set(folder, "aria-expanded", String(!folder.querySelector(".tabler-icon-chevron-down")));
  }
};

// What the stylesheet has to know of the whole page stands in classes of its root, and what holds a marker without having
// a name of its own gets one. With :root:has(…) a browser would compute all of the page's style again for each drawing
const root = document.documentElement;
const ALONE = "waiting flat basin details large large-figures large-l large-r large-L large-R";
const HELD = ALONE.split(" ").map(name => [`vi-has-${name}`, document.getElementsByClassName(`vi-${name}`)]);
const FOUND = Object.entries({
  "vi-views-controls": "#vi-view-controls:checked",
  "vi-views-images": "#vi-view-images:checked",
  "vi-views-landscape": "#vi-view-landscape:checked",
  "vi-views-scene": "#vi-view-scene:checked",
  "vi-reconnects": "[data-dock-unmergeable-header] .mantine-Loader-root",
});
const OF_MARKERS = [
  ["vi-lines", "vi-row", marker => marker.parentElement.parentElement],
  ["vi-quiet-lines", "vi-row vi-quiet", marker => marker.parentElement.parentElement],
  ["vi-play-cell", "vi-play-row", marker => marker.parentElement],
  ["vi-situation-cell", "vi-situation", marker => marker.parentElement],
  ["vi-tray-paper", "vi-tray", marker => marker.closest("[data-with-border]")],
  ["vi-steps-cell", "vi-steps-row", marker => marker.parentElement],
  ["vi-count-cell", "vi-count", marker => marker.parentElement],
  ["vi-stack", "vi-four", marker => marker.closest(".vi-above") ? null : marker.parentElement.parentElement],
  ["vi-before-tabs", "mantine-Tabs-root", marker => marker.parentElement.previousElementSibling],
].map(([name, marker, place]) => [name, document.getElementsByClassName(marker), place]);
const SETTLES_MS = 400;  // after panels became large or small
let settledAt = 0;
const name = () => {
  const wasLarge = root.classList.contains("vi-has-large");
  for (const [name, elements] of HELD) root.classList.toggle(name, elements.item(0) !== null);
  if (wasLarge !== root.classList.contains("vi-has-large")) settledAt = performance.now() + SETTLES_MS;
  isFlat = root.classList.contains("vi-has-flat");
  for (const [name, selector] of FOUND) root.classList.toggle(name, document.querySelector(selector) !== null);
  for (const [name, markers, place] of OF_MARKERS)
    for (const marker of markers) place(marker)?.classList.toggle(name, true);
  for (const strip of document.querySelectorAll("[data-dock-strip]"))
    strip.classList.toggle("vi-alone", strip.querySelectorAll("[role=tab]").length < 2);
};
document.addEventListener("change", name);
for (const [event, drags] of [["pointerdown", true], ["pointerup", false], ["pointercancel", false]])
  document.addEventListener(event, ({target}) => {
    root.classList.toggle("vi-drags", drags && target.closest(".mantine-Slider-root") !== null);
  }, true);
let waits = false;
const later = () => {
  if (waits) return;
  waits = true;
  setTimeout(() => {
    waits = false;
    describe();
    tellUnseen();
  }, 100);
};
new MutationObserver(() => {
  name();
  later();
}).observe(document, {childList: true, subtree: true});

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
  if (here.matches(`${FOLDER},.vi-ask,.vi-close`) && (event.key === "Enter" || event.key === " ")) {
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
  if (event.detail && event.target.closest("label,[type=checkbox]"))
    setTimeout(() => document.activeElement.matches("[type=checkbox],[type=radio]") && document.activeElement.blur());
});

// Arrows move the slider or the tab that has the focus, and nothing else
document.addEventListener("DOMContentLoaded", () => document.body.addEventListener("keydown", event => {
  if (event.key.startsWith("Arrow") && event.target.matches("[role=slider],[role=tab]")) event.stopPropagation();
}));

// A number box that is left without a number shows its value again, and one out of its range says which that is
let value = "";
document.addEventListener("focusin", event => { if (event.target.matches(NUMBER)) value = event.target.value; });
document.addEventListener("input", event => {
  const box = event.target;
  const thumb = box.matches(NUMBER) && box.closest(".mantine-Flex-root").querySelector("[role=slider]");
  if (!thumb) return;
  const [low, high] = ["min", "max"].map(end => Number(thumb.getAttribute(`aria-value${end}`)));
  const out = box.value !== "" && !(low <= Number(box.value) && Number(box.value) <= high);
  const [from, to] = box.placeholder.split(" … ");
  box.setCustomValidity(out ? "From {low} to {high}".replace("{low}", from).replace("{high}", to) : "");
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

// What nobody sees need not be drawn: tabs that are not open, and all of a window that another hides
const unseen = () => {
  const closed = Array.from(document.querySelectorAll("[role=tab][aria-selected=false]"), tab => tab.textContent);
  return document.hidden ? "window" : closed.filter(name => /^[^,]+$/.test(name)).join() || "none";
};
let sentUnseen = "none";
const tellUnseen = () => {
  const now = unseen();
  if (!box || now === sentUnseen) return;
  sentUnseen = now;
  act("unseen", now);
};
document.addEventListener("visibilitychange", tellUnseen);
for (const event of ["click", "keydown"]) document.addEventListener(event, () => later());
window.addEventListener("keydown", event => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const here = event.target, offer = document.querySelector(".vi-offer a");
  if (!here.matches("input,textarea") && presents(event.key)) {
    event.preventDefault();
    return event.stopPropagation();
  }
  if (event.key === " " && here.matches("a[role=button]")) {
    event.preventDefault();
    event.stopPropagation();
    return here.click();
  }
  if (offer && event.key === "Enter" && here === document.body) offer.click();
}, true);

// Keys of the page that viser turns its camera by while they are held: viser gets a message at once that they are not
const HELD_BY_VISER = ["ArrowLeft", "ArrowRight", "KeyE", "KeyS"];
window.addEventListener("keydown", event => {
  if (HELD_BY_VISER.includes(event.code)) document.dispatchEvent(new KeyboardEvent("keyup", {code: event.code}));
});

// Before a class: P, or ?present in the address. Letters are larger, controls folded, a ring goes with the pointer; what
// is true is hidden until T, in 3-D by the server
const pointer = document.createElement("div");
pointer.className = "vi-pointer";
const presenting = () => root.classList.contains("vi-presents");
const tellPresenting = () => act("truth", Number(!presenting() || root.classList.contains("vi-reveals")));
const present = (on, reveals) => {
  root.classList.toggle("vi-presents", on);
  root.classList.toggle("vi-reveals", reveals);
  document.body.append(pointer);
  tellPresenting();
  const view = document.querySelector(".vi-views :checked");  // of a small window: one that is there still
  if (on && view && getComputedStyle(view).display === "none") document.querySelector("#vi-view-images").click();
};
const presents = key => {
  if (key === "p" || key === "P") return present(!presenting(), false), true;
  if (!presenting()) return false;
  if (key !== "t" && key !== "T") return false;
  return present(true, !root.classList.contains("vi-reveals")), true;
};
document.addEventListener("pointermove", event => {
  pointer.style.translate = `${event.clientX}px ${event.clientY}px`;
});

// In a small window the lab is offered, until the visitor prefers the Workbench
const ANYWAY = "vi-anyway";
try { root.classList.toggle(ANYWAY, sessionStorage.getItem(ANYWAY) !== null); } catch { /* no storage: offered again */ }
document.addEventListener("click", ({target}) => {
  if (!target.closest(".vi-small button")) return;
  root.classList.add(ANYWAY);
  try { sessionStorage.setItem(ANYWAY, ""); } catch { /* not kept */ }
});

// A row of a matrix of an equation lights its epipolar line in the images
document.addEventListener("pointerover", ({target}) => {
  const row = target.closest("[data-lines] mtr"), {line} = root.dataset;
  const matrix = row && row.closest("[data-lines]").querySelector("mtable");
  const rows = matrix && matrix.contains(row) ? [...matrix.querySelectorAll("mtr")] : [];
  const lit = rows.length ? row.closest("[data-lines]").dataset.lines.split(" ")[rows.indexOf(row)] : undefined;
  if (lit === line) return;
  if (lit) root.dataset.line = lit;
  else delete root.dataset.line;
});

// A question that keys have come to keeps the focus when the numbers beside it are drawn again
let question = null;
document.addEventListener("focusin", ({target}) => { question = target.matches(".vi-ask:focus-visible") ? target : null; });
document.addEventListener("focusout", ({target}) => queueMicrotask(() => {  // removed elements are gone only then
  if (target.isConnected && target === question) question = null;
}));
new MutationObserver(() => {
  if (!question || question.isConnected || document.activeElement !== document.body) return;
  const again = document.querySelector(`.vi-ask[popovertarget=${question.getAttribute("popovertarget")}]`);
  if (!again) return;
  again.focus({preventScroll: true});
  question = again;
}).observe(document, {childList: true, subtree: true});
// A link to a state, in the address, is followed after what the tab has kept
if (kept.link) act("link", kept.link);
if (searched.has("present")) document.addEventListener("DOMContentLoaded", () => present(true, false));

document.addEventListener("click", event => {
  const button = event.target.closest(".vi-copy");
  if (!button) return;
  const text = button.parentElement.querySelector("pre");
  getSelection().selectAllChildren(text);
  const copied = navigator.clipboard ? navigator.clipboard.writeText(text.textContent)
    : Promise.resolve(document.execCommand("copy"));  // without https there is no other
  copied.then(() => { button.textContent = "Copied"; setTimeout(() => { button.textContent = "Copy"; }, 1500); });
});
