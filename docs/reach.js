// Keys reach what scrolls, and the captions of the theme's contents have the level that headings need
const reach = () => {
  for (const box of document.querySelectorAll(".equation, .table-wrapper, pre"))
    if (box.scrollWidth > box.clientWidth || box.scrollHeight > box.clientHeight) box.tabIndex = 0;
};
for (const event of ["load", "resize"]) addEventListener(event, reach);
document.addEventListener("DOMContentLoaded", () => {
  for (const caption of document.querySelectorAll(".caption[role=heading]")) caption.ariaLevel = "2";
});
