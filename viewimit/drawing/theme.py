"""Colours, shapes and type of the page, and the one global stylesheet made of them.

A role has one colour a colour scheme and one shape, everywhere the same. Drawings name roles only, as CSS
variables or classes, so that one drawing serves light and dark.
"""

import base64

from ..assets import ROOT

# role: (light, dark)
ROLES = {
    "learner": ("#0072b2", "#56b4e9"),
    "demonstrator": ("#e69f00", "#f0ad1e"),
    "demonstrator-edge": ("#8a5a00", "#ffdf9e"),
    "recovered": ("#007f5c", "#3fd0a2"),
    "residual": ("#d55e00", "#ff8440"),
    "opponent": ("#6a3fa0", "#b99cf5"),
    "chosen": ("#b0508a", "#e79ac6"),
    "stopped": ("#d0342c", "#ff6b61"),
    "ink": ("#1b2430", "#f0f2f5"),
    "secondary": ("#5a6675", "#b3bbc6"),
    "rule": ("#dde1e7", "#45484d"),
    "paper": ("#ffffff", "#242424"),
    "card": ("#f6f7f9", "#2e2f31"),
    "hills": ("#46566b", "#a9bad2"),
}

# px in a drawing: filled circle, hollow diamond, filled diamond (half diagonals), ring
OWN, RECOVERED, OBSERVED, RING = 3.0, 3.7, 3.6, 8.5
HEAD = 4.6  # of a residual's arrow

PILL_BOTTOM = 16  # px from the pill to the bottom of the scene; the curves' card stands above it


def rgb(role: str, dark: bool = False) -> tuple[int, int, int]:
    """0 … 255 each."""
    colour = ROLES[role][dark]
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def half_white(role: str) -> tuple[int, int, int]:
    """The role's hue mixed half with white: the arms in 3-D, whose points have the full hue."""
    return tuple((channel + 255) // 2 for channel in rgb(role))


def _variables(dark: bool) -> str:
    return "".join(f"--{role}:{colours[dark]};" for role, colours in ROLES.items())


def _font() -> str:
    data = base64.b64encode((ROOT / "fonts" / "Inter.woff2").read_bytes()).decode()
    return (
        "@font-face{font-family:Inter;font-weight:400 700;font-display:block;"
        f'src:url("data:font/woff2;base64,{data}") format("woff2")}}'
    )


_PAGE = """
body,button,input,textarea,.mantine-Text-root,[class*=mantine-]:not(svg,svg *){
  font-family:Inter,system-ui,sans-serif;font-variant-numeric:tabular-nums}
:root{--mantine-font-family:Inter,system-ui,sans-serif;--mantine-primary-color-filled:#0072b2;
  --mantine-primary-color-filled-hover:#005f95;--mantine-primary-color-light-color:#0072b2;accent-color:#0072b2}
:root[data-mantine-color-scheme="dark"]{--mantine-primary-color-filled:#2f8fd0;
  --mantine-primary-color-filled-hover:#2780bd;--mantine-primary-color-light-color:#56b4e9}
.mantine-Slider-bar{background:var(--learner)}
.mantine-Slider-thumb{background:var(--learner)!important;border-color:var(--learner)!important}
.mantine-Paper-root[data-with-border]:has(.vi-demonstrator-folder) .mantine-Slider-bar{background:var(--demonstrator)}
.mantine-Paper-root[data-with-border]:has(.vi-demonstrator-folder) .mantine-Slider-thumb{
  background:var(--demonstrator)!important;border-color:var(--demonstrator)!important}
.mantine-Slider-markWrapper{display:none}
div[style*="padding-bottom: 0.5em"]{padding-bottom:3px!important}
.mantine-Paper-root[style*="margin-bottom: var(--mantine-spacing-md)"]{margin-bottom:9px!important}
math{font-family:"STIX Two Math","Latin Modern Math","Cambria Math","DejaVu Math TeX Gyre",
  "Noto Sans Math",math;font-size:16px;
  color:var(--ink)}
math mn,math mtext{font-family:Inter,system-ui,sans-serif;font-size:.86em;font-variant-numeric:tabular-nums}
canvas{anchor-name:--cv}
"""

_DRAWINGS = """
.vi{display:block;width:100%;height:auto;font:400 11px Inter,system-ui,sans-serif;font-variant-numeric:tabular-nums;
  fill:none;stroke-linecap:round;stroke-linejoin:round;user-select:none}
.vi text{fill:var(--ink);stroke:none}
.vi .vi-2nd{fill:var(--secondary)}
.vi .vi-b{font-weight:600}
.vi .vi-big{font-size:19px;font-weight:600}
.vi .vi-name{font-size:13px;font-weight:700}
.vi .vi-halo{paint-order:stroke;stroke:var(--paper);stroke-width:3px;stroke-opacity:.85}
.vi .vi-end{text-anchor:end}
.vi .vi-mid{text-anchor:middle}
.vi-plane{fill:var(--card);stroke:var(--rule)}
.vi-rule{stroke:var(--rule)}
.vi-axis{stroke:var(--secondary);stroke-opacity:.75}
.vi-lens{fill:var(--secondary);fill-opacity:.6}
.vi-hull{stroke-width:.6;fill-opacity:.13;stroke-opacity:.42}
.vi-hull,.vi-bone{stroke:var(--learner)}
.vi-hull{fill:var(--learner)}
.vi-demo .vi-hull{fill:var(--demonstrator);stroke:var(--demonstrator)}
.vi-demo .vi-bone{stroke:var(--demonstrator-edge)}
.vi-bone{stroke-width:1.7}
.vi-photograph{opacity:.72}
.vi-pictured .vi-hull{fill-opacity:0;stroke-opacity:.55}
.vi-pictured .vi-bone{opacity:.75}
.vi-pictured .vi-idle{opacity:.6}
.vi-pictured .vi-own,.vi-pictured .vi-seen,.vi-pictured path.vi-found,.vi-pictured .vi-e,.vi-pictured .vi-tip,
.vi-pictured .vi-ring{filter:drop-shadow(0 0 .7px var(--paper)) drop-shadow(0 0 .7px var(--paper))}
.vi-bone.vi-found{stroke:var(--recovered);stroke-width:1.4;stroke-dasharray:3 2.2;stroke-linecap:butt}
.vi-own{stroke:var(--learner);stroke-width:6}
.vi-seen{fill:var(--demonstrator);stroke:var(--demonstrator-edge);stroke-width:1}
.vi-pictured .vi-seen{fill-opacity:0;stroke:var(--demonstrator);stroke-width:1.3}
.vi-found{stroke:var(--recovered);stroke-width:1.5}
.vi-idle{opacity:.4}
.vi-e{stroke:var(--residual);stroke-width:1.8}
.vi-tip{fill:var(--residual)}
.vi-line{stroke:var(--chosen);stroke-width:1.1;stroke-linecap:butt}
.vi-from-right{stroke-dasharray:5 3}
.vi-partner{stroke-dasharray:1 2.4}
.vi-ring{stroke:var(--chosen);stroke-width:2.2}
.vi .vi-chosen{fill:var(--chosen);font-weight:600}
.vi-amber{fill:var(--demonstrator);stroke:var(--demonstrator-edge)}
.vi-red{fill:var(--stopped)}
.vi-line-E{stroke:var(--residual);stroke-width:1.8}
.vi-dot-E{stroke:var(--residual);stroke-width:5.2}
.vi-probe-E{stroke:var(--residual);stroke-width:1.3;fill:var(--paper)}
.vi-line-own{stroke:var(--learner);stroke-width:1.8}
.vi-dot-own{stroke:var(--learner);stroke-width:5.2}
.vi-probe-own{stroke:var(--learner);stroke-width:1.3;fill:var(--paper)}
.vi-line-demo{stroke:var(--demonstrator-edge);stroke-width:1.4;stroke-dasharray:5 4;stroke-linecap:butt}
.vi-line-opponent{stroke:var(--opponent);stroke-width:1.8;stroke-dasharray:4 2.6;stroke-linecap:butt}
.vi .vi-of-opponent{fill:var(--opponent);font-weight:600}
.vi-later{opacity:.3}
.vi-cursor{stroke:var(--secondary);stroke-width:1;stroke-dasharray:1 3}
.vi .vi-of-E{fill:var(--residual);font-weight:600}
.vi .vi-of-own{fill:var(--learner);font-weight:600}
.vi .vi-of-demo{fill:var(--demonstrator-edge)}
.vi-hills{fill:var(--hills)}
.vi-contour{stroke:var(--ink);stroke-opacity:.5;stroke-width:.8}
.vi-bar-cost{fill:var(--hills);fill-opacity:.55}
.vi-blind{stroke:var(--secondary);stroke-width:1}
.vi-lead{stroke:var(--ink);stroke-width:1}
.vi-lead-demo{stroke:var(--demonstrator-edge);stroke-width:1.2}
.vi-cross{stroke:var(--ink);stroke-width:1.7}
.vi-inset{fill:var(--paper);stroke:var(--secondary)}
.vi-now-opponent{stroke:var(--opponent);stroke-width:2.2;fill:none}
.vi-now{stroke:var(--paper);stroke-width:1.6;fill:var(--learner)}
"""

_BOXES = """
.vi-panel{padding:6px 8px 2px;font-family:Inter,system-ui,sans-serif;font-variant-numeric:tabular-nums}
.vi-over{height:0;position:relative;pointer-events:none}
.vi-over>.vi-panel{position:absolute;bottom:0;left:0;right:0}
.vi-card{position:fixed;z-index:5;left:316px;right:576px;left:calc(anchor(--cv left,300px) + 16px);
  right:calc(anchor(--cv right,560px) + 16px);bottom:76px;padding:4px 6px;border-radius:10px;
  background:var(--paper);border:1px solid var(--rule);box-shadow:0 2px 10px #0002;
  max-width:1180px;margin-inline:auto;pointer-events:none}
.vi-status{position:fixed;z-index:6;left:300px;right:460px;left:calc(anchor(--cv left,300px) + 12px);
  right:calc(anchor(--cv right,460px) + 12px);bottom:PILLpx;margin-inline:auto;width:fit-content;
  display:flex;align-items:center;gap:9px;padding:8px 15px 8px 11px;border-radius:11px;background:var(--paper);
  border:1px solid var(--rule);box-shadow:0 3px 12px #0002;color:var(--ink);
  font:400 14px/19px Inter,system-ui,sans-serif;font-variant-numeric:tabular-nums;pointer-events:none}
.vi-status svg{flex:none}
.vi-status b{font-weight:650}
.vi-eqs{padding:6px 8px 2px;font:400 11px/1.35 Inter,system-ui,sans-serif;color:var(--secondary)}
.vi-eq{background:var(--card);border:1px solid var(--rule);border-radius:6px;padding:2px 8px 3px;margin-bottom:4px}
.vi-eq b{color:var(--ink);font-weight:600}
.vi-eq math{display:block;margin:1px auto;text-align:center;font-size:13.5px}
.vi-eq .vi-wide{font-size:12px}
.vi-eq .vi-long{font-size:11.2px}
.vi-eq .vi-note{display:block}
@media (min-width:1600px){
  .vi-eqs{font-size:13px}
  .vi-eq math{font-size:16.5px}
  .vi-eq .vi-wide{font-size:15px}
  .vi-eq .vi-long{font-size:14px}
}
""".replace("PILL", str(PILL_BOTTOM))

CSS = (
    f':root{{{_variables(False)}}}:root[data-mantine-color-scheme="dark"]{{{_variables(True)}}}'
    + _font()
    + _PAGE
    + _DRAWINGS
    + _BOXES
)
