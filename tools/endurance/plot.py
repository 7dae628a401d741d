#!/usr/bin/env python3
"""Plots what hgg-endurance wrote: memory against the way, and says whether it kept its promises.

usage: plot.py DIR [PICTURE.png]      exit 0: kept, 1: not, with the reasons
"""
import csv
import json
import sys
from pathlib import Path


def plot(rows, report, picture):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    way = [float(r["way_m"]) / 1000 for r in rows]
    figure, axes = plt.subplots(figsize=(7, 3.6))
    axes.plot(way, [float(r["map_mb"]) for r in rows], label="map in memory", color="tab:blue")
    axes.plot(way, [float(r["rss_mb"]) for r in rows], label="process (RSS)", color="tab:gray")
    axes.axhline(report["budget_mb"], label="memory.budget_mb", color="tab:red", linestyle="--", linewidth=1)
    axes.set_xlabel("way driven, km")
    axes.set_ylabel("memory, MB")
    axes.set_ylim(bottom=0)
    axes.set_xlim(left=0)
    axes.legend(loc="best")
    axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(picture, dpi=130)


def broken(report):
    """What was promised and not kept."""
    lines = []
    if report["peak_map_mb"] > report["budget_mb"]:
        lines.append(f"the map took {report['peak_map_mb']:.1f} MB of {report['budget_mb']:.0f}")
    first, last = report["frame_ms_p99_first_tenth"], report["frame_ms_p99_last_tenth"]
    if last > 1.2 * first:
        lines.append(f"frames p99: {first:.1f} ms in the first tenth, {last:.1f} ms in the last")
    doubled = sum(n for found, n in report["start_things_by_nodes_last"].items() if int(found) > 1)
    if doubled > sum(n for found, n in report["start_things_by_nodes_first"].items() if int(found) > 1):
        lines.append(f"{doubled} things at the start are in the map twice")
    laps = report.get("laps", [])
    if len(laps) >= 6:
        grown = laps[5]["map_mb"] - laps[4]["map_mb"]
        if grown > 0.005 * laps[0]["map_mb"]:
            lines.append(f"lap 6 added {grown:.3f} MB to the {laps[0]['map_mb']:.3f} MB of lap 1")
    return lines


def main(argv):
    if len(argv) not in (2, 3):
        print(__doc__)
        return 2
    directory = Path(argv[1])
    report = json.loads((directory / "endurance.json").read_text())
    if len(argv) == 3:
        with open(directory / "memory.csv", newline="") as file:
            plot(list(csv.DictReader(file)), report, argv[2])
    lines = broken(report)
    # Doubles are looked for within a metre of the true place: a drive that comes back far off shows none.
    print("\n".join(lines) or f"every promise was kept; loops closed: {report['loops']}")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
