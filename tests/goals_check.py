#!/usr/bin/env python3
"""Part of goals_test.sh: chooses what to ask for, and holds the replies that were heard against the truth of the world.

usage: goals_check.py choose TRUTH | check TRUTH ASKED.jsonl HEARD.lcm
"""
import ast
import json
import math
import statistics
import struct
import sys
from pathlib import Path

SEEN = 40  # frames that an object was seen in: more than are left of the drive when it is asked for
NEAR, IN_TIME_MS = 1.0, 1000  # m from the surface; the latency that is asked for is 100 ms, on an idle machine
FREE, BLOCKED = 0, 1  # walk_grid's `standing`


def objects(truth):
    return {o["id"]: o for o in json.loads((truth / "gt_objects.json").read_text())}


def choose(truth):
    """The first thing that its class alone tells, and the first two of other classes that are told by another thing."""
    seen = {k for k, o in objects(truth).items() if o["frames"] >= SEEN}
    queries = [q for q in map(json.loads, (truth / "queries.jsonl").open()) if q["target"] in seen]
    chosen = [q for q in queries if q["text"] == f"the {q['class']}"][:1]
    for query in queries:
        if " next to " in query["text"] and query["class"] not in {q["class"] for q in chosen} and len(chosen) < 3:
            chosen.append(query)
    if len(chosen) < 3:
        sys.exit("goals_check: too few objects were seen well")
    for query in chosen:
        print(json.dumps(query))


def surface(truth, target):
    """The points of an object's surface, map frame."""
    with open(truth / "cloud.ply", "rb") as file:
        while file.readline().strip() != b"end_header":
            pass
        return [(x, y, z) for x, y, z, _, owner in struct.iter_unpack("<3fHI", file.read()) if owner == target]


def npy(path):
    with open(path, "rb") as file:
        file.seek(8)
        head = ast.literal_eval(file.read(struct.unpack("<H", file.read(2))[0]).decode())
        code = {"|u1": "B", "<u2": "H", "<u4": "I", "<f4": "f"}[head["descr"]]
        return [v for v, in struct.iter_unpack("<" + code, file.read())]


class Ground:
    def __init__(self, truth):
        self.about = json.loads((truth / "walk_grid.json").read_text())
        layers = {name: npy(truth / file) for name, file in self.about["layers"].items() if name in ("cell", "height", "standing", "island")}
        self.columns = {}
        for cell, height, standing, island in zip(layers["cell"], layers["height"], layers["standing"], layers["island"]):
            self.columns.setdefault(cell, []).append((height, standing, island))

    def at(self, p):
        """What the surface nearest to a place of the map is: its distance, how one stands there, whether it is an island."""
        T = self.about["T_grid_map"]
        x, y, z = (sum(T[4 * r + k] * p[k] for k in range(3)) + T[4 * r + 3] for r in range(3))
        column = math.floor((x - self.about["origin"][0]) / self.about["resolution"])
        row = math.floor((y - self.about["origin"][1]) / self.about["resolution"])
        surfaces = self.columns.get(row * self.about["width"] + column, [])
        return min(((abs(h - z), standing, island) for h, standing, island in surfaces), default=(math.inf, BLOCKED, 1))


def events(path):
    with open(path, "rb") as file:
        while header := file.read(28):
            _, _, utime, channel, data = struct.unpack(">IqqII", header)
            yield utime, file.read(channel).decode(), file.read(data)


def judge(query, reply, truth, ground):
    """Lines of what is wrong."""
    wrong = []
    if not reply.num_answers or reply.num_waypoints == 0:
        return [f"no answer with a way: status {reply.status}, {reply.text} {reply.goal_reason}"]
    if reply.goal_kind != reply.REACHABLE:
        wrong.append(f"not reached: {reply.goal_reason}")
    target = surface(truth, query["target"])
    gap = min(math.dist(p[:2], reply.goal[:2]) for p in target)
    if gap > NEAR:
        found = min((math.dist(o["centroid"], reply.answers[0].mean), k) for k, o in objects(truth).items())[1]
        wrong.append(f"the goal is {gap:.2f} m from object {query['target']}, led to object {found}: {reply.answers[0].reason}")
    height, standing, island = ground.at(reply.goal)
    if standing != FREE or island or height > 0.2:
        wrong.append(f"the goal stands on no free ground: {height:.2f} m off it, standing {standing}, island {island}")
    path = list(zip(reply.path_x, reply.path_y, reply.path_z))
    for a, b in zip(path, path[1:]):
        steps = max(1, math.ceil(math.dist(a, b) / 0.05))
        for k in range(steps + 1):
            p = [u + (v - u) * k / steps for u, v in zip(a, b)]
            if ground.at(p)[1] == BLOCKED:
                wrong.append(f"the way leads over blocked ground at {p[0]:.2f} {p[1]:.2f}")
                return wrong
    return wrong


def check(truth, asked, heard):
    from bot_core import pose_t
    from hgg import goal_query_t, goal_reply_t
    ground, queries = Ground(truth), {q["text"]: q for q in map(json.loads, open(asked))}
    sent, answered, targets, failed = {}, {}, 0, False
    for utime, channel, data in events(heard):
        if channel == "GOAL_QUERY":
            query = goal_query_t.decode(data)
            sent.setdefault(query.request_id, (utime, query.text))
        elif channel == "GOAL_REPLY":
            reply = goal_reply_t.decode(data)
            answered.setdefault(reply.request_id, (utime, reply))
        elif channel == "NAV_TARGET":
            pose_t.decode(data)
            targets += 1
    latencies = []
    for request, (asked_us, text) in sent.items():
        if request not in answered:
            sys.exit(f"goals_test: FAILED: no reply to \"{text}\"")
        heard_us, reply = answered[request]
        latencies.append((heard_us - asked_us) / 1000)
        wrong = judge(queries[text], reply, truth, ground)
        print(f"goals_test: \"{text}\": {latencies[-1]:.0f} ms, {reply.path_length:.1f} m to walk{''.join('; WRONG: ' + w for w in wrong)}")
        failed |= bool(wrong)
    if failed or len(sent) != len(queries):
        sys.exit("goals_test: FAILED")
    if targets == 0:
        sys.exit("goals_test: FAILED: nobody was led along a way (NAV_TARGET)")
    if statistics.median(latencies) > IN_TIME_MS:
        sys.exit(f"goals_test: FAILED: answers took {latencies} ms")
    print(f"goals_test: {len(sent)} goals right, median {statistics.median(latencies):.0f} ms, {targets} points led to")


if __name__ == "__main__":
    if sys.argv[1:2] == ["choose"]:
        choose(Path(sys.argv[2]))
    else:
        check(Path(sys.argv[2]), sys.argv[3], sys.argv[4])
