(listing)
G90 G1 X10. Y0. Z0. B0. C0. F500
X20.
