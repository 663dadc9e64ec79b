G21 G17 G40 G49 G80 G90 G94
G0 X0. Y0. Z0. B0. C0.
G1 X5. F100;
X6.; (end)
X7.;Y5.
X8. ; rough pass
