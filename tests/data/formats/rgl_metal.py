"""Writes rgl_metal_rgb.bsdf: GGX of roughness 0.08 with Smith's G2 and Fresnel factors 0.9, 0.7, 0.5, behind the warp of its visible normals.

Run in this folder; needs the standard library alone.
"""
import struct
from array import array
from math import cos, pi, radians, sin, sqrt

ALPHA, FRESNEL = 0.08, (0.9, 0.7, 0.5)
THETA_I = [0, 15, 30, 45, 60, 75]
ROWS, COLUMNS, N = 9, 48, 24


def theta_of(x):
    return x * x * pi / 2


def ndf(theta):
    return ALPHA**2 / (pi * (cos(theta) ** 2 * (ALPHA**2 - 1) + 1) ** 2)


def smith(c):
    return 0 if c <= 0 else (sqrt(1 + ALPHA**2 * (1 - c * c) / (c * c)) - 1) / 2


def half_dot(theta_i, x, y):
    """cos of incidence on the half vector at a place of the unit square, light at azimuth 0."""
    theta, phi = theta_of(x), 2 * pi * y - pi
    return sin(theta) * cos(phi) * sin(theta_i) + cos(theta) * cos(theta_i)


def place(u, n):
    k = min(int(u * (n - 1)), n - 2)
    return k, u * (n - 1) - k


class Warp:
    def __init__(self, table):
        self.table = table
        self.along = []
        for row in table:
            sums = [0.0]
            for a, b in zip(row, row[1:]):
                sums.append(sums[-1] + (a + b) / 2 / (COLUMNS - 1))
            self.along.append(sums)
        self.rows = [0.0]
        for a, b in zip(self.along, self.along[1:]):
            self.rows.append(self.rows[-1] + (a[-1] + b[-1]) / 2 / (ROWS - 1))

    def marginal(self, y):
        k, t = place(y, ROWS)
        a, b = self.along[k][-1], self.along[k + 1][-1]
        return (self.rows[k] + t * (a + t * (b - a) / 2) / (ROWS - 1)) / self.rows[-1]

    def conditional(self, y, x):
        (k, ty), (c, tx) = place(y, ROWS), place(x, COLUMNS)
        part = []
        for row in (k, k + 1):
            a, b = self.table[row][c], self.table[row][c + 1]
            part.append(self.along[row][c] + tx * (a + tx * (b - a) / 2) / (COLUMNS - 1))
        whole = (1 - ty) * self.along[k][-1] + ty * self.along[k + 1][-1]
        return ((1 - ty) * part[0] + ty * part[1]) / whole


def solve(function, value):
    low, high = 0.0, 1.0
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if function(middle) < value else (low, middle)
    return (low + high) / 2


unit = [k / (COLUMNS - 1) for k in range(COLUMNS)]
stored_ndf = [ndf(theta_of(x)) for x in unit]
vndf, rgb, luminance = [], [], []
for theta_deg in THETA_I:
    theta_i = radians(theta_deg)
    table = [
        [
            ndf(theta_of(x)) * max(half_dot(theta_i, x, k / (ROWS - 1)), 0) * sin(theta_of(x)) * x + 1e-7
            for x in unit
        ]
        for k in range(ROWS)
    ]
    warp = Warp(table)
    vndf += [v for row in table for v in row]
    values = []
    for j in range(N):
        y = solve(warp.marginal, j / (N - 1))
        for i in range(N):
            x = solve(lambda x: warp.conditional(y, x), i / (N - 1))
            cos_out = 2 * half_dot(theta_i, x, y) * cos(theta_of(x)) - cos(theta_i)
            g2 = 0 if cos_out <= 0 else 1 / (1 + smith(cos(theta_i)) + smith(cos_out))
            k, t = place(x, COLUMNS)
            d = (1 - t) * stored_ndf[k] + t * stored_ndf[k + 1]
            # f cos(theta_o) / (ndf / (4 sigma)), sigma = 1/4.
            values.append(ndf(theta_of(x)) * g2 / (4 * cos(theta_i)) / d)
    luminance += values
    for f in FRESNEL:
        rgb += [f * v for v in values]

fields = {
    "description": (b"GGX 0.08 behind the warp of its visible normals", None),
    "phi_i": ([0.0], (1,)),
    "theta_i": ([radians(t) for t in THETA_I], (len(THETA_I),)),
    "ndf": (stored_ndf * 2, (2, COLUMNS)),
    "sigma": ([0.25] * 4, (2, 2)),
    "vndf": (vndf, (1, len(THETA_I), ROWS, COLUMNS)),
    "luminance": (luminance, (1, len(THETA_I), N, N)),
    "rgb": (rgb, (1, len(THETA_I), 3, N, N)),
    "jacobian": (b"\1", None),
}
shapes = {name: shape or (len(data),) for name, (data, shape) in fields.items()}
head = 12 + 2 + 4 + sum(2 + len(n) + 2 + 1 + 8 + 8 * len(s) for n, s in shapes.items())
offset = -(-head // 8) * 8
out, tail = b"tensor_file\0\x01\x00" + struct.pack("<I", len(fields)), b""
for name, (data, shape) in fields.items():
    out += struct.pack("<H", len(name)) + name.encode() + struct.pack("<H", len(shapes[name]))
    out += struct.pack("<BQ", 10 if shape else 1, offset + len(tail))
    out += struct.pack(f"<{len(shapes[name])}Q", *shapes[name])
    data = array("f", data).tobytes() if shape else data
    tail += data + b"\0" * (-len(data) % 8)
open("rgl_metal_rgb.bsdf", "wb").write(out.ljust(offset, b"\0") + tail)
