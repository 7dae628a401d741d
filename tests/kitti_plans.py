"""Plans over the map of kitti_0001: one along the road it was driven on, and 200 between random places on walkable ground, none of which
may lead through an annotated parked car. Standard library only.
usage: tests/kitti_plans.py HGGMAP MAP.hgg CONFIG BOXES.csv TRAJECTORY.tum OUT_DIR     exit 1: a plan is missing or leads through a car"""
import array
import csv
import json
import math
import random
import subprocess
import sys
from pathlib import Path

PAIRS, NEAR_WAY = 200, 10.0  # m: places are drawn this near to the way
STRIDE = 0.05  # m, between the places of a path that are tested


def cars_of(path):
    """(x, y, half length, half width, yaw) of each parked car, the mean of its boxes in the world."""
    boxes = {}
    for row in csv.DictReader(open(path)):
        if row["type"] == "Car":
            boxes.setdefault(row["track_id"], []).append(row)
    cars = []
    for rows in boxes.values():
        nearest = min(rows, key=lambda r: math.hypot(float(r["cx_velo"]), float(r["cy_velo"])))
        cars.append((float(nearest["cx_world"]), float(nearest["cy_world"]), float(nearest["l"]) / 2, float(nearest["w"]) / 2,
                     float(nearest["yaw_velo"]), int(nearest["frame"])))
    return cars


def yaw_of(pose):
    x, y, z, w = pose[4:8]
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def depth_inside(car, x, y):
    """How deep a place lies inside a car's outline, m; negative: outside."""
    dx, dy, c, s = x - car[0], y - car[1], math.cos(car[4]), math.sin(car[4])
    return min(car[2] - abs(c * dx + s * dy), car[3] - abs(c * dy - s * dx))


def layer(meta, folder, name, kind):
    data = (folder / meta["layers"][name]["file"]).read_bytes()
    values = array.array(kind)
    values.frombytes(data[len(data) - meta["levels"] * meta["height"] * meta["width"] * values.itemsize:])
    return values


def main():
    hggmap, map_file, config, boxes, trajectory, out = sys.argv[1:]
    poses = [[float(v) for v in line.split()] for line in open(trajectory)]
    cars = [(*car[:4], car[4] + yaw_of(poses[car[5]])) for car in cars_of(boxes)]
    out = Path(out)
    subprocess.run([hggmap, "export", map_file, "--format", "grid", "-o", str(out / "ground"), "--config", config], check=True, capture_output=True)
    meta = json.loads((out / "ground.layers.json").read_text())
    cost, resolution = layer(meta, out, "cost", "B"), meta["resolution"]
    place = lambda cell: (meta["origin"][0] + (cell % meta["width"] + 0.5) * resolution, meta["origin"][1] + (cell // meta["width"] + 0.5) * resolution)
    cells = range(meta["width"] * meta["height"])
    walkable = [cell for cell in cells if cost[cell] <= 252]
    inside = sum(any(depth_inside(car, *place(cell)) > 0.3 for car in cars) for cell in walkable)
    near = [cell for cell in walkable if min(math.hypot(place(cell)[0] - p[1], place(cell)[1] - p[2]) for p in poses[::5]) < NEAR_WAY]
    draw = random.Random(1)
    pairs = [{"from": [*poses[0][1:3]], "to": [*poses[-8][1:3]]}]
    pairs += [{"from": [*place(draw.choice(near))], "to": [*place(draw.choice(near))]} for _ in range(PAIRS)]
    (out / "pairs.jsonl").write_text("".join(json.dumps(pair) + "\n" for pair in pairs))
    answers = subprocess.run([hggmap, "plan", map_file, "--batch", str(out / "pairs.jsonl"), "--config", config], check=True, capture_output=True, text=True)
    plans = [json.loads(line) for line in answers.stdout.splitlines()]
    through = 0
    for plan in plans:
        places = []
        for a, b in zip(plan["path"], plan["path"][1:]):
            steps = 1 + int(math.dist(a, b) / STRIDE)
            places += [(a[0] + (b[0] - a[0]) * k / steps, a[1] + (b[1] - a[1]) * k / steps) for k in range(steps + 1)]
        through += any(depth_inside(car, *p) > 0 for car in cars for p in places)
    along = plans[0]
    way = sum(math.dist(a[1:3], b[1:3]) for a, b in zip(poses, poses[1:-7]))
    good = along["found"] and along["length"] < 1.05 * way and through == 0
    print(f"{'ok' if good else 'FAILED'}: along the road {along.get('length', 0):.1f} m (driven {way:.1f}); of {PAIRS} other plans "
          f"{sum(p['found'] for p in plans[1:])} found, {through} through one of {len(cars)} parked cars; {inside} walkable columns inside them")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
