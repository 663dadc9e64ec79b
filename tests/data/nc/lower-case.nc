g21 g90 g0 x0. y0. z0. b0. c0.
n10 g1 x1. f100 (Lower)
b90.
o5
