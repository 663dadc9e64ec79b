G21 G17 G40 G49 G80 G90 G94
G0 X0. Y0. Z0. B0. C0.
#<depth> = 5
#5=3.5
G1 X#<depth> F100
G0 X[1+2]
X5. Y0. Z0. B0. C0.
#5220=2
#4=5 #6=7
