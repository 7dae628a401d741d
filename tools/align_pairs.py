#!/usr/bin/env python3
"""Holds `hggmap align` against simulated truth: submaps of drives through the simulator's worlds, aligned pair by pair.

Two drives through one world differ in all noise (labels, ranges, odometry). Each submap is a stretch of a drive, mapped in a frame
of its own: its odometry is turned about the vertical and shifted at random, as no two robots share an origin, so stuff tiles and
leaves differ too. A pair is positive where the submaps overlap by 40 % or more of the ground the smaller one has surveyed, negative
where they overlap by 2 % or less or are of different worlds; what lies between is left out.

  tools/align_pairs.py --build build --work /tmp/align                # everything: hours the first time, minutes from then on
  tools/align_pairs.py --build build --work /tmp/align --only office  # one world
  tools/align_pairs.py --build build --work /tmp/align --quick        # a few pairs of each world

Submaps are kept in --work, nothing in the repository. Writes WORK/align.md and WORK/align.json. Exit 0: the bounds hold; 1: they do
not; 2: a command failed, or there is nothing to judge. Standard library only.
"""
import argparse, concurrent.futures, itertools, json, math, pathlib, random, re, shutil, struct, subprocess, sys

REPO = pathlib.Path(__file__).resolve().parent.parent
MAX_ERROR, MAX_TURN = 0.3, 2.0  # m, deg: what counts as right
MIN_SUCCESS = 0.95
POSITIVE, NEGATIVE = 0.40, 0.02  # overlap
CELL = {"semantickitti": 2.0, "indoor": 0.5}  # m, of the ground
LOG_HEADER = struct.Struct(">IqqII")  # sync, number, time, bytes of the channel, bytes of the message
POSE = struct.Struct(">qq3d3d4d")  # fingerprint, utime, pos, vel, orientation (wxyz)

# name: arguments of hgg-sim, config, seconds of a submap, seconds between submaps, drives as (seed, noise seed)
KITTI_07 = ["--path", "{data}/kitti_trajectories/07_gt.txt", "{data}/kitti_trajectories/07_odometry.txt"]
WORLDS = {
    "street": (["street", "--rate", "5"], "semantickitti", 5, 5, [(1, 101), (1, 102), (2, 103)]),
    "campus": (["campus", "--rate", "5"], "semantickitti", 12, 10, [(1, 201), (1, 202), (2, 203)]),
    "office": (["office", "--sensor", "rgbd", "--rate", "5"], "indoor", 20, 7, [(1, 301), (1, 302), (2, 303)]),
    "apartment": (["apartment", "--sensor", "rgbd", "--rate", "5"], "indoor", 20, 7, [(1, 401), (1, 402), (2, 403)]),
    "hall": (["hall", "--sensor", "rgbd", "--rate", "5"], "indoor", 20, 7, [(5, 601), (5, 602), (6, 603)]),
    "path": (KITTI_07 + ["--rate", "5"], "semantickitti", 5, 6, [(1, 501), (1, 502), (2, 503)]),
}


# ------------------------------------------------------------------------------------------------ poses

def rotation_of(q):
    """The rotation matrix of a quaternion (w, x, y, z)."""
    w, x, y, z = q
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def transposed(a):
    return [list(row) for row in zip(*a)]


def turned(r, v):
    return [sum(r[i][k] * v[k] for k in range(3)) for i in range(3)]


def composed(a, b):
    """T_a_b T_b_c of (rotation, translation) pairs."""
    return product(a[0], b[0]), [x + y for x, y in zip(turned(a[0], b[1]), a[1])]


def inverse(a):
    r = transposed(a[0])
    return r, [-x for x in turned(r, a[1])]


def orthogonal(m):
    """The rotation nearest to a matrix that is almost one (Gram-Schmidt)."""
    x, y = m[0], m[1]
    x = [v / math.sqrt(sum(u * u for u in x)) for v in x]
    d = sum(a * b for a, b in zip(x, y))
    y = [b - d * a for a, b in zip(x, y)]
    y = [v / math.sqrt(sum(u * u for u in y)) for v in y]
    return [x, y, [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]]


def fitted(true_poses, map_poses):
    """T_world_map: the mean of the rotations and of the translations of a submap's frames."""
    n = len(true_poses)
    turns = [product(t[0], transposed(m[0])) for t, m in zip(true_poses, map_poses)]
    r = orthogonal([[sum(t[i][j] for t in turns) / n for j in range(3)] for i in range(3)])
    return r, [sum(t[1][k] - turned(r, m[1])[k] for t, m in zip(true_poses, map_poses)) / n for k in range(3)]


def difference(a, b):
    """Distance (m) and angle (deg) of two transforms of the same frames."""
    r = product(transposed(a[0]), b[0])
    cosine = max(-1.0, min(1.0, (r[0][0] + r[1][1] + r[2][2] - 1) / 2))
    return math.dist(a[1], b[1]), math.degrees(math.acos(cosine))


# ------------------------------------------------------------------------------------------------ submaps

def run(command, accept=(0,)):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode not in accept:
        print(f"failed ({done.returncode}): {' '.join(map(str, command))}\n{done.stderr[-500:]}", file=sys.stderr)
        sys.exit(2)
    return done


def events(log):
    """(time in us, channel, header, message) of an LCM log."""
    with open(log, "rb") as file:
        while len(header := file.read(LOG_HEADER.size)) == LOG_HEADER.size:
            _, _, time, channel_bytes, message_bytes = LOG_HEADER.unpack(header)
            channel = file.read(channel_bytes)
            yield time, channel, header, file.read(message_bytes)


def in_frame(message, yaw, shift):
    """An odometry message in a frame that is turned by `yaw` and shifted."""
    fields = list(POSE.unpack_from(message))
    c, s = math.cos(yaw), math.sin(yaw)
    x, y, z = fields[2:5]
    fields[2:5] = [c * x - s * y + shift[0], s * x + c * y + shift[1], z + shift[2]]
    w, i, j, k = fields[8:12]
    cw, sw = math.cos(yaw / 2), math.sin(yaw / 2)
    fields[8:12] = [cw * w - sw * k, cw * i - sw * j, cw * j + sw * i, cw * k + sw * w]
    return POSE.pack(*fields) + message[POSE.size:]


def cut(log, out, begin, end, rng):
    """The events of [begin, end) seconds after the log's beginning, with odometry in a frame of its own."""
    yaw, shift = rng.uniform(-math.pi, math.pi), [rng.uniform(-50, 50), rng.uniform(-50, 50), rng.uniform(-2, 2)]
    first = None
    with open(out, "wb") as file:
        for time, channel, header, message in events(log):
            first = time if first is None else first
            if not begin * 1e6 <= time - first < end * 1e6 or channel not in (b"POSE_ODOM", b"LIDAR_SEMANTIC"):
                continue
            file.write(header + channel + (in_frame(message, yaw, shift) if channel == b"POSE_ODOM" else message))


def read_tum(path):
    rows = [[float(v) for v in line.split()] for line in open(path)]
    return [(round(r[0] * 1e6), (rotation_of([r[7], *r[4:7]]), r[1:4])) for r in rows]


def read_poses(path):
    rows = [[float(v) for v in line.split()] for line in open(path)]
    return [([r[0:3], r[4:7], r[8:11]], [r[3], r[7], r[11]]) for r in rows]


def surveyed(graph, T, cell):
    """The ground cells that hold a leaf of a map, in the world's frame."""
    cells = set()
    for node in graph["objects"]:
        for leaf in node["geometry"]:
            p = turned(T[0], leaf["mean"])
            cells.add((math.floor((p[0] + T[1][0]) / cell), math.floor((p[1] + T[1][1]) / cell)))
    return cells


class Submap:
    """A map.hgg with what is true of it: place (world and seed), T_world_map, surveyed cells, objects in the world's frame."""

    def __init__(self, directory, truth):
        self.map, self.name = directory / "map.hgg", directory.parent.name + "/" + directory.name
        self.world, self.place = truth["world"], truth["place"]
        self.T = (truth["T"][0], truth["T"][1])
        self.cells = {tuple(c) for c in truth["cells"]}
        self.objects = truth["objects"]  # id -> truth id


def config_file(args, config):
    return REPO / "firmware_cfg" / config / "hggmap.toml"


def make_submap(build, config, log, poses, rate, begin, seconds, directory, cell, truth_objects, world, place):
    directory.mkdir(parents=True, exist_ok=True)
    part = directory / "part.lcm"
    cut(log, part, begin, begin + seconds, random.Random(f"{directory.parent.name}/{directory.name}"))
    run([build / "hggmap", "replay", part, "--config", config, "--out", directory])
    run([build / "hggmap", "export", directory / "map.hgg", "--format", "json", "-o", directory / "map.json"])
    part.unlink()
    track = read_tum(directory / "trajectory.tum")
    start_us = 1_000_000
    T = fitted([poses[round((t - start_us) * 1e-6 * rate)] for t, _ in track], [p for _, p in track])
    graph = json.load(open(directory / "map.json"))
    (directory / "map.json").unlink()
    truth = {"world": world, "place": place, "T": T, "cells": sorted(surveyed(graph, T, cell)),
             "objects": owners(graph, T, truth_objects)}
    json.dump(truth, open(directory / "truth.json", "w"))


def owners(graph, T, truth_objects):
    """Map node -> true object: each thing's nearest of its class within its size (at least 0.5 m)."""
    found = {}
    for node in graph["objects"]:
        if node["stuff"]:
            continue
        p = [a + b for a, b in zip(turned(T[0], node["mean"]), T[1])]
        near = [(math.dist(p, o["centroid"]), o["id"]) for o in truth_objects if o["label"] == node["label"]]
        reach = max(0.5, math.sqrt(node["cov"][0] + node["cov"][4] + node["cov"][8]))
        if near and min(near)[0] < reach:
            found[str(node["id"])] = min(near)[1]
    return found


def make_drive(args, name, seed, noise):
    """Simulates one drive and maps its submaps; returns their directories."""
    sim, config, seconds, step, _ = WORLDS[name]
    directory = args.work / f"{name}-{seed}-{noise}"
    if not (directory / "done").exists():
        shutil.rmtree(directory, ignore_errors=True)
        directory.mkdir(parents=True)
        log = directory / "drive.lcm"
        sim = [s.format(data=args.data) for s in sim]
        if "--path" not in sim:
            sim += ["--odometry", args.odometry]
        run([args.build / "hgg-sim", *sim, "-o", log, "--truth", directory / "truth", "--seed", seed, "--noise-seed", noise,
             "--threads", args.threads, "--labels", args.labels])
        rate = float(sim[sim.index("--rate") + 1])
        poses = read_poses(directory / "truth" / "poses.txt")
        objects = json.load(open(directory / "truth" / "gt_objects.json"))
        begin = 0
        while (begin + seconds) * rate <= len(poses):
            make_submap(args.build, config_file(args, config), log, poses, rate, begin, seconds, directory / f"{begin:04d}",
                        CELL[config], objects, name, f"{name}-{seed}")
            begin += step
        log.unlink()
        shutil.rmtree(directory / "truth")
        (directory / "done").touch()
    return [Submap(d, json.load(open(d / "truth.json"))) for d in sorted(directory.iterdir()) if (d / "truth.json").exists()]


# ------------------------------------------------------------------------------------------------ pairs

def overlap(a, b):
    """Share of the ground that the submap that surveyed less has in common with the other; None for different worlds."""
    return len(a.cells & b.cells) / min(len(a.cells), len(b.cells)) if a.place == b.place else None


def kind_of(a, b, share):
    if share is None:
        return "look-alike"
    if share >= POSITIVE and a.map.parent.parent != b.map.parent.parent:
        return "positive"
    return "elsewhere" if share <= NEGATIVE else None


def choose_pairs(drives, count):
    """At most `count` pairs of each kind, of submaps of all drives of a world."""
    submaps = [s for drive in drives for s in drive]
    chosen = {"positive": [], "elsewhere": [], "look-alike": []}
    for a, b in itertools.combinations(submaps, 2):
        share = overlap(a, b)
        if (kind := kind_of(a, b, share)) is not None:
            chosen[kind].append((kind, a, b, share))
    rng = random.Random(1)
    return [pair for pairs in chosen.values() for pair in rng.sample(pairs, min(count, len(pairs)))]


def centre_of(submap):
    """The middle of what a submap has surveyed, in its own frame."""
    cell = CELL[WORLDS[submap.world][1]]
    middle = [(sum(c[k] for c in submap.cells) / len(submap.cells) + 0.5) * cell for k in (0, 1)] + [0.0]
    r, t = inverse(submap.T)
    return [x + y for x, y in zip(turned(r, middle), t)]


def correspondences(answer, a, b):
    """True positives, answered pairs, and objects that both maps hold."""
    owner_a, owner_b = a.objects, b.objects
    right = {owner_a[str(i)] for i, j in answer["pairs"] if str(i) in owner_a and owner_a[str(i)] == owner_b.get(str(j))}
    return len(right), len(answer["pairs"]), len(set(owner_a.values()) & set(owner_b.values()))


def judge(args, pair):
    """One row of the report."""
    kind, a, b, share = pair
    answer = json.loads(run([args.build / "hggmap", "align", a.map, b.map, "--json"], accept=(0, 1)).stdout)
    row = {"world": a.world, "kind": kind, "a": a.name, "b": b.name, "overlap": share, **{
        k: answer[k] for k in ("accepted", "score", "threshold", "reason", "ms", "evidence")}}
    if kind == "positive":
        r, t = composed(inverse(a.T), b.T)
        m = answer["T_a_b"]
        found = ([m[0:3], m[4:7], m[8:11]], [m[3], m[7], m[11]])
        p = centre_of(b)  # not b's origin, which may be far from the map
        row["error"] = math.dist([x + y for x, y in zip(turned(r, p), t)],
                                 [x + y for x, y in zip(turned(found[0], p), found[1])])
        row["turn"] = difference(found, (r, t))[1]
        row["right"] = answer["accepted"] and row["error"] <= MAX_ERROR and row["turn"] <= MAX_TURN
        row["correspondences"] = correspondences(answer, a, b)
    return row


# ------------------------------------------------------------------------------------------------ report

def percentile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))] if values else float("nan")


def f1_of(rows):
    right, answered, there = (sum(r["correspondences"][k] for r in rows) for k in range(3))
    precision, recall = right / max(answered, 1), right / max(there, 1)
    return precision, recall, 2 * precision * recall / max(precision + recall, 1e-9)


def table(rows):
    lines = ["| world | positive | right | accepted wrongly | error m, p50 / p95 | turn deg, p50 / p95 | precision / recall / F1 "
             "| elsewhere: accepted | look-alike: accepted | ms, p50 / p95 |", "|---" * 10 + "|"]
    for world in [*sorted({r["world"] for r in rows}), "all"]:
        of = [r for r in rows if world in (r["world"], "all")]
        positive = [r for r in of if r["kind"] == "positive"]
        taken = [r for r in positive if r["accepted"]]
        negative = {k: [r for r in of if r["kind"] == k] for k in ("elsewhere", "look-alike")}
        right = sum(r["right"] for r in positive)
        cells = [world, len(positive), f"{right} ({100 * right / max(len(positive), 1):.1f} %)", len(taken) - right,
                 *(f"{percentile([r[k] for r in taken], 0.5):.3f} / {percentile([r[k] for r in taken], 0.95):.3f}"
                   for k in ("error", "turn")),
                 " / ".join(f"{v:.3f}" for v in f1_of(positive)) if positive else "-",
                 *(f"{sum(r['accepted'] for r in negative[k])} of {len(negative[k])}" for k in negative),
                 f"{percentile([r['ms'] for r in of], 0.5):.0f} / {percentile([r['ms'] for r in of], 0.95):.0f}"]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


def by_overlap(rows):
    lines = ["| overlap | positive | right |", "|---|---|---|"]
    for low in (0.4, 0.5, 0.6, 0.7, 0.8, 0.9):
        of = [r for r in rows if r["kind"] == "positive" and low <= min(r["overlap"], 0.999) < low + 0.1]
        if of:
            lines.append(f"| {low:.1f} .. {low + 0.1:.1f} | {len(of)} | {100 * sum(r['right'] for r in of) / len(of):.1f} % |")
    return "\n".join(lines)


def margins(rows):
    """How far the worst negative and the weakest right positive are from the threshold."""
    wrong = max((r for r in rows if r["kind"] != "positive"), key=lambda r: r["score"] - r["threshold"], default=None)
    right = [r["score"] - r["threshold"] for r in rows if r["kind"] == "positive"]
    lines = [f"score - threshold of the positives: 1 % {percentile(right, 0.01):.1f}, 5 % {percentile(right, 0.05):.1f}, "
             f"median {percentile(right, 0.5):.1f} nats"]
    if wrong:
        lines.append(f"the negative nearest to being accepted: {wrong['score'] - wrong['threshold']:.1f} nats "
                     f"({wrong['a']} and {wrong['b']}: {wrong['reason']})")
    return "\n".join(lines)


def failures(rows):
    bad = [r for r in rows if (r["kind"] == "positive" and not r["right"]) or (r["kind"] != "positive" and r["accepted"])]
    return "\n".join(f"- {r['kind']} {r['a']} {r['b']}: {'accepted' if r['accepted'] else 'refused'}, "
                     f"error {r.get('error', float('nan')):.2f} m {r.get('turn', float('nan')):.2f} deg, "
                     f"score {r['score']:.1f} of {r['threshold']:.1f}: {r['reason']}" for r in bad) or "none"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=REPO / "build")
    parser.add_argument("--work", type=pathlib.Path, required=True, help="keeps submaps; gets align.md and align.json")
    parser.add_argument("--data", type=pathlib.Path, default=REPO.parent / "shared" / "data", help="holds kitti_trajectories")
    parser.add_argument("--only", choices=WORLDS, action="append", help="this world (may be given again)")
    parser.add_argument("--pairs", type=int, default=60, help="of each kind in each world, at most [60]")
    parser.add_argument("--odometry", default="excellent", help="of the simulated drives [excellent]; --path worlds have their own")
    parser.add_argument("--labels", default="good", help="of the simulated segmenter [good]; give another --work for another choice")
    parser.add_argument("--threads", type=int, default=2, help="of the simulator [2]")
    parser.add_argument("--quick", action="store_true", help="5 pairs of each kind in each world")
    args = parser.parse_args()
    args.work.mkdir(parents=True, exist_ok=True)
    rows = []
    for name in args.only or WORLDS:
        if not (args.data / "kitti_trajectories").exists() and "--path" in WORLDS[name][0]:
            print(f"{name}: skipped, no kitti_trajectories in {args.data}", file=sys.stderr)
            continue
        drives = [make_drive(args, name, seed, noise) for seed, noise in WORLDS[name][4]]
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            rows += pool.map(lambda pair: judge(args, pair), choose_pairs(drives, 5 if args.quick else args.pairs))
        print(f"{name}: {len(rows)} pairs so far", file=sys.stderr)
    positive = [r for r in rows if r["kind"] == "positive"]
    if not positive:
        print(f"nothing to judge: {len(rows)} pairs, none of them of submaps that overlap", file=sys.stderr)
        sys.exit(2)
    report = "\n\n".join(["# Alignment of two maps", table(rows), by_overlap(rows), margins(rows), "Failures:", failures(rows)])
    (args.work / "align.md").write_text(report + "\n")
    json.dump(rows, open(args.work / "align.json", "w"), indent=1)
    print(report)
    wrong = [r for r in rows if r["accepted"] and not r.get("right", False)]
    sys.exit(0 if not wrong and sum(r["right"] for r in positive) >= MIN_SUCCESS * len(positive) else 1)


if __name__ == "__main__":
    main()
