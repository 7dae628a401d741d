"""The document and the page: docs/evaluation.md and .html."""
import dataclasses
import json

from matrix.figures import dig
from matrix.workshop import REPO

DOCUMENT = """# Evaluation

<!-- Written by tools/matrix/run.py; change the text there. -->

What the mapper does in worlds whose truth is known, measured by one command. The same figures to look at: [evaluation.html](evaluation.html).

    {command}

| | |
|---|---|
| commit | {commit} |
| programs | {programs} |
| machine | {machine} |
| date | {date} |
| seeds | {seeds}; figures are mean ± sample deviation over them |
| frames | {frames} |

A seed changes where objects stand, what the sensors get wrong and how odometry drifts. Labels are those of a good segmenter
(`hgg-sim --labels good`: speckle, bleeding borders, confused and missed objects), except in the real data. "{not_yet}": the
stage that would fill the figure does not exist yet.

A log holds odometry of every quality, on the channels `POSE_ODOM_TRUE`, `_EXCELLENT`, `_GOOD` and `_POOR`; `lcm.odometry` of
the config picks one. A run out of doors and one indoors by hand, as in the table of objects (with other sensors than these the
config's `creation.beam_spacing_deg` is theirs):

    sed 's/^odometry = "[A-Z_]*"/odometry = "POSE_ODOM_GOOD"/' firmware_cfg/semantickitti/hggmap.toml > firmware_cfg/semantickitti/good.toml
    hgg-sim street -o street.lcm --truth street_truth --sensor lidar64 --seed 1
    hggmap replay street.lcm --config firmware_cfg/semantickitti/good.toml --out out/street
    hgg-eval --map out/street/map.hgg --truth street_truth --trajectory out/street/trajectory.tum --log street.lcm --odometry-channel POSE_ODOM_GOOD --radius 1.5 --spacing 0.1 --html street.html

    sed 's/^odometry = "[A-Z_]*"/odometry = "POSE_ODOM_GOOD"/' firmware_cfg/indoor/hggmap.toml > firmware_cfg/indoor/good.toml
    hgg-sim office -o office.lcm --truth office_truth --sensor rgbd --seed 1
    hggmap replay office.lcm --config firmware_cfg/indoor/good.toml --out out/office
    hgg-eval --map out/office/map.hgg --truth office_truth --trajectory out/office/trajectory.tum --log office.lcm --odometry-channel POSE_ODOM_GOOD --radius 0.5 --spacing 0.05 --html office.html

`hgg-eval --help` says how it scores; [method.md](method.md) says what is computed, [experiments.md](experiments.md) what it was chosen over.

{tables}
"""


def section(table, info):
    return (f"## {table.title}\n\n{table.text.strip()}\n\n{table.markdown() if table.rows else 'Nothing was run for this table.'}\n\n"
            f"`{info['script']} --only {table.name}` · {info['commit']} · {info['machine']}\n")


def with_section(document, table, info):
    """The document with this table in place of the one under the same title; at the end where it has none."""
    made, head = section(table, info), f"## {table.title}\n"
    start = document.find("\n" + head) + 1
    if start == 0:
        return f"{document.rstrip()}\n\n{made}"
    end = document.find("\n## ", start)
    return document[:start] + made + (document[end:] if end >= 0 else "")


def charts(matrix):
    """What the page draws: a value per seed for every world and odometry, and a curve per world."""
    measures = {"F1": "overall.f1", "position error, m": "overall.position_error.mean", "ATE, m": "trajectory.ate_rmse", "Chamfer, m": "geometry.chamfer"}
    groups = [{"world": world, "odometry": odometry,
               **{name: [v for v in (dig(r, path) for r in matrix.results(matrix.runs(world, None, odometry))) if v is not None]
                  for name, path in measures.items()}}
              for world in matrix.args.worlds for odometry in matrix.args.odometry]
    curves = [{"world": run.drive.world, "memory": [[m["frame"], m["map_mb"]] for m in stats.get("memory", [])],
               "time": [[t["frame"], t["mean_ms"]] for t in stats.get("time", [])]} for run, stats in matrix.timing.items()]
    return {"measures": list(measures), "groups": groups, "odometry": matrix.args.odometry, "worlds": matrix.args.worlds, "curves": curves}


def page(tables, info, drawings):
    parts = REPO / "tools" / "eval" / "page"
    data = {**info, "tables": [dataclasses.asdict(t) for t in tables], "charts": drawings}
    script = (parts / "charts.js").read_text() + (REPO / "tools" / "matrix" / "page.js").read_text()
    text = (parts / "run.html").read_text()
    for mark, content in (("/*STYLE*/", (parts / "style.css").read_text()), ("/*SCRIPT*/", script),
                          ("/*DATA*/", json.dumps(data).replace("<", "\\u003c"))):
        text = text.replace(mark, content, 1)
    return text
