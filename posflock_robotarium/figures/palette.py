"""The colours of every figure: Okabe and Ito's palette, safe for colour-blind readers."""

BLUE, ORANGE, GREEN, BLACK, GREY = "#0072B2", "#D55E00", "#009E73", "#000000", "#8c8c8c"
