"""Figures to the text of tables."""
import dataclasses
import statistics

NOT_YET = "not yet"
FAILED = "failed"


def dig(figures, path):
    """A number inside the figures; None where it is missing."""
    for key in path.split("."):
        figures = figures.get(key) if isinstance(figures, dict) else None
    return figures if isinstance(figures, (int, float)) else None


def spread(values, digits=2):
    """Mean and sample deviation: "0.91 ± 0.02"; "0.91 ± 0.02 (2 of 3)" where one has no value."""
    there = [v for v in values if v is not None]
    if not there:
        return "–"
    mean = statistics.fmean(there)
    text = f"{mean:.{digits}f}" if abs(mean) < 1e4 else f"{mean:.2e}"
    if len(there) > 1:
        deviation = statistics.stdev(there)
        text += f" ± {deviation:.{digits}f}" if abs(mean) < 1e4 else f" ± {deviation:.0e}"
    return text if len(there) == len(values) else f"{text} ({len(there)} of {len(values)})"


def cells(results, columns):
    """A cell per (path, digits) column over the seeds' figures; path None: a column no stage fills yet."""
    if not results:
        return ["not run"] * len(columns)
    if any("error" in r for r in results):
        return [FAILED] * len(columns)
    return [spread([dig(r, path) for r in results], digits) if any(dig(r, path) is not None for r in results) else NOT_YET
            for path, digits in columns]


def over_seeds(results, columns):
    """A cell per (path, how, digits) column: how, such as sum or max, makes one figure of all seeds'."""
    if not results:
        return ["not run"] * len(columns)
    if any("error" in r for r in results):
        return [FAILED] * len(columns)
    return [of_all([dig(r, path) for r in results], how, digits) if any(dig(r, "loops.asked") is not None for r in results) else NOT_YET
            for path, how, digits in columns]


def of_all(values, how, digits):
    there = [v for v in values if v is not None]
    return f"{how(there):.{digits}f}" if there else "–"


@dataclasses.dataclass
class Table:
    name: str
    title: str
    text: str
    header: list
    rows: list
    left: int = 1  # columns of words

    def markdown(self):
        rule = ["---"] * self.left + ["---:"] * (len(self.header) - self.left)
        return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in [self.header, rule, *self.rows])
