"""Answers to a world's own queries, held against the truth."""
import json

KINDS = ["unique", "relational", "disambiguation"]
RELATIONS, SUPERLATIVES = (" next to ", " closest to ", " farthest from "), ("the largest ", "the smallest ", "the tallest ")


def kind_of(text):
    """What makes the target of a generated query the only one: its class, an anchor, or a superlative."""
    return "relational" if any(r in text for r in RELATIONS) else "disambiguation" if text.startswith(SUPERLATIVES) else "unique"


def score(queries, answers, matches):
    """Counts by kind: queries, targets that the map has, right among the first one and the first three answers."""
    node_of = {match["truth"]: match["id"] for match in matches}
    counts = {kind: [0, 0, 0, 0] for kind in KINDS}
    for query, answer in zip(queries, answers, strict=True):
        count, node = counts[kind_of(query["text"])], node_of.get(query["target"])
        found = [a["id"] for a in answer["answers"]]
        for k, holds in enumerate((True, node is not None, node in found[:1], node in found[:3])):
            count[k] += holds
    return counts


def lines_of(text):
    return [json.loads(line) for line in text.splitlines()]
