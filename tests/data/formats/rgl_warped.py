"""Writes rgl_warped_rgb.bsdf, random tensors behind a warp, and what Mitsuba 3.9.1 (scalar_rgb) evaluates them to.

Run in this folder with mitsuba and numpy installed. Columns of the table: wi, wo (unit vectors), f cos(theta_o) of R, G, B.
"""
import struct
import numpy as np
import mitsuba as mi

mi.set_variant("scalar_rgb")
rng = np.random.default_rng(63)
P, T, N = 5, 4, 6
fields = {
    "description": np.frombuffer(b"random tensors behind a warp", np.uint8),
    "phi_i": np.linspace(-np.pi, np.pi, P, dtype=np.float32),
    "theta_i": np.radians(np.array([0.0, 25.0, 50.0, 85.0])).astype(np.float32),
    "ndf": rng.uniform(0.2, 2.0, (5, 7)).astype(np.float32),
    "sigma": rng.uniform(0.2, 0.6, (4, 5)).astype(np.float32),
    "vndf": rng.uniform(0.1, 1.0, (P, T, 6, 9)).astype(np.float32),
    "luminance": rng.uniform(0.1, 1.0, (P, T, N, N)).astype(np.float32),
    "rgb": rng.uniform(0.0, 1.0, (P, T, 3, N, N)).astype(np.float32),
    "jacobian": np.array([1], np.uint8),
}
head = 12 + 2 + 4 + sum(2 + len(n) + 2 + 1 + 8 + 8 * a.ndim for n, a in fields.items())
offset = -(-head // 8) * 8
out, data = b"tensor_file\0\x01\x00" + struct.pack("<I", len(fields)), b""
for name, array in fields.items():
    out += struct.pack("<H", len(name)) + name.encode() + struct.pack("<H", array.ndim)
    out += struct.pack("<BQ", 1 if array.dtype == np.uint8 else 10, offset + len(data))
    out += struct.pack(f"<{array.ndim}Q", *array.shape)
    data += array.tobytes() + b"\0" * (-array.nbytes % 8)
open("rgl_warped_rgb.bsdf", "wb").write(out.ljust(offset, b"\0") + data)

bsdf = mi.load_dict({"type": "measured", "filename": "rgl_warped_rgb.bsdf"})
with open("rgl_warped_expected.tsv", "w") as table:
    table.write("# f cos(theta_o) of rgl_warped_rgb.bsdf by Mitsuba 3.9.1, scalar_rgb; single precision\n")
    table.write("wi_x\twi_y\twi_z\two_x\two_y\two_z\tr\tg\tb\n")
    for _ in range(200):
        theta, phi = np.radians(rng.uniform([2, 2], [80, 84])), rng.uniform(-np.pi, np.pi, 2)
        wi, wo = (
            [float(np.sin(t) * np.cos(p)), float(np.sin(t) * np.sin(p)), float(np.cos(t))] for t, p in zip(theta, phi)
        )
        si = mi.SurfaceInteraction3f()
        si.wi = mi.Vector3f(wi)
        value = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(wo))
        table.write("\t".join(f"{v:.9g}" for v in [*wi, *wo, *np.array(value).ravel()]) + "\n")
