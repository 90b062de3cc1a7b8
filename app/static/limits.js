// What a browser may lack, and what happens without it: WebGL, or speed for it, and a connection to the server.
"use strict";
const CONNECTS_MS = 10_000;  // until the page says what to check
const SHORT_MS = 15_000;
const LEAST_FPS = 5, MEASURED_MS = 8_000;  // frames a second in 3-D, over this time

// viser builds no page without WebGL. The lab needs none, and opens in the state that the address names.
if (document.createElement("canvas").getContext("webgl2") === null) location.replace("lab#" + location.search.slice(1));

// A line that the page itself says. It has a style of its own: without a connection the page has no stylesheet.
const notices = new Map();
const notice = (name, words, lasts = 0) => {  // ms; 0: until it is closed
  notices.get(name)?.remove();
  notices.delete(name);
  if (!words) return;
  const box = document.createElement("div"), close = document.createElement("button");
  box.className = "vi-notice";
  box.setAttribute("role", "alert");
  box.style.cssText = "position:fixed;z-index:2000;left:calc((100vw + var(--left,0px) - var(--right,0px))/2);top:10px;translate:-50% 0;max-width:min(560px,92vw);"
    + "box-sizing:border-box;padding:10px 44px 10px 16px;border-radius:10px;background:#fff;color:#1b2430;"
    + "border:1px solid #8a5a00;box-shadow:0 4px 18px #0004;font:400 14px/20px Inter,system-ui,sans-serif";
  for (const line of words.split("\n")) box.append(Object.assign(document.createElement("div"), {textContent: line}));
  close.textContent = "×";
  close.setAttribute("aria-label", "Close");
  close.style.cssText = "position:absolute;right:6px;top:6px;width:30px;height:30px;border:0;background:none;color:inherit;"
    + "font-size:20px;cursor:pointer";
  close.addEventListener("click", () => box.remove());
  box.append(close);
  notices.set(name, box);
  if (lasts) setTimeout(() => box.remove(), lasts);
  document.body.append(box);
};

const UNREACHABLE = [
  "The page has no connection to its server yet. Please check:",
  "• Does “viewimit serve” still run?",
  "• A proxy in between must pass websockets on (the headers Upgrade and Connection).",
  "• Is this the address that the server printed? Another name needs its option --origin.",
  "• A filter or an extension of the browser may block websockets.",
].join("\n");
let isConnected = false;
const connected = () => {
  isConnected = true;
  notice("connection", "");
};
addEventListener("load", () => setTimeout(() => isConnected || notice("connection", UNREACHABLE), CONNECTS_MS));

// A still picture takes the place of the 3-D view where there is too little speed for it: `flatten` asks the server for
// it, once. While it is shown, nothing is drawn in 3-D.
let isFlat = false;
if (self.WebGL2RenderingContext)
  for (const name of ["drawArrays", "drawElements", "drawArraysInstanced", "drawElementsInstanced"]) {
    const draw = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...what) {
      if (!isFlat) draw.apply(this, what);
    };
  }
const watchSpeed = flatten => {
  let frames = 0, began = performance.now(), seen = !document.hidden;
  const count = () => {
    frames += 1;
    seen &&= !document.hidden;
    const passed = performance.now() - began;
    if (passed < MEASURED_MS) return requestAnimationFrame(count);
    if (!seen) {
      [frames, began, seen] = [0, performance.now(), !document.hidden];
      return requestAnimationFrame(count);
    }
    if (isFlat || 1000 * frames / passed >= LEAST_FPS) return;
    flatten();
    const words = "This machine draws the 3-D view slowly. A still picture takes its place; the folder Display brings it back.";
    notice("flat", words, SHORT_MS);
  };
  requestAnimationFrame(count);
};
