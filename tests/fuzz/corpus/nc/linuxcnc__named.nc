#<x>=5
#<_depth> = -2.5
G0 X0 Y0 Z0 B0 C0
G1 X#<x> F100
G1 X3 Y0 Z0 B0 C0
