/**
 * What is wrong with the drawings of a page: texts whose boxes cover each other by more than their leading, texts that
 * leave their drawing, drawings that scroll, and those that say nothing of themselves. Names along a line are left out:
 * their boxes are larger than they are.
 */
() => [...document.querySelectorAll(".drawing")].flatMap(drawing => {
  const frame = drawing.getBoundingClientRect(), name = drawing.parentElement.className, faults = [];
  const isShown = element => {
    const style = getComputedStyle(element);
    return style.visibility !== "hidden" && Number(style.opacity) > 0;
  };
  const texts = [...drawing.querySelectorAll("svg text")]
    .filter(text => text.textContent.trim() && isShown(text) && !text.closest("[transform]"))
    .map(text => ({words: text.textContent, box: text.getBoundingClientRect()})).filter(({box}) => box.width);
  texts.forEach(({words, box: a}, k) => {
    if (a.left < frame.left - 2 || a.right > frame.right + 2 || a.top < frame.top - 3 || a.bottom > frame.bottom + 3)
      faults.push(`${name}: ${words} leaves its drawing`);
    for (const {words: other, box: b} of texts.slice(k + 1)) {
      const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (wide > 2 && high > 0.3 * Math.min(a.height, b.height)) faults.push(`${name}: ${words} covers ${other}`);
    }
  });
  const labels = [drawing, ...drawing.querySelectorAll("[aria-label]")].map(one => one.getAttribute("aria-label") ?? "");
  if (!labels.some(label => label.length > 8)) faults.push(`${name}: a screen reader hears nothing of it`);
  for (const inside of drawing.querySelectorAll("div"))
    if (getComputedStyle(inside).overflowY === "auto" && inside.scrollHeight > inside.clientHeight + 4)
      faults.push(`${name}: scrolls`);
  return faults;
})
