#!/usr/bin/env python3
"""Holds the answers to twenty questions about kitti_0001 against the annotated cars. The questions (tests/query/kitti_questions.jsonl:
text, where who asks stands and looks, track of the car that is meant) were written from the annotation before the mapper was asked.
An answer is right when the first thing of it lies within 1.5 m of the middle of that car's box. Standard library only.
usage: tests/kitti_questions.py HGGMAP MAP.hgg BOXES.csv      exit 1: fewer than 17 are right"""
import csv
import json
import math
import subprocess
import sys
from pathlib import Path

QUESTIONS = Path(__file__).parent / "query" / "kitti_questions.jsonl"
RADIUS = 1.5  # m, as hgg-eval matches outdoors
ASKED = 17


def cars_of(path):
    """(x, y) of each annotated car by its track, where it was nearest to the scanner."""
    cars = {}
    for row in csv.DictReader(open(path)):
        distance = math.hypot(float(row["cx_velo"]), float(row["cy_velo"]))
        if row["type"] == "Car" and distance < cars.get(int(row["track_id"]), (math.inf,))[0]:
            cars[int(row["track_id"])] = (distance, (float(row["cx_world"]), float(row["cy_world"])))
    return {track: place for track, (_, place) in cars.items()}


def main():
    hggmap, map_file, boxes = sys.argv[1:]
    cars = cars_of(boxes)
    questions = [json.loads(line) for line in QUESTIONS.read_text().splitlines()]
    # The batch has fields of its own beside text and from; hggmap is told nothing else.
    asked = "".join(json.dumps({"text": q["text"], "from": q["from"]}) + "\n" for q in questions)
    done = subprocess.run([hggmap, "query", map_file, "--no-goal", "--batch", "/dev/stdin"], input=asked, check=True, capture_output=True, text=True)
    right = 0
    for question, line in zip(questions, done.stdout.splitlines(), strict=True):
        answer = json.loads(line)
        first = answer["answers"][0] if answer["answers"] else None
        is_right = first is not None and math.dist(first["mean"][:2], cars[question["car"]]) <= RADIUS
        right += is_right
        if not is_right:
            nearest = min(cars, key=lambda c: math.dist(first["mean"][:2], cars[c])) if first else None
            print(f"  wrong: \"{question['text']}\": car {question['car']} is meant, {answer['status']}, nearest to car {nearest}; {answer['parse'].get('reading', '')}")
    print(f"{'ok' if right >= ASKED else 'FAILED'}: {right} of {len(questions)} questions right, {ASKED} asked")
    return 0 if right >= ASKED else 1


if __name__ == "__main__":
    sys.exit(main())
