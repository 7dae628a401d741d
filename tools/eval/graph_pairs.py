#!/usr/bin/env python3
"""Graph to graph: `hggmap align` on halves of scans, as the paper's alignment table does it.

Each scan of SCANS (a folder of JSON files with "scene" and "objects", see docs/language.md) with twelve objects or more is cut in two
halves that overlap: its objects are sorted along a random direction, the first half is the objects up to a place, the second those from
another place on, so that 40 to 80 % of each are in both. The second half is turned about the vertical and shifted at random (maps are
upright), its boxes are jittered by 5 cm, faces and middles, and 27 % of its labels are replaced by a near class: another one of its
group in NEAR, a table of what people call alike things; "object" where the table does not know the label. Both are imported
(`hggmap import`) and aligned without any hint. Second halves of scans of other places are tried too: none may be accepted.

  tools/eval/graph_pairs.py SCANS --hggmap build/hggmap [--seeds 2] [--others 4] [--every K] [--axis-boxes] [--json F] [--show N]

Right: T_a_b puts the middle of the second half within 0.3 m and 5 degrees of the truth. Correspondences are counted over all pairs of
one scan, accepted or not. Exit 0: the bounds hold; 1: they do not. Standard library only.
"""
import argparse
import collections
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

LEAST_OBJECTS = 12
OVERLAP = (0.4, 0.8)  # share of each half's objects that are in the other
JITTER = 0.05  # m, standard deviation of the middle and of each edge
RENAMED = 0.27
MAX_ERROR, MAX_TURN = 0.3, 5.0  # m, deg
PAPER_F1, MIN_RIGHT = 0.568, 0.95

NEAR = [  # what people call alike; a label is in one group
    "chair, office chair, armchair, sofa chair, folded chair, stool, seat, bench",
    "couch, ottoman, beanbag chair, futon, loveseat",
    "table, desk, coffee table, end table, round table, dining table, side table, card table, ping pong table",
    "cabinet, kitchen cabinet, kitchen cabinets, cabinets, file cabinet, dresser, nightstand, wardrobe, wardrobe closet, wardrobe cabinet, "
    "bathroom cabinet, drawer, cupboard, tv stand, bathroom vanity, closet, lockers",
    "counter, kitchen counter, bathroom counter, kitchen island, bar, breakfast bar, ledge",
    "shelf, bookshelf, bookshelves, rack, dish rack, shoe rack, coat rack, storage shelf, storage organizer, closet shelf",
    "trash can, recycling bin, trash bin, bin, bucket, laundry basket, laundry hamper, basket, compost bin",
    "box, storage bin, container, storage container, case, tissue box, carton, crate, storage box",
    "bag, backpack, suitcase, purse, luggage, paper bag, handbag, duffel bag, briefcase",
    "window, windowsill, blinds, blind",
    "curtain, shower curtain, curtains",
    "door, doorframe, doors, closet door, closet doors, bathroom stall door, sliding door, shower door",
    "wall, closet wall, shower wall, shower walls, divider, bathroom stall, partition",
    "floor, mat, carpet, rug, shower floor, bath mat",
    "ceiling, ceiling light, ceiling fan, light, lamp, desk lamp, table lamp",
    "picture, painting, poster, sign, decoration, photo, calendar, map",
    "whiteboard, board, blackboard, bulletin board",
    "monitor, tv, laptop, screen, projector screen, computer monitor",
    "computer tower, printer, copier, projector, server",
    "books, book, paper, papers, magazine, folder, binder, notepad",
    "pillow, blanket, cushion, pillows, couch cushions, mattress",
    "clothes, clothing, jacket, towel, coat, shirt, towels, laundry, hat",
    "shoes, shoe, boots, slippers, sandals",
    "sink, bathtub, toilet, shower, urinal",
    "cup, bottle, bowl, plate, mug, glass, water bottle, vase, plates, cups",
    "microwave, oven, stove, toaster, toaster oven, coffee maker, dishwasher, coffee kettle, range hood",
    "refrigerator, mini fridge, washing machine, washing machines, clothes dryer, clothes dryers, vending machine, water cooler",
    "toilet paper, paper towel roll, toilet paper roll, paper towel rolls, tissue",
    "paper towel dispenser, soap dispenser, toilet paper dispenser, toilet seat cover dispenser, hand dryer, soap dish, towel rack",
    "keyboard, mouse, telephone, remote, headphones, speaker",
    "rail, bar, pipe, shower curtain rod, closet rod, handrail, tube, rod, railing",
    "radiator, fan, heater, air conditioner, vent, space heater",
    "plant, plants, potted plant, flowerpot, flower",
    "mirror, clock, bathroom mirror",
]


def near_classes():
    """Label -> the others of its group."""
    near = {}
    for group in NEAR:
        labels = [label.strip() for label in group.split(",")]
        for label in labels:
            near.setdefault(label, [other for other in labels if other != label])
    return near


def halves(objects, draw):
    """Two lists of objects that overlap, cut across a random direction."""
    angle, share = draw.uniform(-math.pi, math.pi), draw.uniform(*OVERLAP)
    along = sorted(objects, key=lambda o: o["center"][0] * math.cos(angle) + o["center"][1] * math.sin(angle))
    size = min(len(along) - 1, max(2, round(len(along) / (2 - share))))
    return along[:size], along[len(along) - size:]


def turned(p, yaw):
    c, s = math.cos(yaw), math.sin(yaw)
    return [c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]]


class Move:
    """A turn about the vertical and a shift."""

    def __init__(self, draw):
        self.yaw, self.shift = draw.uniform(-math.pi, math.pi), [draw.uniform(-20, 20), draw.uniform(-20, 20), draw.uniform(-2, 2)]

    def __call__(self, p):
        return [a + b for a, b in zip(turned(p, self.yaw), self.shift)]

    def back(self, p):
        return turned([a - b for a, b in zip(p, self.shift)], -self.yaw)


def disturbed(objects, move, near, draw, axis_boxes):
    """The objects moved, jittered, and some of them under another name."""
    renamed = set(draw.sample(range(len(objects)), round(RENAMED * len(objects))))
    result = []
    for k, o in enumerate(objects):
        label = draw.choice(near.get(o["label"], ["object"])) if k in renamed else o["label"]
        size = [max(0.02, s + draw.gauss(0, JITTER)) for s in o["size"]]
        box = {"id": o["id"], "label": label, "center": move([v + draw.gauss(0, JITTER) for v in o["center"]]), "size": size, "yaw": move.yaw}
        if axis_boxes:  # as a tool that knows no yaw would write it
            c, s = abs(math.cos(move.yaw)), abs(math.sin(move.yaw))
            box["size"], box["yaw"] = [c * size[0] + s * size[1], s * size[0] + c * size[1], size[2]], 0
        result.append(box)
    return result


def plain(objects):
    return [{key: o[key] for key in ("id", "label", "center", "size")} for o in objects]


def run(hggmap, folder, name, objects):
    graph, out = folder / f"{name}.json", folder / f"{name}.hgg"
    graph.write_text(json.dumps({"objects": objects}))
    subprocess.run([hggmap, "import", str(graph), "-o", str(out)], check=True, stdout=subprocess.DEVNULL)
    return out


def align(hggmap, a, b):
    done = subprocess.run([hggmap, "align", str(a), str(b), "--json"], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(f"hggmap align: {done.stderr.strip()}")
    return json.loads(done.stdout)


def error_of(answer, move, second):
    """Metres at the middle of the second half and degrees between the answer and the truth."""
    rows = [answer["T_a_b"][4 * k:4 * k + 4] for k in range(3)]
    middle = [sum(o["center"][k] for o in second) / len(second) for k in range(3)]
    p = move(middle)
    found = [sum(row[k] * p[k] for k in range(3)) + row[3] for row in rows]
    c, s = math.cos(-move.yaw), math.sin(-move.yaw)
    true = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
    trace = sum(rows[i][k] * true[i][k] for i in range(3) for k in range(3))
    return math.dist(found, middle), math.degrees(math.acos(max(-1.0, min(1.0, (trace - 1) / 2))))


def judge(answer, move, first, second):
    """One row: a pair of halves of one scan."""
    error, turn = error_of(answer, move, second)
    common = {o["id"] for o in first} & {o["id"] for o in second}
    good = sum(i == j for i, j in answer["pairs"])
    return {"accepted": answer["accepted"], "right": error <= MAX_ERROR and turn <= MAX_TURN, "error": error, "turn": turn, "good": good,
            "answered": len(answer["pairs"]), "common": len(common), "share": len(common) / len(second), "reason": answer["reason"],
            "score": answer["score"], "threshold": answer["threshold"], "evidence": answer["evidence"], "ms": answer["ms"]}


def figures(rows):
    good, answered, common = (sum(r[k] for r in rows) for k in ("good", "answered", "common"))
    precision, recall = good / max(answered, 1), good / max(common, 1)
    return {"pairs": len(rows), "accepted": sum(r["accepted"] for r in rows), "accepted_right": sum(r["accepted"] and r["right"] for r in rows),
            "best_right": sum(r["right"] for r in rows), "precision": precision, "recall": recall,
            "f1": 2 * precision * recall / max(precision + recall, 1e-9)}


def told(name, f):
    print(f"{name:18} pairs {f['pairs']:4}  accepted {f['accepted']:4}, right {f['accepted_right']:4}  best place right {f['best_right']:4}  "
          f"precision {f['precision']:.3f}  recall {f['recall']:.3f}  F1 {f['f1']:.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scans", type=pathlib.Path)
    parser.add_argument("--hggmap", required=True)
    parser.add_argument("--seeds", type=int, default=2, help="cuts of each scan [2]")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--others", type=int, default=4, help="halves of other places that each first half is held against [4]")
    parser.add_argument("--every", type=int, default=1, help="take every so many-th scan [1]")
    parser.add_argument("--axis-boxes", action="store_true", help="the second half's boxes along the axes of its frame, as large as they must be")
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--show", type=int, default=0, help="print so many pairs that went wrong")
    options = parser.parse_args()
    near = near_classes()
    scans = [json.loads(p.read_text()) for p in sorted(options.scans.glob("*.json"))]
    scans = [s for s in scans if len(s["objects"]) >= LEAST_OBJECTS][::options.every]
    place = lambda scan: scan["scene"].rsplit("_", 1)[0]  # scans of one place differ in the number at the end
    rows, strangers = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for seed in range(options.first_seed, options.first_seed + options.seeds):
            cuts = []
            for k, scan in enumerate(scans):
                draw = random.Random(f"{scan['scene']} {seed}")
                first, second = halves(scan["objects"], draw)
                move = Move(draw)
                a = run(options.hggmap, folder, f"a{k}", plain(first))
                b = run(options.hggmap, folder, f"b{k}", disturbed(second, move, near, draw, options.axis_boxes))
                cuts.append((scan, a, b))
                rows.append({"scene": scan["scene"], **judge(align(options.hggmap, a, b), move, first, second)})
            draw = random.Random(seed)
            for scan, a, _ in cuts:
                others = [c for c in cuts if place(c[0]) != place(scan)]
                for other, _, b in draw.sample(others, min(options.others, len(others))):
                    answer = align(options.hggmap, a, b)
                    strangers.append({"scene": scan["scene"], "other": other["scene"], **{k: answer[k] for k in ("accepted", "score", "threshold", "reason", "evidence")}})
    told("all", figures(rows))
    for low in (0.4, 0.5, 0.6, 0.7):
        of = [r for r in rows if low <= r["share"] < low + 0.1 or (low == 0.4 and r["share"] < 0.4) or (low == 0.7 and r["share"] >= 0.8)]
        if of:
            told(f"overlap {low:.1f} .. {low + 0.1:.1f}", figures(of))
    told("accepted", figures([r for r in rows if r["accepted"]]))
    wrong = [s for s in strangers if s["accepted"]]
    print(f"different places: {len(wrong)} of {len(strangers)} accepted; nearest to it {max((s['score'] - s['threshold'] for s in strangers if not s['accepted']), default=0):.1f} nats over the threshold")
    reasons = collections.Counter(r["reason"].split(":")[0] for r in rows if not r["accepted"])
    print("refused:", dict(reasons))
    for s in wrong[:options.show]:
        print(f"  stranger {s['scene']} {s['other']}: score {s['score']:.1f} of {s['threshold']:.1f}, {s['evidence']}")
    for r in [r for r in rows if r["accepted"] and not r["right"]][:options.show]:
        print(f"  accepted wrongly {r['scene']}: {r['error']:.2f} m {r['turn']:.1f} deg, {r['score']:.1f} of {r['threshold']:.1f}, {r['evidence']}")
    for r in [r for r in rows if not r["accepted"]][:options.show]:
        print(f"  refused {r['scene']}: {'right' if r['right'] else 'wrong'} {r['error']:.2f} m, {r['common']} common, {r['score']:.1f} of {r['threshold']:.1f}: {r['reason']}")
    everything = figures(rows)
    if options.json:
        options.json.write_text(json.dumps({"figures": everything, "pairs": rows, "strangers": strangers}, indent=1) + "\n")
    holds = everything["f1"] >= PAPER_F1 and everything["accepted_right"] >= MIN_RIGHT * everything["accepted"] > 0 and not wrong
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
