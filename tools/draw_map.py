#!/usr/bin/env python3
"""Draws an exported graph from above: leaves as dots of their size, objects as two-sigma ellipses, edges, keyframes.

usage: tools/draw_map.py GRAPH.json -o PICTURE.png [--region x0,y0,x1,y1] [--names] [--regions] [--grid F.layers.json] [--plan PLAN.json]
example: hggmap export map.hgg --format json -o map.json && tools/draw_map.py map.json -o map.png
With --regions also which things are one region: rooms, rows of cars.
With --grid (hggmap export --format grid) also where a robot can walk: green well, red not at all; with --plan (hggmap plan
--json) a path on it.
Needs python3-matplotlib and python3-numpy.
"""
import argparse
import json
import os
import sys

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    from matplotlib.collections import EllipseCollection, LineCollection
except ImportError as missing:
    sys.exit(f"draw_map.py: {missing}; apt-get install python3-matplotlib python3-numpy")


# What a person expects of common classes; the rest takes the next colour of a palette.
COLOURS = {"road": "#8c8c9a", "sidewalk": "#b39ac0", "terrain": "#cbb78a", "building": "#a0522d", "vegetation": "#4c9f38",
           "fence": "#c08040", "trunk": "#6b4423", "pole": "#202020", "car": "#1f5fd0", "person": "#d02020",
           "bicyclist": "#ff7f0e", "on-rails": "#8e44ad", "wall": "#a0a0a0", "floor": "#d8d0c0"}


def ellipses(gaussians, sigmas):
    """Centres, widths, heights and angles (deg) of the horizontal ellipses of (mean, cov) pairs."""
    centres, widths, heights, angles = [], [], [], []
    for mean, cov in gaussians:
        values, vectors = np.linalg.eigh(np.array(cov).reshape(3, 3)[:2, :2])
        values = np.sqrt(np.maximum(values, 1e-4))
        centres.append(mean[:2])
        widths.append(2 * sigmas * values[1])
        heights.append(2 * sigmas * values[0])
        angles.append(np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))
    return centres, widths, heights, angles


def add(axes, gaussians, sigmas, **style):
    if gaussians:
        centres, widths, heights, angles = ellipses(gaussians, sigmas)
        axes.add_collection(
            EllipseCollection(widths, heights, angles, units="xy", offsets=centres, transOffset=axes.transData, **style))


def add_grid(axes, file):
    """Level 0 of an exported grid under everything else."""
    grid = json.load(open(file))
    cost = np.load(os.path.join(os.path.dirname(file), grid["layers"]["cost"]["file"]))[0]
    picture = np.zeros((*cost.shape, 4))
    walkable = cost <= 252
    worse = cost / 252
    picture[walkable] = np.stack([0.2 + 0.7 * worse, 0.75 - 0.2 * worse, np.full_like(worse, 0.3), np.full_like(worse, 0.6)], -1)[walkable]
    picture[cost == 254] = (0.8, 0.1, 0.1, 0.6)
    (x, y), r = grid["origin"], grid["resolution"]
    axes.imshow(picture, origin="lower", extent=(x, x + r * cost.shape[1], y, y + r * cost.shape[0]), zorder=0, interpolation="nearest")


def add_regions(axes, graph):
    """Each region in a colour of its own: its things, tied to its mean, its edges to other regions, and its name."""
    place = {o["id"]: o["mean"][:2] for o in graph["objects"]}
    middle = {region["id"]: region["mean"][:2] for region in graph["regions"]}
    axes.add_collection(LineCollection([(middle[a], middle[b]) for a, b, _ in graph["region_edges"]], colors="black",
                                       linewidths=0.8, linestyles="dotted", zorder=4))
    for k, region in enumerate(graph["regions"]):
        colour = plt.get_cmap("tab20")(k % 20)
        things = [place[id] for id in region["objects"]]
        axes.add_collection(LineCollection([(region["mean"][:2], p) for p in things], colors=[colour], linewidths=1.2, zorder=5))
        axes.plot(*zip(*things), "o", color=colour, markersize=7, markeredgecolor="black", markeredgewidth=0.6, zorder=6)
        axes.annotate(region["name"], region["mean"][:2], fontsize=9, fontweight="bold", ha="center", zorder=7,
                      bbox={"facecolor": "white", "alpha": 0.7, "pad": 1.5, "edgecolor": colour})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("graph")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--region", help="x0,y0,x1,y1 in metres")
    parser.add_argument("--names", action="store_true", help="write class names beside things")
    parser.add_argument("--regions", action="store_true", help="draw which things are one region")
    parser.add_argument("--grid", help="F.layers.json of hggmap export --format grid")
    parser.add_argument("--plan", help="the answer of hggmap plan --json")
    args = parser.parse_args()
    graph = json.load(open(args.graph))
    labels = sorted({o["label"] for o in graph["objects"]})
    name = {o["label"]: o["name"] for o in graph["objects"]}
    colour = {label: COLOURS.get(name[label], plt.get_cmap("tab20")(k % 20)) for k, label in enumerate(labels)}

    figure, axes = plt.subplots(figsize=(14, 7), layout="constrained")
    for label in labels:
        objects = [o for o in graph["objects"] if o["label"] == label]
        leaves = [(g["mean"], g["cov"]) for o in objects for g in o["geometry"]]
        add(axes, leaves, 1, facecolors=[colour[label]], alpha=0.35, linewidths=0)
        add(axes, [(o["mean"], o["cov"]) for o in objects if not o["stuff"]], 2, facecolors="none",
            edgecolors=[colour[label]], linewidths=1.6)
        axes.plot([], [], "o", color=colour[label], label=f"{name[label]} ({len(objects)})")
    mean = {o["id"]: o["mean"][:2] for o in graph["objects"]}
    axes.add_collection(LineCollection([(mean[a], mean[b]) for a, b, _ in graph["edges"]], colors="0.3", linewidths=0.3))
    path = np.array([k["pose"][:2] for k in graph["keyframes"]])
    if len(path):
        axes.plot(path[:, 0], path[:, 1], "k.-", linewidth=1, markersize=3, label="keyframes")
    if args.grid:
        add_grid(axes, args.grid)
    if args.plan:
        plan = np.array(json.load(open(args.plan))["path"] or np.empty((0, 3)))
        axes.plot(plan[:, 0], plan[:, 1], "-", color="#0030ff", linewidth=2.5, label="plan")
    if args.regions:
        add_regions(axes, graph)
    if args.names:
        for o in graph["objects"]:
            if not o["stuff"]:
                axes.annotate(o["name"], o["mean"][:2], fontsize=6)
    axes.autoscale()
    axes.set_aspect("equal")
    if args.region:
        x0, y0, x1, y1 = map(float, args.region.split(","))
        axes.set_xlim(x0, x1)
        axes.set_ylim(y0, y1)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.legend(loc="upper left", fontsize=8, ncols=2)
    figure.savefig(args.output, dpi=80)


main()
