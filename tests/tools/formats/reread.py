#!/usr/bin/python3
"""Reads an exported file with a reader that others wrote, and compares it with the session's mesh.

    reread.py MESH.PLY FILE

Ends with 0 if they agree, 1 and the difference if not, 77 if the reader is not installed.
"""

import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
import zipfile


def fail(why):
    print(why)
    sys.exit(1)


def skip(why):
    print("skipped: " + why)
    sys.exit(77)


def read_ply(name):
    with open(name) as file:
        lines = file.read().split("\n")
    count = {w[1]: int(w[2]) for w in (line.split() for line in lines) if w[:1] == ["element"]}
    body = lines[lines.index("end_header") + 1 :]
    points = [tuple(map(float, line.split()[:3])) for line in body[: count["vertex"]]]
    faces = [tuple(map(int, line.split()[1:4])) for line in body[count["vertex"] : count["vertex"] + count["face"]]]
    return points, faces


def triangles_by_assimp(name):
    if not shutil.which("assimp"):
        skip("no assimp here")
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out")
        told = subprocess.run(["assimp", "export", name, out, "-fassjson"], capture_output=True, text=True)
        if told.returncode or not os.path.exists(out):
            fail("assimp does not read it: " + told.stdout + told.stderr)
        with open(out) as file:
            scene = json.load(file)
    triangles = []
    for mesh in scene["meshes"]:
        flat = mesh["vertices"]
        corner = lambda k: tuple(flat[3 * k : 3 * k + 3])
        triangles += [tuple(corner(k) for k in face) for face in mesh["faces"]]
    return triangles


def triangles_of_vtp(name):
    arrays = {array.get("Name"): array.text.split() for array in ElementTree.parse(name).getroot().iter("DataArray")}
    numbers = list(map(float, arrays["Points"]))
    points = [tuple(numbers[k : k + 3]) for k in range(0, len(numbers), 3)]
    corners = list(map(int, arrays["connectivity"]))
    if list(map(int, arrays["offsets"])) != list(range(3, len(corners) + 1, 3)):
        fail("offsets are not those of triangles")
    if len(arrays["Normals"]) != len(numbers):
        fail("not a normal for every point")
    return [tuple(points[c] for c in corners[k : k + 3]) for k in range(0, len(corners), 3)]


def triangles_of_3mf(name):
    """assimp 5.2 ends with a segmentation fault on what lib3mf writes, so by what the format says."""
    space = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
    with zipfile.ZipFile(name) as archive:
        relations = ElementTree.fromstring(archive.read("_rels/.rels"))
        targets = [r.get("Target").lstrip("/") for r in relations if r.get("Type").endswith("/3dmodel")]
        model = ElementTree.fromstring(archive.read(targets[0]))
    if model.tag != space + "model" or model.get("unit") != "millimeter":
        fail("no model in millimetres")
    built = [item.get("objectid") for item in model.iter(space + "item")]
    objects = [o for o in model.iter(space + "object") if o.get("id") in built]
    if len(objects) != 1:
        fail("%d objects are built, not one" % len(objects))
    points = [tuple(float(v.get(k)) for k in "xyz") for v in objects[0].iter(space + "vertex")]
    return [tuple(points[int(t.get(k))] for k in ("v1", "v2", "v3")) for t in objects[0].iter(space + "triangle")]


def compare_triangles(found, points, faces):
    if len(found) != len(faces):
        fail("%d triangles, not %d" % (len(found), len(faces)))
    doubt = 1e-5 * max(abs(x) for p in points for x in p)  # six digits, as assimp says them
    for triangle, face in zip(found, faces):
        for p, corner in zip(triangle, face):
            if math.dist(p, points[corner]) > doubt:
                fail("a corner is at %s, not at %s" % (p, points[corner]))


def area(points):
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(points, points[1:] + points[:1])) / 2


def compare_sections(name, points, faces):
    try:
        import ezdxf
    except ImportError:
        skip("no ezdxf here")
    lines = list(ezdxf.readfile(name).modelspace().query("POLYLINE"))
    if not lines:
        fail("no polylines")
    for z in sorted({line.dxf.elevation.z for line in lines}):
        loops = [line for line in lines if line.dxf.elevation.z == z]
        if not all(line.is_closed for line in loops):
            fail("an open outline of a closed mesh")
        found = sum(area([(p.x, p.y) for p in line.points()]) for line in loops)
        # Green's theorem, triangle by triangle.
        expected = 0.0
        for face in faces:
            ends = []
            for a, b in ((points[face[k]], points[face[(k + 1) % 3]]) for k in range(3)):
                if (a[2] > z) != (b[2] > z):
                    share = (z - a[2]) / (b[2] - a[2])
                    ends.append((a[2] > z, a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])))
            if ends:
                down, up = sorted(ends, reverse=True)
                expected += (down[1] * up[2] - down[2] * up[1]) / 2
        if abs(found - expected) > 1e-9 * (1 + abs(expected)) or expected <= 0:
            fail("at %g an area of %g, not %g" % (z, found, expected))


def main():
    points, faces = read_ply(sys.argv[1])
    name = sys.argv[2]
    kind = os.path.splitext(name)[1]
    if kind == ".dxf":
        compare_sections(name, points, faces)
    elif kind == ".vtp":
        compare_triangles(triangles_of_vtp(name), points, faces)
    elif kind == ".3mf":
        compare_triangles(triangles_of_3mf(name), points, faces)
    else:
        compare_triangles(triangles_by_assimp(name), points, faces)


main()
