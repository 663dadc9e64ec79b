G21 G17 G40 G49 G80 G90 G94
G0 X0. Y0. Z0. B0. C0.
/G1 X5. F100
X6. Y0. Z0. B0. C0.
/1 G91
X1.
/
/ 2 X5.
N5 /X5.
/(only a comment)
/M8
X7. Y0. Z0. B0. C0.
