G21 G17 G40 G49 G80 G90 G94
G0 X0. Y0. Z0. B0. C0.
G1 X5. F100
o<probe> call [5] [#1]
G90 G1 X6. Y0. Z0. B0. C0.
o200 if [#1 gt 0]
X7.
o200 endif
X8. Y0. Z0. B0. C0.
