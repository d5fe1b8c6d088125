"""What ezdxf 1.4.5 and scipy read in DXF entities: writes texts.jsonl, entities.jsonl and fit_splines.jsonl.

    pip install ezdxf scipy && python reference.py

texts.jsonl: the letters that the codes of TEXT and MTEXT stand for. entities.jsonl: entities with extrusions, inserts
and directions, with their length and their box as seen from above. fit_splines.jsonl: splines through fit points with
directions at their ends; ezdxf and scipy must agree.
"""

import json
import pathlib
import random

import ezdxf
import numpy as np
from ezdxf.lldxf.encoding import decode_dxf_unicode, decode_mif_to_unicode
from ezdxf.lldxf.tagwriter import TagCollector
from ezdxf.math import OCS, Vec3, fit_points_to_cad_cv
from ezdxf.path import make_path
from ezdxf.tools.text import plain_mtext, plain_text
from scipy.interpolate import CubicSpline

HERE = pathlib.Path(__file__).parent


def write(name, rows):
    text = "".join(json.dumps(row) + "\n" for row in rows)
    (HERE / name).write_text(text)


# Letters.
LINES = [
    "PLATE", "  two before", "two after  ", "a  b", "R\\U+00D85", "\\U+0141\\U+00f3d\\U+017A", "x\\U+00", "x\\U+00G1", "\\u+00D8",
    "\\M+18140A", "\\M+1838Fx", "\\M+5A1E3", "\\M+2A158", "\\M+3A1C6", "\\M+9A1E3", "%%c8", "%%C8%%D%%P0.1", "45%%d", "5%%%",
    "100%", "%", "%%q7", "%%uunder%%u", "%%Oover%%o", "%%kthrough", "C:\\Parts", "a\\Pb", "{a}", "a^ b", "a;b",
]
PARAGRAPHS = [
    "PLATE", "A\\: B", "  two before", "two after  ", "a\\Pb\\P\\Pc", "\\U+00D8 5", "R\\U+00D85", "\\M+18140", "\\M+1838Fx",
    "{\\fArial|b0|i0|c0|p34;Plate} 7", "\\H2.5x;big", "\\H3;big", "\\H3big", "\\H.5x;x", "\\A1;middle", "\\A1middle", "\\C1;red", "\\C1red",
    "\\c255;x", "\\W0.8;x", "\\Q15;x", "\\Q-15;x", "\\T1.2;x", "\\pxqc;centred", "\\pi1,t[5,20];x", "\\Lunder\\l not", "\\Oover\\o\\Kx\\k", "a\\~b",
    "C:\\\\x", "\\{1\\}", "a\\;b", "\\Zq;r", "\\5", "\\ a", "{a{b}c}", "}a{", "%%c8 %%d %%p", "5%%%", "%%q", "a^ b", "a^Jb",
    "\\S1/2;", "a\\S1/2;b", "\\fArial", "\\F;x", "a\\U+2205b",
]
rows = []
for raw in LINES:
    rows.append({"kind": "TEXT", "raw": raw, "plain": plain_text(decode_mif_to_unicode(decode_dxf_unicode(raw)))})
for raw in PARAGRAPHS:
    plain = plain_mtext(decode_mif_to_unicode(decode_dxf_unicode(raw)), split=False)
    rows.append({"kind": "MTEXT", "raw": raw, "plain": plain})
write("texts.jsonl", rows)


# Entities.
def tags(entity):
    """The tags that place an entity, as `code value` pairs."""
    pairs = TagCollector.dxftags(entity)
    return " ".join(f"{tag.code} {tag.value}" for tag in pairs if tag.code < 300 and tag.code not in (5, 100, 48, 7))


def seen(points):
    xy = np.array([(p.x, p.y) for p in points])
    return float(np.hypot(*np.diff(xy, axis=0).T).sum()), xy


def curves(entity):
    """Polylines of an entity, of those in its block where it is an insert."""
    if entity.dxftype() == "INSERT":
        for one in entity.multi_insert() if entity.mcount > 1 else [entity]:
            for inner in one.virtual_entities():
                yield from curves(inner)
    else:
        for path in make_path(entity, segments=16).sub_paths():
            yield list(path.flattening(1e-6, segments=64))


def row(name, entity, blocks=""):
    parts = [seen(points) for points in curves(entity)]
    xy = np.concatenate([xy for _, xy in parts])
    return {
        "name": name,
        "blocks": blocks,
        "entities": tags(entity),
        "length": sum(length for length, _ in parts),
        "box": [*xy.min(axis=0), *xy.max(axis=0)],
    }


doc = ezdxf.new("R2000")
model = doc.modelspace()
chance = random.Random(7)
normals = [(0, 0, -1), (0, 0.6, 0.8), (0.6, 0, 0.8), (0.3, -0.4, 0.5), (0.01, 0.01, 1), (0.016, 0, 1), (-0.5, 0.2, -0.7), (0, 0, 2.5)]
rows = []
for k, normal in enumerate(normals):
    at = {"extrusion": normal}
    height = chance.uniform(-9, 9)
    place = (chance.uniform(-20, 20), chance.uniform(-20, 20), height)
    bulged = [(0, 0, 0.4), (10, 2, 0), (7, 9, -0.7), (1, 5, 0)]
    rows += [
        row(f"circle {k}", model.add_circle(place, 5, dxfattribs=at)),
        row(f"arc {k}", model.add_arc(place, 4, 200, 20, dxfattribs=at)),
        row(f"lwpolyline {k}", model.add_lwpolyline(bulged, format="xyb", close=True, dxfattribs={**at, "elevation": height})),
        row(f"line {k}", model.add_line(place, (1, 2, 3), dxfattribs=at)),
        row(f"ellipse {k}", model.add_ellipse(place, OCS(normal).uy * 5 if k % 2 else OCS(normal).ux * 6, 0.4, 0.3, 4, dxfattribs=at)),
    ]
    polyline = model.add_polyline2d([(x, y, 0, 0, b) for x, y, b in bulged], format="xyseb", dxfattribs={**at, "elevation": (0, 0, height)})
    rows.append(row(f"polyline {k}", polyline))
    entities = " ".join(tags(vertex) for vertex in polyline.vertices)
    rows[-1]["entities"] = f"{tags(polyline)} {entities} 0 SEQEND"
points = [(0, 0, 0), (5, 3, 8), (9, -2, 4)]
in_space = model.add_polyline3d(points, close=True)
rows.append(row("polyline in space", in_space))
rows[-1]["entities"] = f"{tags(in_space)} {' '.join(tags(v) for v in in_space.vertices)} 0 SEQEND"
spline = model.add_open_spline([(0, 0, 0), (5, 9, 3), (9, -5, 6), (14, 4, 1), (20, 0, 9)])
rows.append(row("spline in space", spline))

block = doc.blocks.new("PART", base_point=(1, 2, 3))
inner = doc.blocks.new("INNER")
inner.add_circle((2, 1, 4), 3, dxfattribs={"extrusion": (0.2, 0.3, 0.9)})
inner.add_line((0, 0, 0), (4, 5, 6))
block.add_lwpolyline([(0, 0, 0.5), (8, 0, 0), (8, 6, 0)], format="xyb", dxfattribs={"elevation": 2})
block.add_arc((3, 3, 1), 2, 30, 250, dxfattribs={"extrusion": (0, 0, -1)})
block.add_ellipse((5, 2, 1), (3, 1, 0), 0.5, 0.2, 3)
block.add_blockref("INNER", (2, 3, 1), dxfattribs={"rotation": 25, "extrusion": (0, 0.6, 0.8)})
text = " ".join(
    f"0 BLOCK 2 {b.name} 10 {b.block.dxf.base_point.x} 20 {b.block.dxf.base_point.y} 30 {b.block.dxf.base_point.z} "
    f"{' '.join(tags(e) for e in b)} 0 ENDBLK"
    for b in (inner, block)
)
for k, normal in enumerate(normals):
    at = {"extrusion": normal, "rotation": chance.uniform(0, 360), "xscale": 1.5, "yscale": 1.5, "zscale": 1.5}
    if k % 2 == 0:
        at |= {"column_count": 2, "row_count": 3, "column_spacing": 11, "row_spacing": 7}
    insert = model.add_blockref("PART", (chance.uniform(-9, 9), 4, chance.uniform(-9, 9)), dxfattribs=at)
    rows.append(row(f"insert {k}", insert, text))
mirrored = {"xscale": -2, "yscale": 2, "zscale": 2, "rotation": 20}
rows.append(row("mirrored insert", model.add_blockref("PART", (5, 5), dxfattribs=mirrored), text))

# Texts: the corners of an H of Hershey's simplex, whose stems are 4 and 18 units of 21 from the left.
for k, normal in enumerate(normals):
    turn, height = chance.uniform(0, 360), 7.0
    label = model.add_text("H", height=height, rotation=turn, dxfattribs={"insert": (3, 4, 5), "extrusion": normal})
    right = Vec3.from_deg_angle(turn)
    ocs = label.ocs()
    corners = [
        ocs.to_wcs(Vec3(3, 4, 5) + right * (x * height / 21) + right.orthogonal() * (y * height / 21)) for x in (4, 18) for y in (0, 21)
    ]
    _, xy = seen(corners)
    rows.append({"name": f"text {k}", "blocks": "", "entities": tags(label), "box": [*xy.min(axis=0), *xy.max(axis=0)]})
    for direction in ({"rotation": turn}, {"text_direction": OCS(normal).to_wcs(Vec3.from_deg_angle(turn))}):
        attributes = {"insert": (3, 4, 5), "char_height": height, "attachment_point": 7, "extrusion": normal, **direction}
        paragraphs = model.add_mtext("H", dxfattribs=attributes)
        ucs = paragraphs.ucs()
        corners = [ucs.to_wcs(Vec3(x * height / 21, y * height / 21)) for x in (4, 18) for y in (0, 21)]
        _, xy = seen(corners)
        kind = next(iter(direction))
        rows.append({"name": f"mtext {kind} {k}", "blocks": "", "entities": tags(paragraphs), "box": [*xy.min(axis=0), *xy.max(axis=0)]})
write("entities.jsonl", rows)

# Splines through fit points.
rows = []
FITS = {
    "report": ([(0, 0), (10, 20), (20, 0), (30, 20)], (1, 0), (1, 0)),
    "two points": ([(0, 0), (10, 5)], (0, 1), (0, 1)),
    "not of length 1": ([(0, 0), (4, 7), (9, 3), (15, 9), (17, 2)], (3, 4), (-5, 1)),
    "natural": ([(0, 0), (10, 20), (20, 0), (30, 20)], None, None),
    "start": ([(0, 0), (10, 20), (20, 0), (30, 20)], (1, 0), None),
}
for name, (fits, start, end) in FITS.items():
    fits = np.array(fits, float)
    chords = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(fits, axis=0).T))])
    side = lambda tangent: (2, np.zeros(2)) if tangent is None else (1, np.array(tangent) / np.hypot(*tangent))
    spline = CubicSpline(chords, fits, bc_type=(side(start), side(end)))
    fine = spline(np.linspace(0, chords[-1], 200_001))
    length = float(np.hypot(*np.diff(fine, axis=0).T).sum())
    if (start is None) == (end is None):
        tangents = None if start is None else [Vec3(start), Vec3(end)]
        other = list(fit_points_to_cad_cv([Vec3(p) for p in fits], tangents).flattening(1e-5, segments=400))
        difference = abs(seen(other)[0] - length)
        assert difference < 2e-3 * length, (name, difference, length)
        print(name, length, "ezdxf", seen(other)[0])
    said = " ".join(f"11 {x} 21 {y}" for x, y in fits)
    ends = "".join(f" {code} {t[0]} {code + 10} {t[1]}" for code, t in ((12, start), (13, end)) if t)
    middle = spline(chords[-1] / 2)
    rows.append({"name": name, "entities": f"0 SPLINE 70 0 71 3{ends} {said}", "length": length, "middle": [*middle]})
ring = np.array([(0, 0), (20, 1), (23, 9), (4, 14), (2, 13), (0, 0)], float)
chords = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(ring, axis=0).T))])
spline = CubicSpline(chords, ring, bc_type="periodic")
fine = spline(np.linspace(0, chords[-1], 200_001))
said = " ".join(f"11 {x} 21 {y}" for x, y in ring[:-1])
rows.append({
    "name": "closed",
    "entities": f"0 SPLINE 70 1 71 3 {said}",
    "length": float(np.hypot(*np.diff(fine, axis=0).T).sum()),
    "middle": [*spline(chords[-1] / 2)],
})
write("fit_splines.jsonl", rows)
