%
O1234 (PART)
N10 G21 G90
N20 G1 X10. Y0. Z0. B0. C0. F500
M30
%
rest of the file G1 X5
