"""The table of real data: KITTI raw drive 0001."""
import json
import shutil
import sys
from pathlib import Path

from matrix.figures import cells
from matrix.workshop import REPO, compact, digest, hash_of, machine, save, words

REAL_POSES = {"true poses": "poses.txt", "a real front-end's": "odometry.txt"}


def real_rows(workshop, data):
    """KITTI raw drive 0001 with true poses and with a real front-end's odometry."""
    if not (data / "kitti_0001").is_dir():
        return []
    found = workshop.tried("real data", lambda: real_figures(workshop, data))
    columns = [("overall.truth", 0), ("overall.position_error.mean", 3), ("overall.recall", 2), ("overall.precision", 2), ("overall.f1", 2),
               ("trajectory.ate_rmse", 2), ("cost.frame_ms.p50", 1), ("cost.frame_ms.p99", 1)]
    return [[name, *cells([(found or {}).get(name, {"error": ""})], columns)] for name in REAL_POSES]


def real_commands(where, data, poses):
    """How one kind of poses is mapped and scored."""
    log, out = where / f"{poses}.lcm", where / poses.replace(".txt", "")
    config = REPO / "firmware_cfg" / "semantickitti" / "hggmap.toml"
    return [["hgg-convert", "semantickitti", where / "kitti", "-o", log, "--poses", where / "kitti" / poses],
            ["hggmap", "replay", log, "--config", config, "--out", out],
            ["hgg-eval", "--map", out / "map.hgg", "--truth", where / "truth", "--class", "car", "--radius", "1.5", "--trajectory",
             out / "trajectory.tum", "--times", where / "kitti" / "times.txt", "--log", log, "--json"]]


def real_preparation(where, data):
    return [[sys.executable, data / "unpack.py", data / "kitti_0001", where / "kitti"],
            ["hgg-convert", "kitti-truth", where / "kitti", "-o", where / "truth", "--boxes", data / "kitti_0001" / "boxes.csv"]]


def real_figures(workshop, data):
    """From the cache, whose key is all that goes in, or by running it."""
    named, config = (Path("OUT"), Path("DATA")), REPO / "firmware_cfg" / "semantickitti"
    commands = [*real_preparation(*named), *(c for poses in REAL_POSES.values() for c in real_commands(*named, poses))]
    files = [f for f in sorted((data / "kitti_0001").iterdir()) if f.is_file()]
    frames = [f"{f.name} {f.stat().st_size}" for f in sorted((data / "kitti_0001" / "frames").glob("*"))]
    where = workshop.out / "real" / digest(
        workshop.programs["hggmap"], workshop.programs["hgg-eval"], hash_of(workshop.build / "hgg-convert"), hash_of(data / "unpack.py"),
        hash_of(config / "hggmap.toml"), hash_of(config / "classes.toml"), *(f.name + hash_of(f) for f in files), *frames,
        *(word for command in commands for word in words(command)), machine())
    if not (where / "result.json").exists():
        save_real(workshop, data, where)
    return json.loads((where / "result.json").read_text())


def save_real(workshop, data, where):
    shutil.rmtree(where, ignore_errors=True)
    where.mkdir(parents=True)
    unpack, truth = real_preparation(where, data)
    workshop.execute(unpack)
    workshop.call(*truth)
    figures = {}
    for name, poses in REAL_POSES.items():
        convert, replay, score = real_commands(where, data, poses)
        workshop.call(*convert)
        workshop.call(*replay)
        figures[name] = compact(workshop.call(*score), " ".join(words(score)))
        (where / f"{poses}.lcm").unlink(missing_ok=True)
    shutil.rmtree(where / "kitti", ignore_errors=True)
    save(where / "result.json", figures)
