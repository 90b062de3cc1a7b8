"""Colours, lines and words that the figures share: Okabe and Ito's colours, each role with a line of its own too."""

LEARNER, DEMONSTRATOR, RECOVERED, RESIDUAL = "#0072b2", "#8a5a00", "#007f5c", "#d55e00"
MARK = {"marker": "D", "color": "#e69f00", "markeredgecolor": DEMONSTRATOR, "linestyle": "none"}
DASHED = (0, (5, 4))
LAWS = {
    "gradient": ("the paper's law", RESIDUAL),
    "gradient-retuned": ("the paper's law, retuned", LEARNER),
    "broyden": ("broyden", RECOVERED),
    "trust-region": ("trust-region", "#b0508a"),
}
TRANSFERS = {
    "epipolar": ("epipolar (the paper)", LEARNER),
    "linear": ("linear combination", RECOVERED),
    "rank3": ("rank 3", "#b0508a"),
    "projective": ("projective combination", RESIDUAL),
}
STYLE = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#dde1e7",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "savefig.dpi": 150,
    "svg.hashsalt": "viewimit",  # the same file from the same data
}


def angle_name(joint: int) -> str:
    return f"$\\theta_{joint}$"


def in_degrees(theta_deg) -> str:
    return "(" + ", ".join(f"{angle:.1f}°" for angle in theta_deg).replace("-", "−") + ")"
